#include "core/space_contact.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "core/plane_contact.h"
#include "tests/core/space_testing.h"

// Fingers against boxes and spheres: faces, edges, corners, the cone, the contact point.
namespace tandem::core {
namespace {

const SpaceShape kBox{{0.05, 0.04, 0.03}, 0.0, 0.0, false};
const SpaceShape kRound{{0.05, 0.04, 0.03}, 0.0, 0.01, false};
const SpaceShape kBall{Vec3{0.0}, 0.03, 0.008, true};

Vec3 unit(int face) {
  Vec3 n{0.0};
  n[face >> 1] = (face & 1) ? -1.0 : 1.0;
  return n;
}

SpaceBody tilted() {
  SpaceBody body;
  body.p = {0.3, -0.1, 0.2};
  body.q = rotation_by({0.5, -1.1, 0.7});
  return body;
}

/// A finger at a point of the body that moves with it.
SpacePoint carried(const PlacedSpaceBody& body, const Vec3& p_B, const Vec3& v_B = Vec3{0.0}) {
  const Vec3 arm = body.to_world(p_B);
  return {body.p + arm, body.v + glm::cross(body.omega, arm) + body.to_world(v_B)};
}

TEST(SpaceContact, EachOfTheSixFacesPushesAlongItsOutwardNormalByItsDepth) {
  const PlacedSpaceBody body(tilted());
  for (int face = 0; face < 6; ++face) {
    for (const SpaceShape& shape : {kBox, kRound}) {
      const double reach = shape.half[face >> 1] + shape.finger_radius;
      FingerSpaceContact contact;
      const Vec3 side{0.004, -0.003, 0.002};
      const Vec3 across = side - unit(face) * glm::dot(side, unit(face));
      EXPECT_EQ(length(touch(contact, finger_gains(), shape, body,
                             carried(body, unit(face) * (reach + 1e-3) + across), kTick)
                           .on_finger_W),
                0.0);
      const Vec3 p_B = unit(face) * (reach - 2e-3) + across;
      const auto f = touch(contact, finger_gains(), shape, body, carried(body, p_B), kTick);
      const Vec3 expected = glm::mat3_cast(body.q) * unit(face) * (800.0 * 2e-3);
      EXPECT_LT(length(f.on_finger_W - expected), 1e-12);
      EXPECT_LT(length(f.on_body.force + expected), 1e-12);
      EXPECT_LT(length(f.on_body.torque - glm::cross(glm::mat3_cast(body.q) * p_B, -expected)),
                1e-14);
      EXPECT_EQ(contact.face, face);
    }
  }
}

TEST(SpaceContact, TheEnteredFaceStaysHoweverDeepTheFingerIsPressed) {
  const PlacedSpaceBody body(SpaceBody{});
  FingerSpaceContact contact;
  for (double x = 0.06; x > -0.08; x -= 0.001) {  // through and out of the other side
    const auto f = touch(contact, without_dampers(finger_gains()), kBox, body,
                         {{x, 0.0, 0.0}, Vec3{0.0}}, kTick);
    EXPECT_NEAR(f.on_finger_W.x, x < 0.05 ? 800.0 * (0.05 - x) : 0.0, 1e-10);
  }
}

TEST(SpaceContact, AThinBoxStopsAFingerAtTwoMetresASecondFromEverySide) {
  // 1 mm thick; the finger makes 1.95 mm a tick and is never seen inside.
  const PlacedSpaceBody body(tilted());
  for (int face = 0; face < 6; ++face) {
    SpaceShape plate{{0.05, 0.05, 0.05}, 0.0, 0.0, false};
    plate.half[face >> 1] = 0.0005;
    FingerSpaceContact contact;
    const Vec3 v = unit(face) * -2.0;
    double height = 0.0015;
    for (int k = 0; k < 3; ++k, height -= 2.0 * kTick) {
      const auto f = touch(contact, finger_gains(), plate, body,
                           carried(body,
                                   unit(face) * height + Vec3{0.003} -
                                       unit(face) * (0.003 * glm::dot(Vec3{1.0}, unit(face))),
                                   v),
                           kTick);
      const double pushed = glm::dot(f.on_finger_W, glm::mat3_cast(body.q) * unit(face));
      EXPECT_NEAR(pushed, height < 0.0005 ? 800.0 * (0.0005 - height) + 3.0 * 2.0 : 0.0, 1e-9);
    }
  }
}

TEST(SpaceContact, AWayThatOnlyClipsAnEdgeIsNoContact) {
  const Vec3 reach{0.05, 0.04, 0.03};
  EXPECT_EQ(entered_face(reach, {0.051, 0.0, 0.0}, {0.049, 0.0, 0.0}), 0);
  EXPECT_EQ(entered_face(reach, {0.0, 0.0, -0.031}, {0.0, 0.0, 0.05}), 5);
  EXPECT_EQ(entered_face(reach, {0.051, 0.0, 0.0}, {0.049, 0.041, 0.0}), -1);
  EXPECT_EQ(entered_face(reach, {0.051, 0.039, 0.0}, {0.0495, 0.0405, 0.0}), -1);
  EXPECT_EQ(entered_face(reach, {0.052, 0.0, 0.0}, {0.0505, 0.0, 0.0}), -1);
}

TEST(SpaceContact, InAPlaneAcrossAFlatFaceItIsTheContactOfThePlane) {
  // The same finger path in both worlds: the box turns and moves, the finger presses and slides.
  for (const double radius : {0.0, 0.01}) {
    const SpaceShape shape{{0.05, 0.04, 0.03}, 0.0, radius, false};
    const PlaneBox flat{{0.05, 0.04}, radius};
    FingerSpaceContact contact;
    FingerBoxContact plane_contact;
    int slides = 0;
    for (int k = 0; k < 4000; ++k) {
      const double t = k * kTick;
      PlaneBody b;
      b.p = {0.01 * std::sin(t), 0.02 * t};
      b.angle = 0.8 * t;
      b.v = {0.01 * std::cos(t), 0.02};
      b.omega = 0.8;
      const PlacedBody placed(b);
      const Vec2 p_B{0.051 + radius - 0.004 * std::fmin(t, 1.0), 0.02 * std::sin(2 * t)};
      const Vec2 v_B{t < 1.0 ? -0.004 : 0.0, 0.04 * std::cos(2 * t)};
      const Vec2 arm = placed.to_world(p_B);
      const PlanePoint finger{b.p + arm, b.v + cross(b.omega, arm) + placed.to_world(v_B)};
      SpaceBody body;
      body.p = {b.p, 0.0};
      body.q = rotation_by({0.0, 0.0, b.angle});
      body.v = {b.v, 0.0};
      body.omega = {0.0, 0.0, b.omega};
      const auto f =
          touch(contact, finger_gains(), shape, body, {{finger.p, 0.0}, {finger.v, 0.0}}, kTick);
      const auto g = touch(plane_contact, finger_gains(), flat, placed, finger, kTick);
      ASSERT_EQ(contact.memory.state, plane_contact.memory.state) << k;
      ASSERT_LT(length(f.on_finger_W - Vec3{g.on_finger_W, 0.0}), 1e-11);
      ASSERT_NEAR(f.on_body.torque.z, g.on_body.torque, 1e-12);
      slides += contact.memory.state == ContactState::kSlide;
    }
    EXPECT_GT(slides, 100);
  }
}

TEST(SpaceContact, RoundedEdgesAndCornersPushAwayFromTheNearestPointOfTheBox) {
  const PlacedSpaceBody body(tilted());
  Random random(11);
  int edges = 0, corners = 0;
  for (int i = 0; i < 20000; ++i) {
    const Vec3 p_B = Vec3{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)} *
                     (kRound.half + Vec3{0.01});
    const Vec3 nearest = glm::clamp(p_B, -kRound.half, kRound.half);
    const double distance = length(p_B - nearest);
    if (distance == 0.0) continue;  // below a face: another test
    const int outside = (nearest.x != p_B.x) + (nearest.y != p_B.y) + (nearest.z != p_B.z);
    edges += outside == 2, corners += outside == 3;
    FingerSpaceContact contact;
    const auto f =
        touch(contact, without_dampers(finger_gains()), kRound, body, carried(body, p_B), kTick);
    const double depth = std::fmax(0.0, 0.01 - distance);
    const Vec3 expected = glm::mat3_cast(body.q) * ((p_B - nearest) * (800.0 * depth / distance));
    ASSERT_LT(length(f.on_finger_W - expected), 1e-11);
  }
  EXPECT_GT(edges, 1000);
  EXPECT_GT(corners, 100);
}

TEST(SpaceContact, AFingerThatGoesRoundAnEdgeFeelsNoJump) {
  // A quarter circle round the edge between +x and +y at 2 mm depth, from face to face, in 2000
  // steps of 8 um: a jump would be a large part of the 1.6 N.
  const PlacedSpaceBody body(SpaceBody{});
  FingerSpaceContact contact;
  Vec3 last{0.0};
  double most = 0.0;
  for (int i = -500; i <= 2500; ++i) {
    Vec3 p{0.0, 0.0, 0.01};
    if (i < 0)
      p = {0.058, 0.04 + 8e-6 * i, 0.01};
    else if (i > 2000)
      p = {0.05 - 8e-6 * (i - 2000), 0.048, 0.01};
    else
      p = {0.05 + 0.008 * std::cos(kHalfTurn / 4000 * i),
           0.04 + 0.008 * std::sin(kHalfTurn / 4000 * i), 0.01};
    const auto f = touch(contact, without_dampers(finger_gains(0.0, 0.0)), kRound, body,
                         {p, Vec3{0.0}}, kTick);
    if (i > -500) most = std::fmax(most, length(f.on_finger_W - last));
    last = f.on_finger_W;
  }
  EXPECT_LT(most, 1.6 * kHalfTurn / 4000 * 1.01);  // the turn of the normal in one step, no more
  EXPECT_NEAR(last.y, 1.6, 1e-12);
}

TEST(SpaceContact, TheLimitOfFrictionIsTheSameInAllDirectionsOfTheFace) {
  const PlacedSpaceBody body(tilted());
  for (const SpaceShape& shape : {kBox, kBall}) {
    const double reach = shape.is_sphere ? 0.038 : 0.03;
    for (int i = 0; i < 64; ++i) {
      const double angle = 2 * kHalfTurn * i / 64;
      const Vec3 along{std::cos(angle), std::sin(angle), 0.0};
      FingerSpaceContact contact;
      double greatest = 0.0;
      SpaceContactForces f;
      for (int k = 0; k < 3000;
           ++k) {  // drawn out slowly: sticks to the edge of the cone, then slips
        const double s = 1e-6 * k, height = reach - 0.005;
        const Vec3 p = shape.is_sphere ? along * (height * std::sin(s / height)) +
                                             Vec3{0.0, 0.0, height * std::cos(s / height)}
                                       : along * s + Vec3{0.0, 0.0, height};
        f = touch(contact, without_dampers(finger_gains()), shape, body, carried(body, p), kTick);
        const Vec3 n = shape.is_sphere ? p * (1.0 / length(p)) : Vec3{0.0, 0.0, 1.0};
        const Vec3 f_B = body.to_body(f.on_finger_W);
        const double normal = glm::dot(n, f_B), tangential = length(f_B - n * normal);
        ASSERT_NEAR(normal, 4.0, 1e-10);
        ASSERT_LE(tangential, 0.6 * normal * (1 + 1e-12));
        greatest = std::fmax(greatest, tangential);
      }
      // One step of 1 um is 1.2 mN on 1200 N/m: as near as the edge of the cone is met.
      EXPECT_NEAR(greatest, 0.6 * 4.0, 1.3e-3) << angle;
    }
  }
}

TEST(SpaceContact, TheContactPointTravelsWithTheBody) {
  // Body and finger move as one; nothing slips, so nothing but the normal force may come.
  for (const SpaceShape& shape : {kBox, kRound, kBall}) {
    SpaceBody b = tilted();
    b.v = {0.4, -0.2, 0.3};
    b.omega = {1.0, -3.0, 2.0};
    FingerSpaceContact contact;
    const Vec3 p_B = shape.is_sphere ? Vec3{0.01, 0.02, 0.0275} : Vec3{0.01, 0.02, 0.028};
    for (int k = 0; k < 2000; ++k) {
      b.p += b.v * kTick;
      b.q = rotation_by(b.omega * kTick) * b.q;
      const PlacedSpaceBody body(b);
      const auto f = touch(contact, finger_gains(), shape, body, carried(body, p_B), kTick);
      const Vec3 n = shape.is_sphere ? p_B * (1.0 / length(p_B)) : Vec3{0.0, 0.0, 1.0};
      const Vec3 f_B = body.to_body(f.on_finger_W);
      ASSERT_GT(glm::dot(n, f_B), 0.5);
      ASSERT_LT(length(f_B - n * glm::dot(n, f_B)), 1e-10);  // 1200 N/m on 1e-14 m, dampers
    }
  }
}

TEST(SpaceContact, OnASphereStretchDependsOnThePlaceAloneAndIsTheChord) {
  const PlacedSpaceBody body(tilted());
  const double rho = 0.030;
  const auto at = [&](double theta, double phi) {
    return Vec3{std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)} *
           rho;
  };
  FingerSpaceContact contact;
  const ContactGains gains = without_dampers(finger_gains());
  (void)touch(contact, gains, kBall, body, carried(body, at(0, 0)), kTick);
  for (int round = 0; round < 5; ++round)
    for (int k = 0; k <= 360; ++k) {  // circles of 0.1 rad: 3.6 N of 3.84 N that stick
      const double phi = kHalfTurn * k / 180;
      const auto f = touch(contact, gains, kBall, body, carried(body, at(0.1, phi)), kTick);
      const Vec3 n = at(0.1, phi) * (1.0 / rho);
      const Vec3 f_B = body.to_body(f.on_finger_W);
      EXPECT_NEAR(glm::dot(n, f_B), 800.0 * 0.008, 1e-11);
      ASSERT_NEAR(length(f_B - n * glm::dot(n, f_B)), 1200.0 * rho * std::sin(0.1), 1e-11);
    }
  const auto back = touch(contact, gains, kBall, body, carried(body, at(0, 0)), kTick);
  EXPECT_LT(length(body.to_body(back.on_finger_W) - Vec3{0.0, 0.0, 6.4}), 1e-11);
}

TEST(SpaceContact, ASmallSphereIsNotPassedByAFastFinger) {
  const PlacedSpaceBody body(SpaceBody{});
  const SpaceShape bead{Vec3{0.0}, 0.0006, 0.0, true};  // 1.2 mm; 1.95 mm a tick
  FingerSpaceContact contact;
  double x = 0.0021;
  for (int k = 0; k < 4; ++k, x -= 2.0 * kTick) {
    const auto f = touch(contact, without_dampers(finger_gains(0, 0)), bead, body,
                         {{x, 0.0, 0.0}, {-2.0, 0.0, 0.0}}, kTick);
    EXPECT_NEAR(f.on_finger_W.x, x < 0.0006 ? 800.0 * (0.0006 - x) : 0.0, 1e-10);
  }
  Vec3 normal;
  EXPECT_FALSE(entered_sphere(1.0, {2.0, 1.1, 0.0}, {-2.0, 1.1, 0.0}, normal));  // passes by
  EXPECT_FALSE(entered_sphere(1.0, {2.0, 0.0, 0.0}, {1.5, 0.0, 0.0}, normal));   // not there yet
  EXPECT_FALSE(entered_sphere(1.0, {2.0, 0.0, 0.0}, {5.0, 0.0, 0.0}, normal));   // moves away
  ASSERT_TRUE(entered_sphere(1.0, {2.0, 0.6, 0.0}, {-3.0, 0.6, 0.0}, normal));
  EXPECT_LT(length(normal - Vec3{0.8, 0.6, 0.0}), 1e-15);
}

TEST(SpaceContact, ForcesOnFingerAndBodyAlwaysBalanceAndStayInTheCone) {
  Random random(13);
  for (const SpaceShape& shape : {kBox, kRound, kBall}) {
    FingerSpaceContact contact;
    SpaceBody b = tilted();
    Vec3 p_B{0.0, 0.0, 0.05};
    int touched = 0;
    for (int k = 0; k < 50000; ++k) {
      b.omega = random_vector(random, 2.0);
      b.q = rotation_by(b.omega * kTick) * b.q;
      p_B = p_B * 0.999 + random_vector(random, 0.0015);
      const PlacedSpaceBody body(b);
      const SpacePoint finger = carried(body, p_B, random_vector(random, 0.05));
      const auto f = touch(contact, finger_gains(), shape, body, finger, kTick);
      ASSERT_LT(length(f.on_finger_W + f.on_body.force), 1e-12);
      ASSERT_LT(length(f.on_body.torque + glm::cross(finger.p - b.p, f.on_finger_W)), 1e-12);
      if (contact.memory.state == ContactState::kFree) {
        ASSERT_EQ(length(f.on_finger_W), 0.0);
        continue;
      }
      ++touched;
      std::int32_t face = contact.face;
      Vec3 side = contact.normal_B;
      const Vec3 n = body.to_world(shape.is_sphere ? sphere_surface(shape, side, p_B).normal_B
                                                   : box_surface(shape, face, p_B).normal_B);
      const double normal = glm::dot(n, f.on_finger_W);
      ASSERT_GE(normal, -1e-12);
      ASSERT_LE(length(f.on_finger_W - n * normal), 0.6 * normal * (1 + 1e-9) + 1e-12);
    }
    EXPECT_GT(touched, 5000);
  }
}

TEST(SpaceContact, AnAttachedFingerPullsAndPushesWithItsTwoGains) {
  const PlacedSpaceBody start(tilted());
  for (const SpaceShape& shape : {kBox, kBall}) {
    const Vec3 p_B = shape.is_sphere ? Vec3{0.0, 0.0, 0.03} : Vec3{0.01, 0.005, 0.03};
    const auto contact = attach(shape, start, carried(start, p_B));
    EXPECT_LT(length(contact.normal_B - Vec3{0.0, 0.0, 1.0}), 1e-15);
    SpaceBody b = tilted();
    b.q = rotation_by({0.3, 0.2, -0.5}) * b.q;
    b.omega = {1.0, 2.0, 3.0};
    const PlacedSpaceBody body(b);
    const Vec3 stretch{0.001, -0.002, 0.003}, rate{0.01, 0.02, -0.03};
    const SpacePoint finger = carried(body, p_B + stretch, rate);
    const auto f = hold(contact, {800.0, 3.0}, {1200.0, 10.0}, body, finger);
    const Vec3 expected_B = -(Vec3{1200.0, 1200.0, 800.0} * stretch + Vec3{10.0, 10.0, 3.0} * rate);
    EXPECT_LT(length(f.on_finger_W - glm::mat3_cast(b.q) * expected_B), 1e-12);
    EXPECT_LT(length(f.on_body.force + f.on_finger_W), 1e-15);
    EXPECT_LT(length(f.on_body.torque + glm::cross(finger.p - b.p, f.on_finger_W)), 1e-14);
  }
}

}  // namespace
}  // namespace tandem::core
