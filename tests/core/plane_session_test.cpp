#include <array>
#include <cmath>

#include <gtest/gtest.h>

#include "core/plane_body.h"
#include "core/plane_contact.h"
#include "core/random.h"

// Boxes, fingers and walls stepped together: balances and energy.
namespace tandem::core {
namespace {

constexpr double kT = 1.0 / 1024.0;
constexpr double kPi = 3.14159265358979323846;

const PlaneBox kBox{{0.05, 0.04}, 0.0};

ContactGains wall_gains(double mu_s, double mu_k) {
  ContactGains gains;
  gains.normal = {4000.0, 30.0};
  gains.tangential = {7000.0, 50.0};
  gains.friction = {mu_s, mu_k, 0.005};
  return gains;
}

PlaneBodyParameters box_body() {
  ObjectParameters object;
  object.mass = 0.7;
  object.size = {0.1, 0.08, 0.0};
  return plane_body_parameters(object, 9.81);
}

TEST(PlaneSession, ABoxPressedOffCentreRestsOnTwoCornersThatShareTheForceByTheLever) {
  const PlaneWall floor{{0.0, 0.0}, {0.0, 1.0}, wall_gains(0.6, 0.5)};
  WallContacts contacts;
  const PlaneBodyParameters p = box_body();
  PlaneBody body{{0.0, 0.041}, 0.0, {0.0, 0.0}, 0.0};
  const double push = 5.0, lever = 0.02;  // downwards, at x = +0.02 of the centre
  for (int k = 0; k < 8192; ++k) {
    PlaneWrench w = hold_back(contacts, floor, kBox, body, kT);
    w += {{0.0, -push}, -push * lever};
    body = step(p, Integrator::kSemiImplicitEuler, kT, body, w);
  }
  // Depths give both forces.
  const PlacedBody placed(body);
  const Vec2 right_arm = placed.to_world({0.05, -0.04}), left_arm = placed.to_world({-0.05, -0.04});
  const double right = -(body.p + right_arm).y * 4000, left = -(body.p + left_arm).y * 4000;
  // Balance of moments about the left corner, with the levers of the tilted box. The corners' own
  // friction (they were spread while tilting) has the lever of their difference in depth, 0.5 mm.
  const double share = (lever - left_arm.x) / (right_arm.x - left_arm.x);
  EXPECT_NEAR(share, 0.7, 0.003);  // the tilt of 5 mrad moves the corners by 0.2 mm of 100 mm
  EXPECT_NEAR(right, push * share, 0.6 * push * 0.005);
  EXPECT_NEAR(left, push * (1 - share), 0.6 * push * 0.005);
  EXPECT_NEAR(right + left, push, 1e-9);
  EXPECT_NEAR(body.omega, 0.0, 1e-9);
  const PlaneWrench w = hold_back(contacts, floor, kBox, body, kT);
  EXPECT_NEAR(w.torque, push * lever, 1e-9);
}

TEST(PlaneSession, ABoxOnAnInclinedWallSticksBelowTanThetaEqualToMuAndSlidesAbove) {
  const double mu = 0.3;
  for (const double ratio : {0.97, 1.03}) {
    const double theta = std::atan(mu * ratio);
    const PlaneWall slope{{0.0, 0.0}, {-std::sin(theta), std::cos(theta)}, wall_gains(mu, mu)};
    WallContacts contacts;
    const PlaneBodyParameters p = box_body();
    const double weight = 0.7 * 9.81;
    PlaneBody body{slope.normal * (0.04 - weight * std::cos(theta) / 8000), theta, {0.0, 0.0}, 0.0};
    const Vec2 down{-std::cos(theta), -std::sin(theta)};
    const Vec2 start = body.p;
    PlaneBody early;
    for (int k = 0; k < 4096; ++k) {
      if (k == 2048) early = body;
      // The pull along the slope grows within 1 s: a sudden one would overshoot the cone.
      const double pull = weight * std::sin(theta) * std::fmin(k * kT, 1.0);
      PlaneWrench w = hold_back(contacts, slope, kBox, body, kT);
      w.force += down * pull - slope.normal * (weight * std::cos(theta));
      body = step(p, Integrator::kSemiImplicitEuler, kT, body, w);
    }
    if (ratio < 1) {
      // The box rocks on its normal springs, so the uphill corner is unloaded and slides first; the
      // downhill one carries the rest by its tangential spring.
      const double pull = weight * std::sin(theta), tilt = pull * 0.04 / (2 * 4000 * 0.05 * 0.05);
      const double uphill = weight * std::cos(theta) / 2 - 4000 * 0.05 * tilt;
      const double give = (pull - mu * uphill) / 7000 + tilt * 0.04;
      EXPECT_NEAR(inner(down, body.p - start), give, 0.02 * give);  // levers: depth 0.8 of 40 mm
      EXPECT_NEAR(inner(down, body.p - early.p), 0.0, 1e-9);        // no creep
    } else {
      const double a = 9.81 * (std::sin(theta) - mu * std::cos(theta));
      EXPECT_NEAR(inner(down, body.v - early.v), a * 2.0, 1e-3 * a);
    }
  }
}

/// Frictionless springs without dampers: what the box's corners hold against the walls.
double stored_in(const PlaneWall& wall, const PlaneBody& body) {
  const PlacedBody placed(body);
  double sum = 0.0;
  for (const Vec2 corner :
       {Vec2{0.05, 0.04}, Vec2{-0.05, 0.04}, Vec2{-0.05, -0.04}, Vec2{0.05, -0.04}}) {
    const double depth = -inner(wall.normal, body.p + placed.to_world(corner) - wall.point);
    if (depth > 0) sum += 0.5 * wall.gains.normal.stiffness * depth * depth;
  }
  return sum;
}

double kinetic(const PlaneBodyParameters& p, const PlaneBody& b) {
  return 0.5 * inner(b.v, b.v) / p.inverse_mass + 0.5 * b.omega * b.omega / p.inverse_inertia;
}

TEST(PlaneSession, CollisionsWithWallsConserveEnergyToFirstOrderOfTheTick) {
  // Semi-implicit Euler of a lossless contact conserves a shadow energy: the difference before
  // and after a bounce shrinks with T. Halving T four times must show it.
  const PlaneBodyParameters p = box_body();
  double last_error = 0.0;
  for (const double T : {1.0 / 2048, 1.0 / 16384}) {
    PlaneWall wall{{0.0, 0.0}, {0.0, 1.0}, wall_gains(0.0, 0.0)};
    wall.gains.normal.damping = 0.0;
    double worst = 0.0;
    for (int trial = 0; trial < 20; ++trial) {
      WallContacts contacts;
      PlaneBody body{{0.0, 0.08}, 0.1 + 0.07 * trial, {0.1, -0.5}, 1.0};
      const double before = kinetic(p, body);
      const int ticks = static_cast<int>(0.5 / T);
      for (int k = 0; k < ticks; ++k)
        body = step(p, Integrator::kSemiImplicitEuler, T, body,
                    hold_back(contacts, wall, kBox, body, T));
      worst = std::fmax(worst, std::fabs(kinetic(p, body) + stored_in(wall, body) - before));
    }
    if (last_error > 0.0) {
      EXPECT_LT(worst, 0.25 * last_error);  // 8 times shorter ticks
    }
    last_error = worst;
  }
}

/// Largest relative change of kinetic energy in lossless throws against a wall, held forces.
double change_by_throws(double T, double stiffness, bool met_within_the_tick) {
  const PlaneBodyParameters p = box_body();
  PlaneWall wall{{0.0, 0.0}, {0.0, 1.0}, wall_gains(0.0, 0.0)};
  wall.gains.normal = {stiffness, 0.0};
  double worst = 0.0;
  for (int trial = 0; trial < 40; ++trial) {
    WallContacts contacts;
    PlaneBody body{{0.0, 0.0701 + 0.0001 * trial}, 0.1 + 0.07 * trial, {0.1, -0.5}, 1.0};
    const double before = kinetic(p, body);
    for (int k = 0; k < static_cast<int>(0.25 / T); ++k)
      body = step(p, Integrator::kZeroOrderHold, T, body,
                  hold_back(contacts, wall, kBox, body, T, met_within_the_tick));
    EXPECT_GT(body.v.y, -0.5);  // it did bounce
    worst = std::fmax(worst, std::fabs((kinetic(p, body) + stored_in(wall, body)) / before - 1.0));
  }
  return worst;
}

TEST(PlaneSession, CornersMetWithinTheTickKeepTheirEnergyToSecondOrder) {
  // By hand: a held spring adds k T / 2 of negative damping, e^(pi w T / 4) in a bounce; position
  // Verlet adds none, and where the corner meets the wall errs by the curve of its way in a tick.
  const double coarse = change_by_throws(1.0 / 1024, 4000.0, true);
  EXPECT_LT(coarse, 2e-3);
  EXPECT_LT(change_by_throws(1.0 / 8192, 4000.0, true), coarse / 32);  // 8 times shorter: 64
  EXPECT_GT(change_by_throws(1.0 / 1024, 4000.0, false), 20 * coarse);
}

TEST(PlaneSession, RandomSimultaneousContactsNeverLeaveTheBoxFasterThanItCame) {
  // 10^5 throws into a corner of two walls, with friction, dampers and spin; on leaving, the box
  // never has more kinetic energy than on arrival. (The dampers take more than the held force of a
  // tick returns: 30 N s/m against k T / 2 = 2.)
  Random random(17);
  const PlaneBodyParameters p = box_body();
  int bounced = 0;
  for (int trial = 0; trial < 100000; ++trial) {
    const double mu = random.uniform(0.0, 0.8);
    std::array<PlaneWall, 2> walls{PlaneWall{{0.0, 0.0}, {0.0, 1.0}, wall_gains(mu, 0.8 * mu)},
                                   PlaneWall{{0.0, 0.0}, {1.0, 0.0}, wall_gains(mu, 0.8 * mu)}};
    std::array<WallContacts, 2> contacts{};
    PlaneBody body{{0.066, 0.066},
                   random.uniform(0.0, 2 * kPi),
                   {-random.uniform(0.0, 1.0), -random.uniform(0.0, 1.0)},
                   random.uniform(-8.0, 8.0)};
    const double before = kinetic(p, body);
    double highest = 0.0;
    bool touched = false;
    for (int k = 0; k < 120; ++k) {
      PlaneWrench w;
      const PlacedBody placed(body);
      for (int i = 0; i < 2; ++i) w += hold_back(contacts[i], walls[i], kBox, placed, kT);
      body = step(p, Integrator::kSemiImplicitEuler, kT, body, w);
      const bool now = contacts[0].any || contacts[1].any;
      touched |= now;
      if (touched && !now) highest = std::fmax(highest, kinetic(p, body));
    }
    ASSERT_LE(highest, before) << trial;
    if (touched) ++bounced;
  }
  EXPECT_GT(bounced, 50000);
}

TEST(PlaneSession, MomentumOfFingersAndBoxIsConserved) {
  // Free fingers of 0.1 kg thrown at a free box, pulses included: no force from outside.
  Random random(23);
  const PlaneBodyParameters p = box_body();
  ContactGains gains = wall_gains(0.6, 0.5);
  gains.normal = {800.0, 3.0};
  gains.moment_cancellation = true;
  gains.pulse_force = 5.0;
  gains.mass = 0.1;
  for (int trial = 0; trial < 500; ++trial) {
    PlaneBody body{{0.0, 0.0}, random.uniform(0.0, 6.0), {0.0, 0.0}, random.uniform(-2.0, 2.0)};
    std::array<PlanePoint, 4> fingers;
    std::array<FingerBoxContact, 4> contacts{};
    for (auto& f : fingers) {
      const SinCos a = sin_cos(random.uniform(0.0, 2 * kPi));
      f.p = Vec2{a.cos, a.sin} * 0.08;
      f.v = f.p * -random.uniform(1.0, 12.0);
    }
    const auto totals = [&] {
      Vec3 sum{body.v.x / p.inverse_mass, body.v.y / p.inverse_mass,
               cross(body.p, body.v) / p.inverse_mass + body.omega / p.inverse_inertia};
      for (const auto& f : fingers) sum += Vec3{f.v.x, f.v.y, cross(f.p, f.v)} * gains.mass;
      return sum;
    };
    const Vec3 before = totals();
    double energy_before = kinetic(p, body);
    for (const auto& f : fingers) energy_before += 0.5 * gains.mass * inner(f.v, f.v);
    bool touched = false;
    for (int k = 0; k < 400; ++k) {
      const PlacedBody placed(body);
      PlaneWrench w;
      for (int i = 0; i < 4; ++i) {
        const auto f = touch(contacts[i], gains, kBox, placed, fingers[i], kT);
        touched |= contacts[i].memory.state != ContactState::kFree;
        w += f.on_body;
        fingers[i].v += f.on_finger_W * (kT / gains.mass);
        fingers[i].p += fingers[i].v * kT;
      }
      body = step(p, Integrator::kSemiImplicitEuler, kT, body, w);
    }
    ASSERT_TRUE(touched);
    const Vec3 after = totals();
    ASSERT_NEAR(after.x, before.x, 1e-12);
    ASSERT_NEAR(after.y, before.y, 1e-12);
    // Positions move after the force: r x F uses the old arm and the new momentum v' along the
    // way; p x v of a semi-implicit step is exact, p' x v' = (p + T v') x v' = p x v'.
    ASSERT_NEAR(after.z, before.z, 1e-12);
    double energy_after = kinetic(p, body);
    for (const auto& f : fingers) energy_after += 0.5 * gains.mass * inner(f.v, f.v);
    ASSERT_LE(energy_after, energy_before * (1 + 1e-9)) << trial;
  }
}

}  // namespace
}  // namespace tandem::core
