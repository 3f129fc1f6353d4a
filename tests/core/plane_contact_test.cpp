#include "core/plane_contact.h"

#include <array>
#include <cmath>
#include <type_traits>
#include <vector>

#include <gtest/gtest.h>

#include "core/plane_body.h"
#include "core/random.h"

namespace tandem::core {
namespace {

constexpr double kT = 1.0 / 1024.0;
constexpr double kPi = 3.14159265358979323846;

static_assert(std::is_trivially_copyable_v<FingerBoxContact>);
static_assert(std::is_trivially_copyable_v<WallContacts>);

ContactGains grasp_gains() {
  ContactGains gains;
  gains.normal = {800.0, 3.0};
  gains.tangential = {1200.0, 10.0};
  gains.friction = {0.6, 0.5, 0.005};
  return gains;
}

const PlaneBox kBox{{0.05, 0.04}, 0.0};

/// Leads a finger from `from` to `to` in the world at `speed`; returns the last forces.
ContactForces lead(FingerBoxContact& contact, const PlaneBox& box, const PlaneBody& body, Vec2 from,
                   Vec2 to, double speed) {
  const Vec2 way = to - from;
  const double length = std::sqrt(inner(way, way));
  const Vec2 v = way * (speed / length);
  const int ticks = static_cast<int>(length / (speed * kT));
  ContactForces f;
  for (int k = 0; k <= ticks; ++k)
    f = touch(contact, grasp_gains(), box, body, {from + v * (k * kT), v}, kT);
  return f;
}

TEST(PlaneContact, EachFacePushesOutwardsByThePenetration) {
  const std::array<Vec2, 4> outward{Vec2{1, 0}, Vec2{-1, 0}, Vec2{0, 1}, Vec2{0, -1}};
  for (int side = 0; side < 4; ++side) {
    FingerBoxContact contact;
    const Vec2 n = outward[side];
    const double half = side < 2 ? 0.05 : 0.04;
    (void)touch(contact, grasp_gains(), kBox, PlaneBody{}, {n * 0.06, {}}, kT);
    EXPECT_EQ(contact.memory.state, ContactState::kFree);
    const auto f =
        touch(contact, grasp_gains(), kBox, PlaneBody{}, {n * (half - 0.002), Vec2{0.0}}, kT);
    EXPECT_EQ(contact.side, side);
    EXPECT_NEAR(inner(f.on_finger_W, n), 800 * 0.002, 1e-12);
    EXPECT_EQ(f.on_body.force, -f.on_finger_W);
    EXPECT_NEAR(f.on_body.torque, 0.0, 1e-15);
  }
}

TEST(PlaneContact, CornerEntryTakesTheFaceThatWasCrossed) {
  // Both ways end at the same point 1 mm from either face, near the corner (0.05, 0.04).
  const Vec2 end{0.049, 0.039};
  FingerBoxContact from_right, from_above;
  (void)touch(from_right, grasp_gains(), kBox, PlaneBody{}, {end + Vec2{0.003, 0.0005}, {}}, kT);
  (void)touch(from_right, grasp_gains(), kBox, PlaneBody{}, {end, Vec2{0.0}}, kT);
  EXPECT_EQ(from_right.side, 0);
  (void)touch(from_above, grasp_gains(), kBox, PlaneBody{}, {end + Vec2{0.0005, 0.003}, {}}, kT);
  (void)touch(from_above, grasp_gains(), kBox, PlaneBody{}, {end, Vec2{0.0}}, kT);
  EXPECT_EQ(from_above.side, 2);
  // From outside both faces: the slab entered last is the face. Way (+3, +2.5) mm to the corner
  // point: reaches x = 0.05 after 2/3 of it and y = 0.04 after 1.5/2.5 = 0.6, so the x face.
  FingerBoxContact diagonal;
  (void)touch(diagonal, grasp_gains(), kBox, PlaneBody{}, {end + Vec2{0.003, 0.0025}, {}}, kT);
  (void)touch(diagonal, grasp_gains(), kBox, PlaneBody{}, {end, Vec2{0.0}}, kT);
  EXPECT_EQ(diagonal.side, 0);
}

TEST(PlaneContact, AFingerThatPassesAThinBoxWithinATickIsCaught) {
  const PlaneBox thin{{0.0005, 0.04}, 0.0};  // 1 mm thick, 2 m/s is 1.95 mm a tick
  for (const double sign : {1.0, -1.0}) {
    for (int phase = 0; phase < 50; ++phase) {
      FingerBoxContact contact;
      ContactForces f;
      const double start = -sign * (0.003 + phase * 4e-5);
      int ticks_in_contact = 0;
      for (int k = 0; k < 6; ++k) {
        const double x = start + sign * 2.0 * k * kT;
        f = touch(contact, grasp_gains(), thin, PlaneBody{}, {{x, 0.0}, {sign * 2.0, 0.0}}, kT);
        if (contact.memory.state == ContactState::kFree) continue;
        ++ticks_in_contact;
        EXPECT_LT(f.on_finger_W.x * sign, 0.0);  // back to where it came from, never through
        EXPECT_NEAR(f.on_finger_W.x * sign, -(800 * (x * sign + 0.0005) + 3 * 2.0), 1e-9);
      }
      EXPECT_GE(ticks_in_contact, 3);
    }
  }
}

TEST(PlaneContact, ADeepFingerDoesNotPopToTheOppositeFace) {
  const PlaneBox thin{{0.002, 0.04}, 0.0};
  FingerBoxContact contact;
  for (int k = 0; k < 200; ++k) {
    const double x = -0.003 + 5e-5 * k;  // slowly through 4 mm of box
    const auto f = touch(contact, grasp_gains(), thin, PlaneBody{}, {{x, 0.0}, {0.0, 0.0}}, kT);
    if (x > -0.002 + 1e-9) {
      EXPECT_NEAR(f.on_finger_W.x, -800 * (x + 0.002), 1e-9) << x;
    }
  }
}

TEST(PlaneContact, AMovingBoxIsSweptOverAStandingFinger) {
  const PlaneBox thin{{0.0005, 0.04}, 0.0};
  FingerBoxContact contact;
  PlaneBody body{{-0.0031, 0.0}, 0.0, {2.0, 0.0}, 0.0};
  for (int k = 0; k < 4; ++k) {
    (void)touch(contact, grasp_gains(), thin, body, {{0.0, 0.0}, {0.0, 0.0}}, kT);
    body.p += body.v * kT;
  }
  EXPECT_NE(contact.memory.state, ContactState::kFree);
  EXPECT_EQ(contact.side, 0);
}

TEST(PlaneContact, ACornerThatIsOnlyClippedWithinATickIsNotHeld) {
  FingerBoxContact contact;
  (void)touch(contact, grasp_gains(), kBox, PlaneBody{}, {{0.051, 0.0395}, {}}, kT);
  (void)touch(contact, grasp_gains(), kBox, PlaneBody{}, {{0.0492, 0.0408}, Vec2{0.0}}, kT);
  EXPECT_EQ(contact.memory.state, ContactState::kFree);
}

TEST(PlaneContact, AFingerFoundInsideAtTheFirstTickTakesTheNearestFace) {
  FingerBoxContact contact;
  (void)touch(contact, grasp_gains(), kBox, PlaneBody{}, {{0.01, -0.035}, {}}, kT);
  EXPECT_EQ(contact.side, 3);
}

TEST(PlaneContact, SlidingOffTheEndOfAFaceEndsTheContact) {
  FingerBoxContact contact;
  (void)lead(contact, kBox, PlaneBody{}, {0.055, 0.035}, {0.048, 0.035}, 0.05);
  ASSERT_NE(contact.memory.state, ContactState::kFree);
  const auto f = lead(contact, kBox, PlaneBody{}, {0.048, 0.035}, {0.048, 0.045}, 0.05);
  EXPECT_EQ(contact.memory.state, ContactState::kFree);
  EXPECT_EQ(f.on_finger_W, Vec2(0.0));
}

TEST(PlaneContact, TheContactPointRidesOnATurningAndTravellingBoxWithoutAnyChangeOfForce) {
  for (const double radius : {0.0, 0.008}) {
    const PlaneBox box{kBox.half, radius};
    FingerBoxContact contact;
    PlaneBody body{{0.1, 0.2}, 0.4, {0.3, -0.2}, 5.0};
    const Vec2 finger_B{0.048 + radius, 0.02};
    const auto rigid = [&](const PlaneBody& b) {
      const PlacedBody placed(b);
      const Vec2 arm = placed.to_world(finger_B);
      return PlanePoint{b.p + arm, b.v + cross(b.omega, arm)};
    };
    for (int k = 0; k < 3000; ++k) {
      const PlacedBody placed(body);
      const auto f = touch(contact, grasp_gains(), box, placed, rigid(body), kT);
      const Vec2 force_B = placed.to_body(f.on_finger_W);
      ASSERT_NEAR(force_B.x, 800 * 0.002, 1e-9);
      ASSERT_NEAR(force_B.y, 0.0, 1e-9);
      body.p += body.v * kT;  // 3 s: 14.6 rad
      body.angle += body.omega * kT;
    }
    EXPECT_EQ(contact.memory.state, ContactState::kPreSlide);
  }
}

TEST(PlaneContact, ForcesTurnWithEverythingElse) {
  Random random(2);
  for (int trial = 0; trial < 200; ++trial) {
    const double turn = random.uniform(-3.0, 3.0);
    const SinCos sc = sin_cos(turn);
    const auto rotated = [&](const Vec2& a) {
      return Vec2{sc.cos * a.x - sc.sin * a.y, sc.sin * a.x + sc.cos * a.y};
    };
    FingerBoxContact a, b;
    WallContacts wa, wb;
    PlaneWall wall{{0.0, -0.05}, {0.0, 1.0}, grasp_gains()};
    PlaneWall wall_turned{rotated(wall.point), rotated(wall.normal), grasp_gains()};
    PlaneBody body{{0.01, -0.02}, random.uniform(-1.0, 1.0), {0.1, -0.3}, 1.0};
    const Vec2 start{0.08, 0.01}, v{-0.3, random.uniform(-0.2, 0.2)};
    for (int k = 0; k < 200; ++k) {
      const PlanePoint finger{start + v * (k * kT), v};
      PlaneBody body_turned{rotated(body.p), body.angle + turn, rotated(body.v), body.omega};
      const auto fa = touch(a, grasp_gains(), kBox, body, finger, kT);
      const auto fb =
          touch(b, grasp_gains(), kBox, body_turned, {rotated(finger.p), rotated(finger.v)}, kT);
      const auto ha = hold_back(wa, wall, kBox, body, kT);
      const auto hb = hold_back(wb, wall_turned, kBox, body_turned, kT);
      const Vec2 df = rotated(fa.on_finger_W) - fb.on_finger_W;
      const Vec2 dh = rotated(ha.force) - hb.force;
      ASSERT_LT(std::sqrt(inner(df, df)), 1e-9);  // rounding of positions times stiffness
      ASSERT_LT(std::sqrt(inner(dh, dh)), 1e-9);
      ASSERT_NEAR(fa.on_body.torque, fb.on_body.torque, 1e-10);
      ASSERT_NEAR(ha.torque, hb.torque, 1e-10);
      body.p += body.v * kT;
      body.angle += body.omega * kT;
    }
  }
}

TEST(PlaneContact, ARoundFingerRollsRoundACornerWithContinuousForce) {
  const double radius = 0.01, press = 0.001;
  const PlaneBox box{kBox.half, radius};
  FingerBoxContact contact;
  ContactGains gains = grasp_gains();
  gains.friction = {};
  // Round the corner (0.05, 0.04) at constant depth, from the +x face to the +y face.
  (void)touch(contact, gains, box, PlaneBody{}, {{0.05 + radius - press, 0.03}, {}}, kT);
  for (int k = 0; k <= 900; ++k) {
    const double a = k * kPi / 1800;
    const Vec2 n{std::cos(a), std::sin(a)};
    const Vec2 centre = Vec2{0.05, 0.04} + n * (radius - press);
    const auto f = touch(contact, gains, box, PlaneBody{}, {centre, Vec2{0.0}}, kT);
    ASSERT_NEAR(f.on_finger_W.x, 800 * press * n.x, 1e-9) << k;
    ASSERT_NEAR(f.on_finger_W.y, 800 * press * n.y, 1e-9) << k;
  }
  const auto f =
      touch(contact, gains, box, PlaneBody{}, {{0.049, 0.04 + radius - press}, Vec2{0.0}}, kT);
  EXPECT_EQ(contact.side, 2);
  EXPECT_NEAR(f.on_finger_W.y, 800 * press, 1e-9);
}

TEST(PlaneContact, AttachedContactIsABilateralCouplerInTheFrameOfTheBox) {
  const PlaneBody body{{0.1, 0.0}, kPi / 2, {0.0, 0.0}, 0.0};  // its +x face looks to +y
  const AttachedContact contact = attach(kBox, body, {{0.1, 0.05}, {}});
  EXPECT_EQ(contact.normal_B, Vec2(1.0, 0.0));
  const auto f = hold(contact, {800, 3}, {1200, 10}, body, {{0.101, 0.052}, {0.1, 0.2}});
  EXPECT_NEAR(f.on_finger_W.y, -800 * 0.002 - 3 * 0.2, 1e-9);  // pulls as well as pushes
  EXPECT_NEAR(f.on_finger_W.x, -1200 * 0.001 - 10 * 0.1, 1e-9);
  EXPECT_NEAR(f.on_body.torque, -(0.001 * f.on_finger_W.y - 0.052 * f.on_finger_W.x), 1e-12);
}

}  // namespace
}  // namespace tandem::core
