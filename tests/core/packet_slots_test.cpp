#include "core/packet_slots.h"

#include <cstdint>

#include <gtest/gtest.h>

namespace tandem::core {
namespace {

struct Ratio {
  double local_hz, packet_hz;
  std::int64_t ticks, packets;
};

const Ratio kRatios[] = {{1024, 128, 8, 1},      {1000, 128, 125, 16},
                         {1024, 100, 256, 25},   {1024, 93.0909090909091, 11, 1},
                         {1024, 102.4, 10, 1},   {1024, 127.9, 10240, 1279},
                         {1000, 150, 20, 3},     {1024, 1024, 1, 1},
                         {1000, 999, 1000, 999}, {20000, 1.0 / 3.0 * 100, 600, 1}};

TEST(PacketSlots, RatesBecomeTheFractionTheyStandFor) {
  for (const Ratio& r : kRatios) {
    const PacketSlots slots = PacketSlots::of(r.local_hz, r.packet_hz);
    EXPECT_EQ(slots.ticks, r.ticks) << r.packet_hz;
    EXPECT_EQ(slots.packets, r.packets) << r.packet_hz;
  }
}

// Stepped and closed form against the rule in the comment: the first tick t with t packets >= k
// ticks (own timer: the last with t packets <= k ticks), in integers.
TEST(PacketSlots, SteppedTicksAndTheClosedFormFollowTheRule) {
  for (const Ratio& r : kRatios)
    for (const PacketTimer timer : {PacketTimer::kForceLoop, PacketTimer::kOwn}) {
      PacketSlots slots{r.ticks, r.packets, timer};
      PacketTicks ticks(slots);
      std::int64_t sent = 0;
      for (std::int64_t t = 0; t < 3 * r.ticks && t < 40000; ++t) {
        const bool sends = timer == PacketTimer::kOwn ? (t + 1) * r.packets > sent * r.ticks
                                                      : t * r.packets >= sent * r.ticks;
        ASSERT_EQ(ticks.due(t), sends) << r.packet_hz << " tick " << t;
        ASSERT_EQ(slots.sends(t), sends) << r.packet_hz << " tick " << t;
        if (sends) {
          ASSERT_EQ(slots.tick_of(sent), t);
          if (timer == PacketTimer::kOwn) {
            // k / packet_hz in ticks, exact in doubles at these sizes but for one rounding.
            ASSERT_NEAR(static_cast<double>(t) + ticks.late(),
                        static_cast<double>(sent) * static_cast<double>(r.ticks) /
                            static_cast<double>(r.packets),
                        1e-9);
          }
          ++sent;
        }
        ASSERT_EQ(slots.packet_at(t), sent - 1);
      }
    }
}

TEST(PacketSlots, AfterADayNothingHasDrifted) {
  const PacketSlots slots = PacketSlots::of(1000.0, 128.0);
  const std::int64_t day = 24LL * 3600;
  PacketTicks ticks(slots);
  std::int64_t sent = 0;
  for (std::int64_t t = 0; t < day * 1000; t += 1) {
    // Only the walk is tested here; the rule is in the test above.
    if (ticks.due(t)) ++sent;
  }
  EXPECT_EQ(sent, day * 128);
  EXPECT_TRUE(ticks.due(day * 1000));  // a whole number of seconds is a packet instant again
  EXPECT_EQ(slots.packet_at(day * 1000), day * 128);
  EXPECT_EQ(slots.tick_of(day * 128), day * 1000);
  EXPECT_FALSE(slots.sends(day * 1000 + 7));
  EXPECT_TRUE(slots.sends(day * 1000 + 8));  // 7.8125 ticks later
}

}  // namespace
}  // namespace tandem::core
