#include "core/periodic_schedule.h"

#include <cstdint>
#include <limits>

#include <gtest/gtest.h>

#include "tests/realtime/fake_clock.h"

namespace tandem::core {
namespace {

using test::FakeClock;

// 10^9 / 1024 = 976562.5 ns, so odd slots fall on halves, which are rounded up.
TEST(PeriodicSchedule, SlotsAt1024HzAreDueWhereHandComputationPutsThem) {
  const PeriodicSchedule schedule(1'000, 1024.0);
  EXPECT_EQ(schedule.due_ns(0), 1'000);
  EXPECT_EQ(schedule.due_ns(1), 1'000 + 976'563);
  EXPECT_EQ(schedule.due_ns(2), 1'000 + 1'953'125);
  EXPECT_EQ(schedule.due_ns(3), 1'000 + 2'929'688);
  EXPECT_EQ(schedule.due_ns(1024), 1'000 + 1'000'000'000);
}

// 1024 slots are exactly a second, so after a year of seconds no nanosecond may be missing.
TEST(PeriodicSchedule, DoesNotDriftInAYear) {
  const PeriodicSchedule schedule(17, 1024.0);
  const std::int64_t seconds = 365LL * 86'400;
  EXPECT_EQ(schedule.due_ns(seconds * 1024), 17 + seconds * 1'000'000'000);
  EXPECT_EQ(schedule.due_ns(seconds * 1024 + 2), 17 + seconds * 1'000'000'000 + 1'953'125);
}

// Thirds of a nanosecond never add up: 3 slots at 3 kHz are a millisecond, for ever.
TEST(PeriodicSchedule, RoundsARateWithoutAWholePeriodToTheNearestNanosecond) {
  const PeriodicSchedule schedule(0, 3000.0);
  EXPECT_EQ(schedule.due_ns(1), 333'333);
  EXPECT_EQ(schedule.due_ns(2), 666'667);
  EXPECT_EQ(schedule.due_ns(3'000'000'000'001), 1'000'000'000'000'333'333);
}

TEST(PeriodicSchedule, TakesARateThatIsNotWholeAtItsExactValue) {
  const PeriodicSchedule schedule(0, 62.5);  // 16 ms
  EXPECT_EQ(schedule.due_ns(1), 16'000'000);
  EXPECT_EQ(schedule.due_ns(1'000'000'007), 16'000'000'112'000'000);
}

TEST(PeriodicSchedule, NewestDueSlotIsTheInverseOfTheDueTime) {
  for (const double rate : {1.0, 62.5, 999.7, 1000.0, 1024.0, 3000.0, 1e6}) {
    const PeriodicSchedule schedule(123'456'789, rate);
    for (const std::int64_t slot : {1LL, 2LL, 3LL, 1023LL, 99'999LL, 1'000'000'007LL}) {
      const std::int64_t due = schedule.due_ns(slot);
      EXPECT_EQ(schedule.slot_at(due), slot) << rate;
      EXPECT_EQ(schedule.slot_at(due - 1), slot - 1) << rate;
    }
    EXPECT_EQ(schedule.slot_at(0), 0);
  }
}

TEST(PeriodicSchedule, RunsEverySlotOnceInOrderWhenOnTime) {
  FakeClock clock(-5'000'000);
  PeriodicSchedule schedule(0, 1024.0);
  for (std::int64_t k = 0; k < 10'000; ++k) {
    const auto wake = schedule.wait(clock);
    ASSERT_EQ(wake.slot, k);
    ASSERT_EQ(wake.missed, 0);
    ASSERT_EQ(wake.lateness_ns, 0);
    ASSERT_EQ(wake.woke_ns, schedule.due_ns(k));
    clock.advance(100'000);  // the tick's work
  }
  EXPECT_EQ(schedule.missed(), 0);
}

TEST(PeriodicSchedule, ALateTickWithinItsSlotRunsAtOnceAndIsNotMissed) {
  FakeClock clock;
  PeriodicSchedule schedule(0, 1000.0);
  ASSERT_EQ(schedule.wait(clock).slot, 0);
  clock.advance(1'300'000);  // overran slot 1 by 0.3 ms
  const int sleeps = clock.sleeps();
  const auto wake = schedule.wait(clock);
  EXPECT_EQ(wake.slot, 1);
  EXPECT_EQ(wake.missed, 0);
  EXPECT_EQ(wake.lateness_ns, 300'000);
  EXPECT_EQ(clock.sleeps(), sleeps);
  EXPECT_EQ(schedule.wait(clock).slot, 2);
  EXPECT_EQ(clock.now_ns(), 2'000'000);
}

TEST(PeriodicSchedule, MissedSlotsAreCountedAndSkippedNeverRunInABurst) {
  FakeClock clock;
  PeriodicSchedule schedule(0, 1000.0);
  ASSERT_EQ(schedule.wait(clock).slot, 0);
  clock.advance(5'400'000);
  auto wake = schedule.wait(clock);
  EXPECT_EQ(wake.slot, 5);  // 1 to 4 are gone
  EXPECT_EQ(wake.missed, 4);
  EXPECT_EQ(wake.due_ns, 5'000'000);
  EXPECT_EQ(wake.lateness_ns, 4'400'000);  // slot 1 was awaited
  wake = schedule.wait(clock);
  EXPECT_EQ(wake.slot, 6);
  EXPECT_EQ(wake.woke_ns, 6'000'000);
  EXPECT_EQ(schedule.missed(), 4);
}

TEST(PeriodicSchedule, OversleepingIsSeenAndSkippedToo) {
  FakeClock clock;
  PeriodicSchedule schedule(0, 1000.0);
  ASSERT_EQ(schedule.wait(clock).slot, 0);
  clock.oversleep_once(3'100'000);  // awaited 1 at 1 ms, woke at 4.1 ms
  const auto wake = schedule.wait(clock);
  EXPECT_EQ(wake.slot, 4);
  EXPECT_EQ(wake.missed, 3);
  EXPECT_EQ(wake.lateness_ns, 3'100'000);
}

TEST(PeriodicSchedule, SpinningSleepsUntilTheWindowAndWakesOnTheDeadline) {
  FakeClock clock;
  clock.set_cost_of_a_look(50);
  PeriodicSchedule schedule(1'000'000, 1000.0, 120'000);
  clock.oversleep_once(70'000);  // inside the window: hidden by the spin
  const auto wake = schedule.wait(clock);
  EXPECT_EQ(clock.last_deadline_ns(), 880'000);
  EXPECT_GE(wake.lateness_ns, 0);
  EXPECT_LE(wake.lateness_ns, 50);  // one look at the clock
}

TEST(PeriodicSchedule, NeverRunsASlotEarlyEvenIfTheSleepEndsEarly) {
  FakeClock clock;
  clock.set_cost_of_a_look(1'000);
  PeriodicSchedule schedule(1'000'000, 1000.0);
  clock.oversleep_once(-200'000);
  EXPECT_GE(schedule.wait(clock).woke_ns, 1'000'000);
}

TEST(PeriodicSchedule, ALateJoinerStartsAtItsFirstSlot) {
  FakeClock clock(10'000'000'123);
  PeriodicSchedule schedule(0, 1024.0, 0, 10'241);
  const auto wake = schedule.wait(clock);
  EXPECT_EQ(wake.slot, 10'241);
  EXPECT_EQ(wake.missed, 0);
}

TEST(PeriodicSchedule, RefusesRatesThatAreNotSensible) {
  for (const double rate : {0.0, -1.0, 0.5, 2e6, std::numeric_limits<double>::quiet_NaN(),
                            std::numeric_limits<double>::infinity()}) {
    EXPECT_THROW(PeriodicSchedule(0, rate), std::invalid_argument) << rate;
  }
}

// The real clock: never early, and the slots are those of the wall.
TEST(PeriodicSchedule, OnTheMonotonicClockNoSlotRunsBeforeItIsDue) {
  MonotonicClock clock;
  const std::int64_t start = clock.now_ns() + 2'000'000;
  PeriodicSchedule schedule(start, 1024.0);
  std::int64_t last = -1;
  for (int k = 0; k < 100; ++k) {
    const auto wake = schedule.wait(clock);
    ASSERT_GE(clock.now_ns(), schedule.due_ns(wake.slot));
    ASSERT_EQ(wake.slot, last + 1 + wake.missed);
    last = wake.slot;
  }
}

}  // namespace
}  // namespace tandem::core
