#include "analysis/bounds.h"

#include <cmath>
#include <complex>

#include <gtest/gtest.h>

#include "analysis/coupler_limits.h"
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

// Colgate and Schenkel turned round: (b - |B|) 2 / T without delay, 2 b / (2 d + 1) T for a spring.
TEST(Bounds, ThePassiveStiffnessIsTheNeededDampingTurnedRound) {
  core::Random random(6);
  for (int i = 0; i < 20; ++i) {
    const double b = random.uniform(0.1, 20.0), B = random.uniform(0.0, 1.2 * b);
    const double plain = std::max(0.0, 2.0 * (b - B) / kT);
    EXPECT_NEAR(colgate_schenkel_stiffness(b, B, kT), plain, 1e-9 * b / kT);
    const int d = static_cast<int>(random.uniform() * 4.0);
    EXPECT_NEAR(colgate_schenkel_stiffness(b, 0.0, kT, d), 2.0 * b / (kT * (2.0 * d + 1.0)),
                1e-9 * b / kT);
  }
  EXPECT_EQ(colgate_schenkel_stiffness(0.0, 1.0, kT), 0.0);
}

// A passive wall is stable in every hand, and the bound is the best one: a heavy or rigid hand
// comes within 5 % of it (sampled hands, exact loops).
TEST(Bounds, OfPassivityAreMetByTheWorstSampledHandOnTheLiftedMap) {
  for (const double b : {0.5, 5.0})
    for (const int late : {0, 1, 2}) {
      LocalCoupler c;
      c.damping = 0.0;
      c.device_damping = b;
      c.latency_ticks = late;
      const double bound = colgate_schenkel_stiffness(b, 0.0, kT, late);
      const double exact = worst_wall_stiffness(c).stiffness;
      EXPECT_GE(exact, bound * (1.0 - 1e-9)) << b << " " << late;
      EXPECT_LE(exact, bound * 1.05) << b << " " << late;
    }
}

// (3.18) and the variants of the reference analysis, section 1: zero-order hold 20480, explicit
// Euler object 17066.667, semi-implicit 25600; one more sample of computation 6434.727, two
// 3661.067. By closed form and by the lifted map.
TEST(Bounds, OfTwoMassesAreTheReferencesVariants) {
  LocalCoupler c;
  c.damping = 10.0;
  const PassiveHand free{0.1, 0.0, 0.0};
  const struct {
    core::Integrator integrator;
    double step, expected;
  } variants[] = {{core::Integrator::kZeroOrderHold, 0.5, 20480.0},
                  {core::Integrator::kExplicitEuler, 0.0, 10240.0 / 0.6},
                  {core::Integrator::kSemiImplicitEuler, 1.0, 10240.0 / 0.4}};
  for (const auto& v : variants) {
    EXPECT_NEAR(coupled_masses_stiffness(10.0, 0.1, 0.4, v.step, kT), v.expected, 1e-8);
    c.integrator = v.integrator;
    EXPECT_NEAR(stable_coupler_stiffness(c, free), v.expected, 1e-4);  // 1e-9 relative, asked for
  }
  c.integrator = core::Integrator::kZeroOrderHold;
  c.latency_ticks = 1;
  EXPECT_NEAR(stable_coupler_stiffness(c, free), 6434.727, 6e-4);
  c.latency_ticks = 2;
  EXPECT_NEAR(stable_coupler_stiffness(c, free), 3661.067, 6e-4);
  // Jury's second condition, where damping alone is nearly too much: the map agrees.
  core::Random random(8);
  for (int i = 0; i < 30; ++i) {
    LocalCoupler r;
    r.hand_mass = random.uniform(0.02, 0.5);
    r.object_mass = random.uniform(0.05, 2.0);
    const double mu = r.hand_mass * r.object_mass / (r.hand_mass + r.object_mass);
    r.damping = random.uniform(0.1, 0.99) * 2.0 * mu / kT;
    for (const auto& v : variants) {
      r.integrator = v.integrator;
      const double k = coupled_masses_stiffness(r.damping, r.hand_mass, r.object_mass, v.step, kT);
      EXPECT_NEAR(stable_coupler_stiffness(r, {r.hand_mass, 0.0, 0.0}) / k, 1.0, 1e-7);
    }
  }
}

// Llewellyn's criterion from the two-port itself, in complex numbers on a grid of its own: h11 = b,
// h12 = Z, h21 = -1, h22 = 1 / Z_c; 2 Re h11 Re h22 >= |h12 h21| + Re h12 h21.
TEST(Bounds, LlewellynIsTheTwoPortsOwn) {
  const auto absolutely_stable = [](double k, double B, double b) {
    for (int i = 1; i <= 20000; ++i) {
      const std::complex<double> z = std::polar(1.0, 3.14159265358979323846 * i / 20000);
      const auto coupling = B + k * kT * z / (z - 1.0);
      const auto hold = (z + 1.0) / (2.0 * z);
      const auto product = -hold;
      // Slack for the rounding of 1 - cos at small angles.
      if (2.0 * b * (1.0 / coupling).real() < std::abs(product) + product.real() - 1e-13)
        return false;
    }
    return true;
  };
  core::Random random(9);
  for (int i = 0; i < 20; ++i) {
    const double b = random.uniform(0.05, 20.0), B = random.uniform(0.0, 40.0);
    const double k = llewellyn_stiffness(B, b, kT);
    const double slow = 4.0 / kT * (b + std::sqrt(b * b + b * B));  // the limit of slow motion
    EXPECT_LE(k, slow * (1.0 + 1e-9));
    EXPECT_EQ(k > 0.0, B < 8.0 * b) << b << " " << B;  // at cos(w T / 2) = 1/2, without spring
    if (k == 0.0) {
      EXPECT_FALSE(absolutely_stable(1.0, B, b));
      continue;
    }
    EXPECT_TRUE(absolutely_stable(0.999 * k, B, b)) << b << " " << B;
    EXPECT_FALSE(absolutely_stable(1.002 * k, B, b)) << b << " " << B;
  }
  EXPECT_EQ(llewellyn_stiffness(10.0, 0.0, kT), 0.0);
}

}  // namespace
}  // namespace tandem::analysis
