#include "harness/measures.h"

#include <cmath>

#include <gtest/gtest.h>

namespace tandem::harness {
namespace {

constexpr double kTick = 1.0 / 1024.0;

/// Two sites, one finger each, whose numbers are functions of time.
template <typename Fill>
Trajectory session(double seconds, Fill&& fill) {
  Trajectory t;
  t.tick = kTick;
  t.ticks_per_packet = 8;
  t.sites.resize(2);
  for (std::size_t u = 0; u < 2; ++u) {
    t.sites[u].fingers = 1;
    t.sites[u].has_object = true;
    const auto n = static_cast<std::int64_t>(seconds / kTick);
    for (std::int64_t k = 0; k < n; ++k) {
      SiteSample s;
      s.slot = k;
      fill(static_cast<int>(u), static_cast<double>(k) * kTick, s);
      t.sites[u].samples.push_back(s);
    }
  }
  return t;
}

Stability judged(double seconds, double rate, double amplitude = 1e-4) {
  return judge_stability(session(seconds, [&](int u, double t, SiteSample& s) {
    s.hand[0].x = (u == 0 ? 1.0 : -1.0) * amplitude * std::exp(rate * t) * std::cos(30.0 * t);
  }));
}

TEST(Stability, IsTheGrowthOfAnExponential) {
  for (const double rate : {-2.0, -0.1, 0.2, 1.0}) {
    const Stability s = judged(5.0, rate);
    EXPECT_EQ(s.stable, rate < 0.0) << rate;
    // 3 cycles a window: the range misses the envelope by at most its growth within a cycle.
    EXPECT_NEAR(std::log(s.growth_per_s), rate, 0.05 * std::abs(rate) + 0.02);
    EXPECT_NEAR(s.growth_per_packet, std::pow(s.growth_per_s, 1.0 / 128.0), 1e-9);
  }
}

TEST(Stability, SteadyForcedMotionIsStable) {
  const Stability s = judged(5.0, 0.0);
  EXPECT_TRUE(s.stable) << s.reason;
  EXPECT_TRUE(s.judged);
}

TEST(Stability, WhatLeavesTheBoundOrIsNoNumberIsNot) {
  EXPECT_FALSE(judged(5.0, 3.0).stable);
  const Stability s = judge_stability(session(2.0, [](int, double t, SiteSample& sample) {
    sample.hand[0].x = t > 1.0 ? std::nan("") : 0.0;
  }));
  EXPECT_FALSE(s.stable);
}

// A force limit stops the growth: the second half is flat, but far wider than the first quarter.
TEST(Stability, GrowthThatASaturationHoldsIsSeen) {
  const Stability s = judge_stability(session(5.0, [](int, double t, SiteSample& sample) {
    sample.hand[0].x = std::fmin(1e-5 * std::exp(6.0 * t), 0.02) * std::cos(40.0 * t);
  }));
  EXPECT_FALSE(s.stable);
}

// The kick has died out, and a murmur is left that happens to swell a little.
TEST(Stability, OnSocketsAMurmurFarBelowTheKickIsNoGrowth) {
  const Trajectory t = session(5.0, [](int, double time, SiteSample& s) {
    s.hand[0].x = 2e-3 * std::exp(-12.0 * time) * std::cos(40.0 * time) +
                  1e-9 * std::exp(0.2 * time) * std::cos(300.0 * time);
  });
  EXPECT_FALSE(judge_stability(t).stable);  // exact in virtual time: there it is growth
  EXPECT_TRUE(judge_stability(t, kFloorOnSockets).stable);
  EXPECT_TRUE(judge_stability(t, kFloorOnSockets).judged);
}

// Another part of the motion grows as slowly, from a thousandth of the kick.
TEST(Stability, OnSocketsGrowthAboveTheMurmurIsSeen) {
  const Trajectory t = session(5.0, [](int, double time, SiteSample& s) {
    s.hand[0].x = 2e-3 * std::exp(-12.0 * time) * std::cos(40.0 * time) +
                  2e-6 * std::exp(0.2 * time) * std::cos(300.0 * time);
  });
  EXPECT_FALSE(judge_stability(t, kFloorOnSockets).stable);
}

TEST(Stability, AHandThatSpeedsUpByItselfIsNotStable) {
  Stability s = judged(5.0, -2.0);
  const double period = 1.0 / 128.0;
  judge_by_drag(s, {.n_s_per_m = -0.04, .growth_per_s = 1.1}, period);
  EXPECT_TRUE(s.stable);
  judge_by_drag(s, {}, period);
  EXPECT_TRUE(s.stable);
  judge_by_drag(s, {.n_s_per_m = -0.3, .growth_per_s = 2.0}, period);
  EXPECT_FALSE(s.stable);
  EXPECT_EQ(s.growth_per_s, 2.0);
  EXPECT_NEAR(std::pow(s.growth_per_packet, 128.0), 2.0, 1e-12);
  EXPECT_NE(s.reason.find("-0.3"), std::string::npos) << s.reason;
}

TEST(Stability, NothingThatMovesIsNotJudged) {
  EXPECT_FALSE(judge_stability(session(2.0, [](int, double, SiteSample&) {})).judged);
}

TEST(Measures, GapIsTheWidestDistanceOfTheCopies) {
  const Measures m = measure(session(4.0, [](int u, double t, SiteSample& s) {
    s.object.x = u == 0 ? 0.0 : 0.003 * std::sin(2.0 * 3.141592653589793 * t);
  }));
  EXPECT_NEAR(m.gap_rms, 0.003 / std::sqrt(2.0), 1e-6);  // whole cycles, 1024 samples each
  EXPECT_NEAR(m.gap_999, 0.003, 1e-6);
}

TEST(Measures, ForceErrorIsTakenAgainstTheTwinInNewtonAndInWeber) {
  const auto force = [](double level) {
    return [level](int, double, SiteSample& s) { s.force[0].y = level; };
  };
  const Trajectory twin = session(2.0, force(2.0)), weak = session(2.0, force(0.1));
  const Measures strong = measure(session(2.0, force(2.5)), &twin);
  EXPECT_NEAR(strong.sites[0].force_error, 0.5, 1e-12);
  EXPECT_NEAR(strong.sites[0].force_error_weber, 0.25, 1e-12);
  EXPECT_NEAR(strong.sites[0].force_rms, 2.5, 1e-12);
  // Below half a newton the fraction is of half a newton.
  EXPECT_NEAR(measure(session(2.0, force(0.2)), &weak).sites[1].force_error_weber, 0.2, 1e-12);
}

TEST(Measures, EnergyIsTheMostThatWasGivenSinceTheStart) {
  Trajectory t = session(2.0, [](int, double time, SiteSample& s) {
    s.network_energy = 0.5 + 0.1 * std::sin(3.141592653589793 * time);
  });
  for (auto& site : t.sites) site.has_network_energy = true;
  const Measures m = measure(t);
  EXPECT_NEAR(m.sites[0].network_energy, 0.6, 1e-6);
  EXPECT_NEAR(m.sites[0].network_energy_end, 0.5, 1e-3);
}

// A mass of 0.5 kg pushed by 0.1 N against b: v = F/b (1 - e^(-bt/m)), x its integral; exact at any
// time, so also long before it has settled, without drag and with a negative one.
TEST(Drag, IsFoundOfAMassBeforeItHasSettled) {
  const double force = 0.1, mass = 0.5;
  for (const double b : {2.0, 0.3, 0.05, -0.05}) {
    const auto m = measure_drag(
        session(6.0,
                [&](int, double t, SiteSample& s) {
                  s.hand[0].x = force / b * (t - mass / b * (1.0 - std::exp(-b * t / mass)));
                }),
        0, force);
    EXPECT_NEAR(m.n_s_per_m, b, 1e-6) << b;
    if (b < 1.0) {  // else it has settled
      EXPECT_NEAR(m.growth_per_s, std::exp(-b / mass), 1e-6) << b;
    }
  }
  const auto none = measure_drag(
      session(6.0, [&](int, double t, SiteSample& s) { s.hand[0].x = 0.5 * force / mass * t * t; }),
      0, force);
  EXPECT_NEAR(none.n_s_per_m, 0.0, 1e-9);
  EXPECT_FALSE(none.settled);
}

TEST(Stiffness, IsThePartOfTheForceInPhaseWithTheMotion) {
  const double k = 400.0, b = 5.0, omega = 3.141592653589793;
  const double found = measure_stiffness(
      session(8.0,
              [&](int, double t, SiteSample& s) {
                s.hand[0].x = 0.005 * std::sin(omega * t);
                s.force[0].x = -k * s.hand[0].x - b * 0.005 * omega * std::cos(omega * t);
                if (t < 5.9) s.force[0].x *= 2.0;  // before the seconds that count
              }),
      0, 2.0);
  EXPECT_NEAR(found, k, 1e-6);  // a whole cycle
}

TEST(MotionToForce, IsTheTimeBetweenTheTwoThresholds) {
  const Trajectory t = session(2.0, [](int u, double time, SiteSample& s) {
    if (u == 0) s.hand[0].x = time > 1.0 ? 0.001 : 0.0;
    if (u == 1) s.force[0].x = 0.3 + (time > 1.02 ? 0.1 : 0.0);
  });
  EXPECT_NEAR(motion_to_force(t, 0, 1, 1e-4, 0.01), 0.02, kTick);
  EXPECT_TRUE(std::isnan(motion_to_force(t, 0, 1, 1e-4, 0.5)));
}

}  // namespace
}  // namespace tandem::harness
