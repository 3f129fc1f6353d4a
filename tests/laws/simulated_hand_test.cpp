#include "core/simulated_hand.h"

#include <cmath>

#include <gtest/gtest.h>

namespace tandem::core {
namespace {

constexpr double kT = 1.0 / 1024.0;

// x(t) of a damped oscillator let go at x0, closed form; the step is exact, so only rounding
// counts.
TEST(SimulatedHand, FollowsTheClosedFormOscillation) {
  FingerParameters finger;
  finger.hand = {400.0, 0.0};
  finger.damping = 1.2;
  SimulatedHand<double> hand(kT, 0.3, finger, nullptr);
  hand.set_external_force(4.0);  // settles at 0.01 m
  const double m = 0.3, K = 400, B = 1.2, sigma = B / (2 * m);
  const double omega = std::sqrt(K / m - sigma * sigma);
  for (int k = 0; k < 2000; ++k) {
    hand.step(0.0, k);
    const double t = (k + 1) * kT;
    const double x = 0.01 * (1 - std::exp(-sigma * t) *
                                     (std::cos(omega * t) + sigma / omega * std::sin(omega * t)));
    ASSERT_NEAR(hand.position(), x, 1e-14) << k;
  }
}

// Overdamped and stiff: eigenvalues far apart; compared with the two exponentials.
TEST(SimulatedHand, StepIsExactForStiffOverdampedHands) {
  const double w = 2.0e5, d = 3.0e3;
  const double root = std::sqrt(d * d / 4 - w), l1 = -d / 2 + root, l2 = -d / 2 - root;
  const SecondOrderStep s = second_order_step(w, d, kT);
  const double e1 = std::exp(l1 * kT), e2 = std::exp(l2 * kT);
  EXPECT_NEAR(s.a00, (l1 * e2 - l2 * e1) / (l1 - l2), 1e-13);
  EXPECT_NEAR(s.a01, (e1 - e2) / (l1 - l2), 1e-16);
  EXPECT_NEAR(s.a11, (l1 * e1 - l2 * e2) / (l1 - l2), 1e-13);
  EXPECT_NEAR(s.b0, (1 - s.a00) / w, 1e-18);
}

TEST(SimulatedHand, FrictionHoldsItExactlyAndStopsItWithoutReversing) {
  FingerParameters finger;
  finger.position = Vec3(0.0123, 0, 0);
  DeviceParameters device;
  device.friction = 0.2;
  SimulatedHand<double> hand(kT, 0.1, finger, &device);
  for (int k = 0; k < 1000; ++k) hand.step(k % 2 ? 0.19 : -0.19, k);
  EXPECT_EQ(hand.position(), 0.0123);
  EXPECT_EQ(hand.velocity(), 0.0);
  for (int k = 0; k < 100; ++k) hand.step(1.2, k);  // (1.2 - 0.2)/0.1 = 10 m/s^2
  EXPECT_NEAR(hand.velocity(), 10.0 * 100 * kT, 1e-12);
  // Coasts v^2 / (2 F / m) further and stands; exact up to rounding.
  const double stop = hand.position() + hand.velocity() * hand.velocity() / (2 * 0.2 / 0.1);
  for (int k = 0; k < 2000; ++k) {
    hand.step(0.0, k);
    ASSERT_GE(hand.velocity(), 0.0);
  }
  EXPECT_NEAR(hand.position(), stop, 1e-12);
}

TEST(SimulatedHand, EncoderRoundsToTheNearestStepAndReportsNoVelocity) {
  FingerParameters finger;
  finger.position = Vec3(0.000044, -0.000044, 0);
  DeviceParameters device;
  device.encoder_step = 30e-6;
  const SimulatedHand<Vec2> hand(kT, 0.1, finger, &device);
  EXPECT_DOUBLE_EQ(hand.sample().p.x, 30e-6);
  EXPECT_DOUBLE_EQ(hand.sample().p.y, -30e-6);
  EXPECT_EQ(hand.sample().v.x, 0.0);
}

// Quintic blend: half way at half time, still at both ends, and the reported velocity is the
// derivative of the reported position.
TEST(TargetPath, BlendsBetweenKeyframesAndItsVelocityIsTheDerivative) {
  FingerIntent intent;
  intent.path = {{1.0, Vec3(0.0)}, {3.0, Vec3(0.04, -0.02, 0)}};
  intent.path_sines.push_back({4.0, 6.0, 0.05, 2.0, Vec3(0, 1, 0), false});
  TargetPath<Vec2> path(intent, Vec3(0.1, 0.2, 0));
  EXPECT_EQ(path.at(0.5).position.x, 0.1);
  EXPECT_NEAR(path.at(2.0).position.x, 0.12, 1e-15);
  EXPECT_NEAR(path.at(3.5).position.y, 0.18, 1e-15);
  EXPECT_NEAR(path.at(5.0).position.y, 0.18 + 0.05 * std::sin(2.0), 1e-15);
  for (double t = 0.013; t < 5.9; t += 0.0371) {
    if (std::abs(t - 4.0) < 0.01) continue;  // the sine sets in with a velocity
    const double h = 1e-6;
    const double slope = (path.at(t + h).position.y - path.at(t - h).position.y) / (2 * h);
    EXPECT_NEAR(path.at(t).velocity.y, slope, 1e-8) << t;
  }
}

}  // namespace
}  // namespace tandem::core
