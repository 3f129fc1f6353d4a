#include <cmath>

#include <gtest/gtest.h>

#include "arch_central/central_loop.h"
#include "core/axis_world.h"
#include "core/held_step.h"

namespace tandem {
namespace {

using Loop = central::CentralLoop<core::AxisWorld>;

constexpr double kT = 1.0 / 1024.0;

/// One hand, free mass, on one object.
core::Scene pair(double hand_mass, double object_mass, double k, double b) {
  core::Scene scene;
  scene.architecture = core::Architecture::kSingle;
  scene.integrator = core::Integrator::kExactCoupler;
  scene.objects.resize(1);
  scene.objects[0].name = "box";
  scene.objects[0].mass = object_mass;
  scene.users.resize(1);
  scene.users[0].name = "1";
  scene.users[0].mass = hand_mass;
  scene.users[0].fingers.resize(1);
  scene.couplers.resize(1);
  scene.couplers[0].object = "box";
  scene.couplers[0].user = "1";
  scene.couplers[0].gain = {k, b};
  return scene;
}

// y'' = -w y - d y' + u from y = 0: closed forms of the three kinds of damping.
TEST(HeldStep, IsTheClosedFormOfADampedSpring) {
  const double T = 0.01;
  const struct {
    double w, d;
  } cases[] = {{400.0, 3.0}, {90000.0, 20.0}, {100.0, 1000.0}, {3e8, 40.0}};
  for (const auto [w, d] : cases) {
    const core::HeldStep s = core::held_step(w, d, T);
    const double sigma = d / 2, square = w - sigma * sigma, r = std::sqrt(std::fabs(square));
    const double e = std::exp(-sigma * T);
    const double c = e * (square > 0 ? std::cos(r * T) : std::cosh(r * T));
    const double n = e * (square > 0 ? std::sin(r * T) : std::sinh(r * T)) / r;
    const double y_v = n, v_v = c - sigma * n, y_u = (1 - c - sigma * n) / w, v_u = n;
    // Squarings multiply rounding; the phase r T is up to 173 rad.
    const double tolerance = 1e-13 * (1.0 + r * T);
    EXPECT_NEAR(s.y_v, y_v, tolerance * T) << w;
    EXPECT_NEAR(s.v_v, v_v, tolerance) << w;
    EXPECT_NEAR(s.y_u, y_u, tolerance * T * T) << w;
    EXPECT_NEAR(s.v_u, v_u, tolerance * T) << w;
    // The equation itself, integrated: v(T) - v(0) = -w T mean - d y(T) + u T.
    EXPECT_NEAR(s.mean_v * w * T, 1 - v_v - d * y_v, 1e-10) << w;
    EXPECT_NEAR(s.mean_u * w * T, T - v_u - d * y_u, 1e-10 * T) << w;
  }
}

TEST(HeldStep, WithoutSpringAndDamperItIsTheParabola) {
  const core::HeldStep s = core::held_step(0.0, 0.0, kT);
  EXPECT_EQ(s.y_v, kT);
  EXPECT_EQ(s.y_u, kT * kT / 2);
  EXPECT_EQ(s.v_v, 1.0);
  EXPECT_EQ(s.v_u, kT);
  EXPECT_EQ(s.mean_v, kT / 2);
  EXPECT_NEAR(s.mean_u, kT * kT / 6, 1e-22);  // last bit
}

TEST(ExactCoupler, AnObjectOnAStandingHandSwingsExactlyHoweverStiff) {
  for (const double k : {1e3, 3e4, 1e7}) {
    const double m = 0.4, b = 10.0, v0 = 0.1;
    core::Scene scene = pair(0.1, m, k, b);
    scene.objects[0].velocity.x = v0;
    Loop loop(scene);
    loop.hands().finger(0, 0).prescribe_velocity(0.0);
    const double sigma = b / (2 * m), w = std::sqrt(k / m - sigma * sigma);
    for (int i = 1; i <= 512; ++i) {
      loop.tick();
      const double t = i * kT;
      // Rounding of the phase w t.
      EXPECT_NEAR(loop.object(0, 0).p, v0 / w * std::exp(-sigma * t) * std::sin(w * t),
                  1e-14 * (1.0 + w * t) * v0 / w)
          << k;
    }
  }
}

TEST(ExactCoupler, HandAndObjectExchangeMomentumWithoutLoss) {
  core::Scene scene = pair(0.1, 0.4, 30000.0, 10.0);
  scene.objects[0].velocity.x = 0.1;
  Loop loop(scene);
  for (int i = 0; i < 100000; ++i) loop.tick();
  const double momentum = 0.1 * loop.hands().finger(0, 0).velocity() + 0.4 * loop.object(0, 0).v;
  EXPECT_NEAR(momentum, 0.04, 1e-13);  // rounding of 10^5 ticks
}

// The force of a standing stretch is K times it, whatever the scheme: what a person feels when
// nothing moves.
TEST(ExactCoupler, RendersTheCouplersStiffness) {
  core::Scene scene = pair(0.1, 0.4, 5000.0, 100.0);
  scene.walls.resize(1);
  scene.walls[0].attached = true;
  scene.walls[0].gain = {5000.0, 100.0};
  scene.users[0].fingers[0].intent.force.x = 2.0;
  scene.users[0].fingers[0].damping = 5.0;
  Loop loop(scene);
  for (int i = 0; i < 20000; ++i) loop.tick();
  EXPECT_NEAR(loop.hands().finger(0, 0).position() - loop.object(0, 0).p, 2.0 / 5000.0, 1e-12);
  EXPECT_NEAR(loop.output(0).forces[0], -2.0, 1e-9);  // settled to rounding
}

/// Growth of a hand's swing on an object too heavy to move.
double swing_after(double k, double b, int ticks) {
  core::Scene scene = pair(0.1, 1e12, k, b);
  scene.users[0].fingers[0].intent.force_sines.push_back({0.0, 8 * kT, 1.0, 400.0, {1, 0, 0}});
  Loop loop(scene);
  double largest = 0.0;
  for (int i = 0; i < ticks; ++i) {
    loop.tick();
    if (i >= ticks - 64)
      largest = std::max(largest, std::fabs(loop.hands().finger(0, 0).velocity()));
  }
  return largest;
}

// By hand: the led spring gives v' = v + T F / m, x' = x + T v + T^2 F / 2 m with
// F = -k (x + v T / 2), a map of determinant 1 with eigenvalues on the unit circle for k < 4 m /
// T^2. A held force grows for every k > 2 b / T, here for every k.
TEST(ExactCoupler, WithoutDampersAHandStaysStableUpToFourMassesByTheSquareOfTheTick) {
  const double limit = 4 * 0.1 / (kT * kT);
  EXPECT_LT(swing_after(0.995 * limit, 0.0, 40000), 100 * swing_after(0.995 * limit, 0.0, 128));
  EXPECT_GT(swing_after(1.005 * limit, 0.0, 4000), 1e6);
}

// By hand: v' = v - beta (3 v - v_before) / 2 is stable for beta = b T / m < 1.
TEST(ExactCoupler, AloneADamperIsStableBelowOneMassByTheTick) {
  const double limit = 0.1 / kT;
  EXPECT_LT(swing_after(0.0, 0.995 * limit, 20000), 1e-6);
  EXPECT_GT(swing_after(0.0, 1.005 * limit, 40000), 1e3);
}

TEST(ExactCoupler, WhatAFingerDidBeforeIsAVisibleState) {
  Loop exact(pair(0.1, 0.4, 1000.0, 10.0));
  core::Scene scene = pair(0.1, 0.4, 1000.0, 10.0);
  scene.integrator = core::Integrator::kZeroOrderHold;
  Loop held(scene);
  struct Count {
    int n = 0;
    void position(double&) { ++n; }
    void velocity(double&) { ++n; }
    void force(double&) { ++n; }
    void wrench(double&) { ++n; }
  } a, b;
  exact.visit_state(a);
  held.visit_state(b);
  EXPECT_EQ(b.n, 4);
  EXPECT_EQ(a.n, 5);
}

}  // namespace
}  // namespace tandem
