// What a node does with a prediction of its scene's stability and the delay it measures.

#include "node/stability_guard.h"

#include <gtest/gtest.h>

namespace tandem::node {
namespace {

constexpr double kTick = 1e-3;  // [s]

/// Stable up to 9 ticks, and nobody looked further.
StabilityGuard guard(bool refuses, int* asked = nullptr) {
  StabilityPrediction p;
  p.known = true;
  p.text = "predicted";
  p.largest_stable_ticks = 9;
  p.growth = [](int ticks) { return ticks > 9 ? 1.2 : 0.9; };
  p.advice = [asked](int ticks) {
    if (asked != nullptr) *asked = ticks;
    return std::string("lower k to 5");
  };
  return {std::move(p), refuses, kTick};
}

/// So many looks, 20 ms apart, from `from` on, at one round trip; what was said last.
StabilityGuard::Finding looks(StabilityGuard& g, double from, int count, double round_trip) {
  StabilityGuard::Finding last;
  for (int i = 0; i < count; ++i) {
    StabilityGuard::Finding f = g.look(from + 0.02 * i, round_trip);
    if (!f.text.empty()) last = std::move(f);
  }
  return last;
}

TEST(DelayMedian, NeedsNearlyASecondAndForgetsWhatIsOlder) {
  DelayMedian m;
  for (int i = 0; i < 40; ++i) m.record(0.02 * i, 0.001);
  EXPECT_FALSE(m.value().has_value());
  for (int i = 40; i < 60; ++i) m.record(0.02 * i, 0.001);
  EXPECT_DOUBLE_EQ(m.value().value(), 0.001);
  m.record(1.2, 5.0);  // one late packet changes nothing
  EXPECT_DOUBLE_EQ(m.value().value(), 0.001);
  for (int i = 61; i < 120; ++i) m.record(0.02 * i, 0.03);
  EXPECT_DOUBLE_EQ(m.value().value(), 0.03);
}

// On each way a packet waits half a tick on average until it is used: 3 ms are 4 ticks of 1 ms.
TEST(StabilityGuard, SaysHowMuchDelayIsLeft) {
  StabilityGuard g = guard(true);
  EXPECT_EQ(g.at_start().text, "predicted");
  EXPECT_FALSE(g.at_start().refuses);
  const auto f = looks(g, 0.0, 60, 0.003);
  EXPECT_NE(f.text.find("4.0 ticks"), std::string::npos) << f.text;
  EXPECT_NE(f.text.find("5.5 more"), std::string::npos) << f.text;
  EXPECT_FALSE(f.refuses);
}

TEST(StabilityGuard, RefusesBeyondTheLimitWithAdviceForThatDelay) {
  int asked = 0;
  StabilityGuard g = guard(true, &asked);
  const auto f = looks(g, 0.0, 60, 0.015);
  EXPECT_TRUE(f.refuses);
  EXPECT_EQ(asked, 16);
  EXPECT_NE(f.text.find("lower k to 5"), std::string::npos) << f.text;
}

TEST(StabilityGuard, WarnsOnceAndTellsWhenItIsBack) {
  StabilityGuard g = guard(false);
  auto f = looks(g, 0.0, 60, 0.015);
  EXPECT_FALSE(f.refuses);
  EXPECT_NE(f.text.find("unstable"), std::string::npos);
  EXPECT_TRUE(looks(g, 1.2, 60, 0.015).text.empty()) << "said already";
  // 8.3 ms are 9.3 ticks: inside by the limit of 9.5, not by the half tick of hysteresis.
  EXPECT_TRUE(looks(g, 2.4, 100, 0.0083).text.empty());
  f = looks(g, 4.4, 100, 0.004);
  EXPECT_NE(f.text.find("back in the stable region"), std::string::npos) << f.text;
}

TEST(StabilityGuard, AShortStallIsNotADelay) {
  StabilityGuard g = guard(true);
  (void)looks(g, 0.0, 60, 0.001);
  EXPECT_TRUE(looks(g, 1.2, 15, 0.2).text.empty()) << "0.3 s of it";
  EXPECT_TRUE(looks(g, 1.5, 60, 0.001).text.empty());
}

TEST(StabilityGuard, WithoutAPredictionItOnlySaysSo) {
  StabilityPrediction p;
  p.text = "no prediction";
  StabilityGuard g(std::move(p), true, kTick);
  EXPECT_EQ(g.at_start().text, "no prediction");
  EXPECT_TRUE(looks(g, 0.0, 100, 1.0).text.empty());
}

TEST(StabilityGuard, AnUnstableSceneIsRefusedAtTheStart) {
  StabilityPrediction p;
  p.known = true;
  p.advice = [](int) { return std::string("lower k"); };
  EXPECT_TRUE(StabilityGuard(p, true, kTick).at_start().refuses);
  EXPECT_FALSE(StabilityGuard(p, false, kTick).at_start().refuses);
}

}  // namespace
}  // namespace tandem::node
