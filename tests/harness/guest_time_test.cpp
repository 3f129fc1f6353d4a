#include "harness/guest_time.h"

#include <gtest/gtest.h>

namespace tandem::harness {
namespace {

constexpr std::int64_t kMillisecond = 1'000'000;
constexpr std::int64_t kSlower = GuestTime::kSlower, kStep = GuestTime::kStep;

TEST(GuestTime, StartsWithTheHostsAndGoesSlowerWhileTheGuestComputes) {
  GuestTime time(5000);
  EXPECT_EQ(time.at(5000), 5000);
  EXPECT_EQ(time.at(5000 + 10 * kSlower), 5010);
  EXPECT_EQ(time.at(5000 + 30 * kSlower), 5030);
}

TEST(GuestTime, NeverGoesBackWhenTheHostsClockIsReadInAnotherOrder) {
  GuestTime time(0);
  const std::int64_t later = time.at(100 * kSlower);
  EXPECT_EQ(time.at(50 * kSlower), later);
  EXPECT_EQ(time.at(100 * kSlower), later);
}

// The host ran somebody else for 50 ms: the timer that was due in 1 ms is not late.
TEST(GuestTime, AStallEndsWhereTheTimerRings) {
  GuestTime time(0);
  time.arm(0, kMillisecond);
  EXPECT_EQ(time.at(50 * kMillisecond), kMillisecond);
  // It has rung and is being served: another stall counts a step, not what it took.
  EXPECT_EQ(time.at(100 * kMillisecond), kMillisecond + kStep);
}

TEST(GuestTime, WithoutATimerItGoesOn) {
  GuestTime time(0);
  time.arm(0, kMillisecond);
  time.arm(0, 0);
  EXPECT_EQ(time.at(kMillisecond * kSlower), kMillisecond);
}

TEST(GuestTime, IdleTimeIsSkippedToTheTimer) {
  GuestTime time(0);
  EXPECT_FALSE(time.skip_to_timer()) << "nothing to wait for";
  time.arm(0, 3 * kMillisecond);
  EXPECT_TRUE(time.skip_to_timer());
  EXPECT_EQ(time.at(0), 3 * kMillisecond);
  time.resume(70 * kMillisecond);  // the host slept on
  EXPECT_EQ(time.at(70 * kMillisecond), 3 * kMillisecond);
  EXPECT_TRUE(time.skip_to_timer()) << "a timer that has passed rings at once";
  EXPECT_EQ(time.at(70 * kMillisecond), 3 * kMillisecond);
}

// A loop of 1 kHz whose host takes the processor away for 0 to 20 ms anywhere: it wakes late by no
// more than a step and what one reading counts.
TEST(GuestTime, APeriodicLoopIsNeverLate) {
  GuestTime time(0);
  std::int64_t host = 0, due = 0;
  std::uint64_t random = 1;
  for (int k = 0; k < 10'000; ++k) {
    due += kMillisecond;
    const std::int64_t now = time.at(host);
    ASSERT_LT(now, due);
    time.arm(host, due - now);
    random = random * 6364136223846793005u + 1442695040888963407u;
    host += static_cast<std::int64_t>(random >> 40) % (20 * kMillisecond);
    if (k % 2 == 0) {
      (void)time.at(host);  // in the middle of something
    } else {
      ASSERT_TRUE(time.skip_to_timer());
      time.resume(host);
    }
    ASSERT_TRUE(time.skip_to_timer());
    time.resume(host);
    ASSERT_EQ(time.at(host), due);
  }
}

}  // namespace
}  // namespace tandem::harness
