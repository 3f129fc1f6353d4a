#include "analysis/bounds.h"

#include <cmath>

#include <gtest/gtest.h>

#include "core/random.h"

namespace tandem::analysis {
namespace {

constexpr double kT = 1.0 / 1024.0;

// K T / 2 + |B| without delay, (2 d + 1) K T / 2 for a spring: closed forms, 1000 random walls.
TEST(Bounds, ColgateAndSchenkelAgreeWithTheClosedForms) {
  core::Random random(4);
  for (int i = 0; i < 1000; ++i) {
    const double K = random.uniform(1.0, 30000.0), B = random.uniform(-5.0, 20.0);
    const double T = random.uniform(1e-4, 1e-2);
    EXPECT_NEAR(colgate_schenkel_damping(K, B, T), 0.5 * K * T + std::abs(B),
                1e-9 * (K * T + 20.0));
    const int d = static_cast<int>(random.uniform() * 4.0);
    EXPECT_NEAR(colgate_schenkel_damping(K, 0.0, T, d), 0.5 * K * T * (2.0 * d + 1.0),
                1e-9 * K * T * (d + 1.0));
  }
}

// A damper and a delay together: b > max [(1 + 2 cos a) K T / 2 - B cos 2a], on a grid of its own.
TEST(Bounds, ADelayedDamperIsNotJustAdded) {
  const double K = 3000.0, B = 3.0;
  double expected = -1e300;
  for (int i = 0; i <= 1000000; ++i) {
    const double a = 3.14159265358979323846 * i / 1000000;
    expected = std::max(expected, (1.0 + 2.0 * std::cos(a)) * K * kT / 2.0 - B * std::cos(2.0 * a));
  }
  EXPECT_NEAR(colgate_schenkel_damping(K, B, kT, 1), expected, 1e-9);
  EXPECT_LT(expected, 1.5 * K * kT + B - 1.0);
}

// 0.5 N s/m at 1024 Hz: 1024 N/m, and a third with one tick of delay; 0.1 N and 30 um: 6.7 kN/m.
TEST(Bounds, OfADeviceAreTheKnownNumbers) {
  EXPECT_DOUBLE_EQ(abbott_okamura_stiffness(0.5, 0.1, 0.0, kT), 1024.0);
  EXPECT_NEAR(abbott_okamura_stiffness(5.0, 0.1, 30e-6, kT), 6666.67, 0.01);
  EXPECT_NEAR(diolaiti_stiffness(0.5, 0.1, 0.0, kT, kT), 1024.0 / 3.0, 1e-9);
  EXPECT_DOUBLE_EQ(coupled_masses_stiffness(10.0, 0.1, 0.4, kT), 20480.0);
  EXPECT_EQ(coupled_masses_stiffness(164.0, 0.1, 0.4, kT), 0.0);
}

}  // namespace
}  // namespace tandem::analysis
