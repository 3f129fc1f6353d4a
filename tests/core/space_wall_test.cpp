#include "core/space_wall.h"

#include <cmath>

#include <gtest/gtest.h>

#include "core/space_body.h"
#include "tests/core/space_testing.h"

// Boxes, spheres and fingers against plane walls, stepped: rest, incline, rolling.
namespace tandem::core {
namespace {

constexpr double kG = 9.81;

ObjectParameters box_object(const Vec3& size, double mass = 0.7) {
  ObjectParameters object;
  object.shape = Shape::kBox;
  object.size = size;
  object.mass = mass;
  return object;
}

ObjectParameters ball_object() {
  ObjectParameters object;
  object.shape = Shape::kSphere;
  object.radius = 0.03;
  object.mass = 0.3;
  return object;
}

TEST(SpaceWall, ABoxThatRestsOnTheGroundStaysToTheBit) {
  const ObjectParameters object = box_object({0.06, 0.08, 0.05});
  const SpaceBodyParameters p = space_body_parameters(object, kG);
  const SpaceWall ground{Vec3{0.0}, {0.0, 0.0, 1.0}, ground_gains(0.6, 0.5)};
  SpaceWallContacts contacts;
  SpaceBody b;
  b.p.z = 0.025 - 0.7 * kG / (4 * 4000);  // four corners carry the weight
  const SpaceBody start = b;
  for (int k = 0; k < 20480; ++k)
    b = step(p, Integrator::kZeroOrderHold, kTick, b,
             hold_back(contacts, ground, shape_of(object, 0), b, kTick));
  EXPECT_LT(length(b.p - start.p), 1e-15);
  EXPECT_LT(length(b.v), 1e-14);
  EXPECT_LT(length(rotation_between(start.q, b.q)), 1e-14);
}

TEST(SpaceWall, ABoxDroppedOnACornerComesToRestOnAFace) {
  const ObjectParameters object = box_object({0.06, 0.08, 0.05});
  const SpaceBodyParameters p = space_body_parameters(object, kG);
  const SpaceWall ground{Vec3{0.0}, {0.0, 0.0, 1.0}, ground_gains(0.6, 0.5)};
  SpaceWallContacts contacts;
  SpaceBody b;
  b.p.z = 0.08;
  b.q = rotation_by({0.5, 0.3, 0.2});
  b.omega = {2.0, -1.0, 3.0};
  for (int k = 0; k < 6 * 1024; ++k)
    b = step(p, Integrator::kZeroOrderHold, kTick, b,
             hold_back(contacts, ground, shape_of(object, 0), b, kTick));
  const Vec3 up = axes_of(b.q).to_body({0.0, 0.0, 1.0});
  EXPECT_NEAR(std::fmax(std::fabs(up.x), std::fmax(std::fabs(up.y), std::fabs(up.z))), 1.0, 1e-4);
  EXPECT_LT(length(b.v), 1e-6);
  EXPECT_LT(length(b.omega), 1e-5);
}

TEST(SpaceWall, MetWithinTheTickABallIsGivenBackItsSpeedAndABoxItsEnergy) {
  // Undamped, without weight, from every phase of the tick. Held from the start of the tick, the
  // spring would give the ball a tenth of its speed on top.
  const SpaceWall ground{Vec3{0.0}, {0.0, 0.0, 1.0}, without_dampers(ground_gains(0.0, 0.0))};
  for (const bool sphere : {true, false})
    for (int trial = 0; trial < 50; ++trial) {
      const ObjectParameters object = sphere ? ball_object() : box_object({0.06, 0.08, 0.05});
      const SpaceBodyParameters p = space_body_parameters(object, 0.0);
      SpaceWallContacts contacts;
      SpaceBody b;
      b.p.z = 0.07 + 1e-5 * trial;
      b.q = rotation_by({0.5, 0.3, 0.04 * trial});
      b.v = {0.1, 0.0, -0.5};
      const auto energy = [&] {
        const Vec3 spin = axes_of(b.q).to_body(b.omega);
        return 0.5 * inner(b.v, b.v) * object.mass + 0.5 * inner(spin, spin * p.inertia);
      };
      const double before = energy();
      for (int k = 0; k < 512; ++k)
        b = step(p, Integrator::kZeroOrderHold, kTick, b,
                 hold_back(contacts, ground, shape_of(object, 0), b, kTick, true));
      ASSERT_FALSE(contacts.any);
      if (sphere) {
        // Of the curve of its way in the ticks that meet and leave: (w T)^2 = 0.013, squared.
        EXPECT_NEAR(b.v.z, 0.5, 0.5 * 2e-4) << trial;
      }
      EXPECT_NEAR(energy() / before, 1.0, 2e-3) << trial;
    }
}

TEST(SpaceWall, ABlockSticksUpToTanThetaEqualToMuInEveryDirectionOfThePush) {
  // Flat, so that the push hardly rocks it. The pull along the slope comes as a force of its own,
  // which grows in 1 s: a sudden one would overshoot the cone. Pyramids show at 45 degrees.
  const double mu = 0.3;
  const ObjectParameters object = box_object({0.1, 0.1, 0.002});
  const SpaceBodyParameters p = space_body_parameters(object, 0.0);
  const SpaceWall ground{Vec3{0.0}, {0.0, 0.0, 1.0}, ground_gains(mu, mu)};
  for (int i = 0; i < 12; ++i) {
    const double angle = 2 * kHalfTurn * i / 12 + (i % 2) * kHalfTurn / 12;
    const Vec3 down{std::cos(angle), std::sin(angle), 0.0};
    for (const double ratio : {0.97, 1.03}) {
      const double theta = std::atan(mu * ratio), weight = 0.7 * kG;
      SpaceWallContacts contacts;
      SpaceBody b, early;
      b.p.z = 0.001 - weight * std::cos(theta) / 16000;
      for (int k = 0; k < 3072; ++k) {
        if (k == 2048) early = b;
        SpaceWrench w = hold_back(contacts, ground, shape_of(object, 0), b, kTick);
        w.force += down * (weight * std::sin(theta) * std::fmin(k * kTick, 1.0)) -
                   Vec3{0.0, 0.0, weight * std::cos(theta)};
        b = step(p, Integrator::kSemiImplicitEuler, kTick, b, w);
      }
      if (ratio < 1.0) {
        // Four tangential springs hold it; the rocking of a plate of 2 mm adds a per cent.
        const double give = weight * std::sin(theta) / 28000;
        EXPECT_NEAR(glm::dot(down, b.p), give, 0.03 * give) << angle;
        EXPECT_LT(length(b.p - early.p), 1e-9) << angle;  // no creep
      } else {
        const double a = kG * (std::sin(theta) - mu * std::cos(theta));
        EXPECT_NEAR(glm::dot(down, b.v - early.v), a, 0.02 * a) << angle;
        EXPECT_LT(length(glm::cross(down, b.v)), 0.01 * length(b.v)) << angle;
      }
    }
  }
}

TEST(SpaceWall, ASphereRollsDownAnInclineAtFiveSeventhsOfTheSlope) {
  const double theta = 0.4;
  const ObjectParameters object = ball_object();
  const SpaceBodyParameters p = space_body_parameters(object, kG);
  for (int i = 0; i < 4; ++i) {
    const double azimuth = 0.3 + 1.7 * i;
    const Vec3 n{std::sin(theta) * std::cos(azimuth), std::sin(theta) * std::sin(azimuth),
                 std::cos(theta)};
    const Vec3 down{std::cos(theta) * std::cos(azimuth), std::cos(theta) * std::sin(azimuth),
                    -std::sin(theta)};
    for (const Integrator integrator :
         {Integrator::kZeroOrderHold, Integrator::kSemiImplicitEuler}) {
      const SpaceWall slope{{0.1, 0.2, 0.3}, n, ground_gains(0.6, 0.5)};
      SpaceWallContacts contacts;
      SpaceBody b, early;
      b.p = slope.point + n * (0.03 - 0.3 * kG * std::cos(theta) / 4000);
      b.q = rotation_by({0.3, 1.0, -0.4});
      for (int k = 0; k < 2048; ++k) {
        if (k == 1024) early = b;
        b = step(p, integrator, kTick, b,
                 hold_back(contacts, slope, shape_of(object, 0), b, kTick));
      }
      const double a = 5.0 / 7.0 * kG * std::sin(theta);
      // The tangential spring's ringing, of a few mm/s at the start, is damped out after 1 s.
      EXPECT_NEAR(glm::dot(down, b.v - early.v), a, 1e-6 * a);
      // Semi-implicit Euler moves with the new velocity, a T / 2 ahead.
      const double ahead = integrator == Integrator::kSemiImplicitEuler ? a * kTick / 2 : 0.0;
      EXPECT_NEAR(glm::dot(down, b.p - early.p), glm::dot(down, early.v) + a / 2 + ahead, 1e-6);
      const Vec3 slip = b.v + glm::cross(b.omega, n * -0.03);
      EXPECT_LT(length(slip), 1e-6);  // 5 m/s of rolling, and the point that touches stands still
      EXPECT_LT(std::fabs(glm::dot(glm::cross(n, down), b.v)), 1e-9);
    }
  }
}

TEST(SpaceWall, OnASteepInclineTheSphereSlipsWithFrictionAtItsLimit) {
  // tan(theta) > 7/2 mu: a = g (sin - mu cos), R alpha = 5/2 mu g cos.
  const double theta = 0.9, mu = 0.2;
  const ObjectParameters object = ball_object();
  const SpaceBodyParameters p = space_body_parameters(object, kG);
  const Vec3 n{std::sin(theta), 0.0, std::cos(theta)}, down{std::cos(theta), 0.0, -std::sin(theta)};
  const SpaceWall slope{Vec3{0.0}, n, ground_gains(mu, mu)};
  SpaceWallContacts contacts;
  SpaceBody b, early;
  b.p = n * (0.03 - 0.3 * kG * std::cos(theta) / 4000);
  for (int k = 0; k < 1024; ++k) {
    if (k == 512) early = b;
    b = step(p, Integrator::kZeroOrderHold, kTick, b,
             hold_back(contacts, slope, shape_of(object, 0), b, kTick));
  }
  const double a = kG * (std::sin(theta) - mu * std::cos(theta));
  EXPECT_NEAR(glm::dot(down, b.v - early.v), a / 2, 1e-6);
  EXPECT_NEAR(0.03 * (b.omega.y - early.omega.y), 2.5 * mu * kG * std::cos(theta) / 2, 1e-6);
}

TEST(SpaceWall, ASpinningSphereEndsUpRollingWithTwoSeventhsOfItsSpin) {
  // Friction's impulse J: m v = J, I (w0 - w) = J R, v = w R  gives  v = 2/7 w0 R.
  const ObjectParameters object = ball_object();
  const SpaceBodyParameters p = space_body_parameters(object, kG);
  const SpaceWall ground{Vec3{0.0}, {0.0, 0.0, 1.0}, ground_gains(0.3, 0.3)};
  SpaceWallContacts contacts;
  SpaceBody b;
  b.p.z = 0.03 - 0.3 * kG / 4000;
  b.omega = {20.0, 30.0, 5.0};
  for (int k = 0; k < 2048; ++k)
    b = step(p, Integrator::kZeroOrderHold, kTick, b,
             hold_back(contacts, ground, shape_of(object, 0), b, kTick));
  EXPECT_NEAR(b.v.x, 2.0 / 7.0 * 0.03 * 30.0, 1e-9);
  EXPECT_NEAR(b.v.y, -2.0 / 7.0 * 0.03 * 20.0, 1e-9);
  EXPECT_NEAR(b.omega.z, 5.0, 1e-12);  // nothing rubs against spinning on the spot
}

TEST(SpaceWall, ACornerThatLiftsOffComesDownElsewhereWithoutStretch) {
  // Springs alone, and one edge stays down: only corners of the other edge let go and come back.
  const SpaceWall ground{Vec3{0.0}, {0.0, 0.0, 1.0}, without_dampers(ground_gains(0.6, 0.5))};
  const SpaceShape box{{0.05, 0.04, 0.03}, 0.0, 0.0, false};
  SpaceWallContacts contacts;
  SpaceBody b;
  b.p.z = 0.0295;
  EXPECT_NEAR(hold_back(contacts, ground, box, b, kTick).force.z, 4 * 4000 * 0.0005, 1e-10);
  SpaceBody leaning = b;
  leaning.q = rotation_by({0.0, 0.02, 0.0});  // +x goes down, -x up, by 1 mm
  (void)hold_back(contacts, ground, box, leaning, kTick);
  leaning.p.x += 0.01;
  (void)hold_back(contacts, ground, box, leaning, kTick);
  b.p.x += 0.01;
  const SpaceWrench w = hold_back(contacts, ground, box, b, kTick);
  // The edge that stayed was dragged 10 mm along and pulls at its limit; the other pulls nothing.
  EXPECT_NEAR(w.force.z, 8.0, 1e-10);
  EXPECT_GE(w.force.x, -0.6 * 4.0 * (1 + 1e-12));
  EXPECT_NEAR(w.torque.z, 0.0, 1e-12);
}

TEST(SpaceWall, AFingerIsHeldBackByItsSurface) {
  const SpaceWall ground{Vec3{0.0}, {0.0, 0.0, 1.0}, ground_gains(0.6, 0.5)};
  ContactMemory<Vec3> memory;
  EXPECT_EQ(length(hold_back(memory, ground, {{0.0, 0.0, 0.0081}, Vec3{0.0}}, 0.008, kTick)), 0.0);
  Vec3 f = hold_back(memory, ground, {{0.0, 0.0, 0.007}, Vec3{0.0}}, 0.008, kTick);
  EXPECT_NEAR(f.z, 4.0, 1e-12);
  f = hold_back(memory, ground, {{0.0001, -0.0002, 0.007}, Vec3{0.0}}, 0.008, kTick);
  EXPECT_LT(length(f - Vec3{-0.7, 1.4, 4.0}), 1e-12);
}

}  // namespace
}  // namespace tandem::core
