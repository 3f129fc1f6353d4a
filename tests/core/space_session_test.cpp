#include <array>
#include <cmath>
#include <string>
#include <type_traits>

#include <gtest/gtest.h>

#include "arch_central/central_loop.h"
#include "arch_distributed/distributed_loop.h"
#include "core/space_world.h"
#include "tests/core/space_testing.h"

// The world of space in sessions: momentum, isotropy, grasps, copies, laws and loops.
namespace tandem::core {
namespace {

static_assert(std::is_trivially_copyable_v<SpaceWorld>);
static_assert(std::is_trivially_copyable_v<distributed::ReplicaLaw<SpaceWorld>>);
static_assert(std::is_trivially_copyable_v<central::ServerLaw<SpaceWorld>>);

ObjectParameters box_object() {
  ObjectParameters object;
  object.name = "box";
  object.shape = Shape::kBox;
  object.size = {0.06, 0.08, 0.05};
  object.mass = 0.7;
  return object;
}

/// A box and a ball with two free fingers each pressed on from outside, nothing else in the world.
struct Island {
  SpaceShape shape;
  SpaceBodyParameters p;
  SpaceBody body;
  std::array<SpacePoint, 2> fingers{};
  std::array<FingerSpaceContact, 2> contacts{};
  double finger_mass = 0.07;

  /// Semi-implicit Euler, for fingers too: then p x m v is kept exactly as well.
  void tick() {
    const PlacedSpaceBody placed(body);
    SpaceWrench wrench;
    for (int i = 0; i < 2; ++i) {
      const auto f = touch(contacts[i], finger_gains(), shape, placed, fingers[i], kTick);
      wrench += f.on_body;
      advance(Integrator::kSemiImplicitEuler, kTick, 0.0, fingers[i].p, fingers[i].v,
              f.on_finger_W * (1.0 / finger_mass));
    }
    body = step(p, Integrator::kSemiImplicitEuler, kTick, body, wrench);
  }
  Vec3 momentum() const {
    Vec3 sum = body.v * (1.0 / p.inverse_mass);
    for (const SpacePoint& f : fingers) sum += f.v * finger_mass;
    return sum;
  }
  Vec3 angular_momentum() const {
    const Axes axes = axes_of(body.q);
    Vec3 sum = glm::cross(body.p, body.v) * (1.0 / p.inverse_mass) +
               axes.to_world(p.inertia * axes.to_body(body.omega));
    for (const SpacePoint& f : fingers) sum += glm::cross(f.p, f.v) * finger_mass;
    return sum;
  }
};

Island island(bool ball) {
  ObjectParameters object = box_object();
  if (ball) {
    object.shape = Shape::kSphere;
    object.size = Vec3{0.0};
    object.radius = 0.03;
  }
  Island s;
  s.shape = shape_of(object, 0.008);
  s.p = space_body_parameters(object, 0.0);
  s.body.p = {0.2, 0.1, -0.1};
  s.body.omega = {0.5, -0.3, 0.4};
  s.fingers[0] = {s.body.p + Vec3{-0.06, 0.012, 0.008}, {0.5, 0.02, 0.01}};
  s.fingers[1] = {s.body.p + Vec3{0.055, -0.011, 0.004}, {-0.4, 0.03, -0.05}};
  return s;
}

TEST(SpaceSession, NothingFromOutsideChangesMomentumOrAngularMomentum) {
  for (const bool ball : {false, true}) {
    Island s = island(ball);
    const Vec3 momentum = s.momentum(), angular = s.angular_momentum();
    int touched = 0;
    double worst = 0.0, worst_angular = 0.0;
    for (int k = 0; k < 4096; ++k) {
      s.tick();
      for (const auto& c : s.contacts) touched += c.memory.state != ContactState::kFree;
      worst = std::fmax(worst, length(s.momentum() - momentum));
      worst_angular = std::fmax(worst_angular, length(s.angular_momentum() - angular));
    }
    EXPECT_GT(touched, 20);
    // Momenta of 0.03 kg m/s and, with the flight of the parts, 0.03 kg m^2/s: rounding alone.
    EXPECT_LT(worst, 1e-12 * 0.03);
    EXPECT_LT(worst_angular, 1e-12 * 0.03);
  }
}

TEST(SpaceSession, ATurnedWorldRunsTheSameTurned) {
  // Anything tied to the axes of W (pyramids, wrong products) would show.
  const Quat turn = rotation_by({1.1, -0.7, 2.0});
  const auto turned = [&](const Vec3& a) { return glm::mat3_cast(turn) * a; };
  for (const bool ball : {false, true}) {
    Island s = island(ball), r = s;
    r.body.p = turned(s.body.p);
    r.body.q = turn * s.body.q;
    r.body.omega = turned(s.body.omega);
    for (int i = 0; i < 2; ++i) r.fingers[i] = {turned(s.fingers[i].p), turned(s.fingers[i].v)};
    SpaceWall wall{{0.3, 0.0, 0.0}, {-1.0, 0.0, 0.0}, ground_gains(0.6, 0.5)};
    SpaceWall turned_wall{turned(wall.point), turned(wall.normal), wall.gains};
    SpaceWallContacts walls, turned_walls;
    s.body.v = {0.3, 0.1, 0.0};
    r.body.v = turned(s.body.v);
    for (int k = 0; k < 1024; ++k) {
      for (const bool is_turned : {false, true}) {
        Island& one = is_turned ? r : s;
        const SpaceWrench w = hold_back(is_turned ? turned_walls : walls,
                                        is_turned ? turned_wall : wall, one.shape, one.body, kTick);
        one.tick();
        one.body = step(one.p, Integrator::kZeroOrderHold, 0.0, one.body, {});
        one.body.v += w.force * (kTick * one.p.inverse_mass);
      }
    }
    EXPECT_GT(length(s.body.p - Vec3{0.2, 0.1, -0.1}), 0.01);
    EXPECT_LT(length(r.body.p - turned(s.body.p)), 1e-11);  // rounding grows in the bounces
    EXPECT_LT(length(rotation_between(turn * s.body.q, r.body.q)), 1e-10);
  }
}

TEST(SpaceSession, TwoFingersHoldABoxAgainstItsWeightJustAsLongAsTheConesCarryIt) {
  // 2 mu f_n > m g holds. Fingers stand still at a depth that gives f_n; the box is let go slowly.
  const double mu = 0.6, weight = 0.7 * 9.81;
  for (const double tilt : {0.0, 0.6}) {  // the faces' own axes or across them
    for (const double ratio : {0.97, 1.03}) {
      const double normal = weight / (2 * mu) * ratio;
      const SpaceShape shape = shape_of(box_object(), 0.008);
      const SpaceBodyParameters p = space_body_parameters(box_object(), 0.0);
      SpaceBody b, early;
      b.q = rotation_by({tilt, 0.0, 0.0});
      const double reach = 0.038 - normal / 800.0;
      std::array<FingerSpaceContact, 2> contacts;
      for (int k = 0; k < 4096; ++k) {
        if (k == 3072) early = b;
        const PlacedSpaceBody placed(b);
        SpaceWrench w{{0.0, 0.0, -weight * std::fmin(k / 2048.0, 1.0)}, Vec3{0.0}};
        w += touch(contacts[0], finger_gains(mu, mu), shape, placed, {{reach, 0, 0}, Vec3{0.0}},
                   kTick)
                 .on_body;
        w += touch(contacts[1], finger_gains(mu, mu), shape, placed, {{-reach, 0, 0}, Vec3{0.0}},
                   kTick)
                 .on_body;
        b = step(p, Integrator::kZeroOrderHold, kTick, b, w);
      }
      if (ratio > 1) {
        EXPECT_NEAR(b.p.z, -weight / 2400.0, 1e-6);  // two tangential springs
        EXPECT_LT(length(b.p - early.p), 1e-9);
      } else {
        EXPECT_LT(b.p.z, -0.01);
        EXPECT_LT(b.v.z, -0.1);
      }
    }
  }
}

TEST(SpaceSession, CopiesPullEachOtherTogetherAndKeepTheirMomentum) {
  const SpaceBodyParameters p = space_body_parameters(box_object(), 0.0);
  SpaceBody a, b;
  b.p = {0.01, -0.02, 0.03};
  b.q = rotation_by({0.8, -1.2, 0.5});
  a.v = {0.1, 0.0, 0.2};
  a.omega = {1.0, 0.5, -2.0};
  const auto spin = [&](const SpaceBody& c) {
    const Axes axes = axes_of(c.q);
    return axes.to_world(p.inertia * axes.to_body(c.omega));
  };
  const Vec3 momentum = a.v + b.v, spins = spin(a) + spin(b);
  for (int k = 0; k < 5120; ++k) {
    const SpaceWrench on_a = coordinate({400.0, 8.0}, {10.0, 0.1}, a, b);
    const SpaceWrench on_b = coordinate({400.0, 8.0}, {10.0, 0.1}, b, a);
    ASSERT_LT(length(on_a.torque + on_b.torque), 1e-13);
    a = step(p, Integrator::kSemiImplicitEuler, kTick, a, on_a);
    b = step(p, Integrator::kSemiImplicitEuler, kTick, b, on_b);
  }
  EXPECT_LT(length(a.v + b.v - momentum), 1e-12 * length(momentum));
  EXPECT_LT(length(spin(a) + spin(b) - spins), 1e-12 * length(spins));
  EXPECT_LT(length(a.p - b.p), 1e-9);
  EXPECT_LT(length(rotation_between(a.q, b.q)), 1e-9);
}

TEST(SpaceSession, TheCouplerOfRotationsTurnsTheShortestWay) {
  SpaceBody self, other;
  self.q = rotation_by({0.2, 0.9, -0.4});
  const Vec3 axis{0.6, 0.0, -0.8};
  for (const double angle : {1e-9, 0.5, 3.0, 3.3, 6.0, -3.0}) {
    other.q = rotation_by(axis * angle) * self.q;
    const double way = angle > kHalfTurn ? angle - 2 * kHalfTurn : angle;
    const Vec3 torque = coordinate({0.0, 0.0}, {10.0, 0.0}, self, other).torque;
    EXPECT_LT(length(torque - axis * (10.0 * way)), 1e-14 * std::fmax(1.0, std::fabs(way)));
  }
}

TEST(SpaceSession, ASampleIsCarriedOnByItsVelocities) {
  SpaceBody b;
  b.p = {0.1, 0.2, 0.3};
  b.q = rotation_by({0.4, 0.1, -0.9});
  b.v = {1.0, -2.0, 0.5};
  b.omega = {0.3, 2.0, -1.0};
  const SpaceBody held = SpaceWorld::advance(b, {});
  EXPECT_TRUE(held.p == b.p && held.q == b.q && held.v == b.v && held.omega == b.omega);
  // A sphere turns steadily: carrying on must meet what the step of a free one gives.
  ObjectParameters ball;
  ball.shape = Shape::kSphere;
  ball.radius = 0.03;
  const SpaceBodyParameters p = space_body_parameters(ball, 0.0);
  SpaceBody later = b;
  for (int k = 0; k < 50; ++k) later = step(p, Integrator::kZeroOrderHold, kTick, later, {});
  const SpaceBody carried = SpaceWorld::advance(b, {50 * kTick, 0.5});
  EXPECT_LT(length(carried.p - later.p), 1e-15);
  EXPECT_LT(length(rotation_between(carried.q, later.q)), 1e-14);
  EXPECT_LT(length(carried.v - b.v * 0.5) + length(carried.omega - b.omega * 0.5), 1e-16);
}

TEST(SpaceSession, APoseIsMovedBackByAPartOfADifference) {
  SpaceBody a, b;
  a.p = {0.1, 0.2, 0.3};
  a.q = rotation_by({0.4, 0.1, -0.9});
  b.p = {-0.1, 0.0, 0.5};
  const Vec3 r{0.9, -0.2, 1.1};
  b.q = rotation_by(r) * a.q;
  const SpaceBody offset = SpaceWorld::difference(b, a);
  for (const double part : {0.0, 0.25, 1.0}) {
    const SpaceBody back = SpaceWorld::moved_back(b, offset, part);
    EXPECT_LT(length(back.p - (b.p + (a.p - b.p) * part)), 1e-15);
    EXPECT_LT(length(rotation_between(a.q, back.q) - r * (1 - part)), 3e-15);
  }
  const SpaceBody still = SpaceWorld::moved_back(b, SpaceBody{}, 1.0);  // never seated
  EXPECT_TRUE(still.p == b.p && still.q == b.q);
}

TEST(SpaceSession, WorkIsForceTimesWayAndTorqueTimesTurn) {
  SpaceBody a, b;
  a.q = rotation_by({0.4, 0.1, -0.9});
  b.p = {0.1, 0.2, -0.3};
  b.q = rotation_by({0.0, 0.0, 0.7}) * a.q;
  EXPECT_NEAR(SpaceWorld::work({{1.0, 2.0, 3.0}, {5.0, 6.0, 2.0}}, a, b),
              0.1 + 0.4 - 0.9 + 2.0 * 0.7, 1e-15);
}

/// Two users, two fingers each, on one box; built here so that the test needs no file.
Scene two_users(Architecture architecture, bool attached) {
  Scene s;
  s.space = Space::kSpace;
  s.architecture = architecture;
  s.contact.attached = attached;
  s.contact.friction = {0.6, 0.6, 0.005};
  s.weight = !attached;
  s.objects = {box_object()};
  s.objects[0].position = {0.0, 0.0, 0.025};
  if (!attached) {
    WallParameters ground;
    ground.name = "ground";
    ground.normal = {0.0, 0.0, 1.0};
    ground.gain = {4000.0, 30.0};
    ground.tangential = {7000.0, 50.0};
    ground.friction = {0.6, 0.6, 0.005};
    s.walls = {ground};
  }
  for (const char* const name : {"1", "2"}) {
    UserParameters user;
    user.name = name;
    user.mass = 0.07;
    user.local = user.name == "1";
    for (const double side : {-1.0, 1.0}) {
      FingerParameters finger;
      finger.name = side < 0 ? "a" : "b";
      finger.radius = 0.008;
      finger.position = {side * (attached ? 0.03 : 0.039), user.local ? 0.015 : -0.015, 0.025};
      finger.hand = {300.0, 5.0};
      if (!attached)
        finger.intent.path = {{0.0, Vec3{0.0}},
                              {0.5, {-side * 0.03, 0.0, 0.0}},
                              {1.0, {-side * 0.03, 0.0, 0.05}},
                              {4.0, {-side * 0.03, 0.0, 0.05}}};
      user.fingers.push_back(finger);
    }
    s.users.push_back(user);
  }
  // Held over a packet: copies of half the inertia, 1.8e-4 kg m^2, stand a softer one only.
  const bool split = architecture == Architecture::kDistributedSplit;
  const Gain rotation = split ? Gain{1.0, 0.01} : Gain{10.0, 0.1};
  const auto couple = [&](const std::string& user, const std::string& copy) {
    CouplerParameters c;
    c.name = "k" + copy + user;
    c.object = "box";
    c.user = user;
    c.copy = copy;
    c.gain = {800.0, 3.0};
    c.tangential = {1200.0, 10.0};
    if (user.empty()) c.gain = {400.0, 8.0}, c.rotation = rotation;
    s.couplers.push_back(c);
  };
  if (architecture == Architecture::kCentral) {
    couple("1", ""), couple("2", "");
    s.couplers[1].gain = {400.0, 2.0};  // across the network less is stable
    s.couplers[1].tangential = {400.0, 3.0};
  } else {
    for (const char* const copy : {"1", "2"}) {
      couple("", copy);
      for (const char* const user : {"1", "2"})
        if (architecture == Architecture::kDistributed || std::string(user) == copy)
          couple(user, copy);
    }
  }
  return s;
}

/// Runs until the box hangs still; `height` of its centre and `tilt` in closed form.
template <typename Loop>
void expect_lifted(Loop& loop, double height, double tilt, double tolerance) {
  for (int i = 0; i < 3 * 128; ++i) loop.advance_packet_period();
  for (int u = 0; u < 2; ++u) {
    const SpaceBody& box = loop.object(u, 0);
    EXPECT_NEAR(box.p.z, height, tolerance);
    EXPECT_NEAR(length(rotation_vector(box.q)), tilt, tolerance / 0.03);
    EXPECT_NEAR(glm::dot(box.q, box.q), 1.0, 1e-15);
    EXPECT_LT(length(box.v), 1e-4);
  }
  EXPECT_LT(length(loop.object(0, 0).p - loop.object(1, 0).p), 1e-5);
}

TEST(SpaceSession, TwoUsersLiftABoxInEveryArchitecture) {
  // It had settled into the ground by its weight on four corners; hands then pull up by 50 mm, and
  // four times a hand's spring and a contact's in series carry the weight.
  const double weight = 0.7 * 9.81, settled = weight / 16000;
  const double height = 0.075 - weight / 4 * (1.0 / 300 + 1.0 / 1200);
  distributed::DistributedLoop<SpaceWorld> whole(two_users(Architecture::kDistributed, false));
  expect_lifted(whole, height - settled, 0.0, 1e-5);

  // A copy of half the mass hangs from its user's two fingers, 15 mm beside its centre; only the
  // coupler to the other copy, which leans the other way, holds it upright: K 2 phi = W/2 15 mm.
  const double phi = weight / 2 * 0.015 / 2.0;
  distributed::DistributedLoop<SpaceWorld> split(two_users(Architecture::kDistributedSplit, false));
  expect_lifted(split, height - settled / 2 - 0.015 * phi, phi, 1e-5);

  // The user across the network holds more softly: springs in series of 300 + 1200 and 300 + 400
  // N/m, twice each, 30 mm apart.
  const double firm = weight / 4 * (1.0 / 300 + 1.0 / 1200),
               soft = weight / 4 * (1.0 / 300 + 1.0 / 400);
  central::CentralLoop<SpaceWorld> central(two_users(Architecture::kCentral, false));
  expect_lifted(central, 0.075 - settled - (firm + soft) / 2, (soft - firm) / 0.03, 1e-4);
}

TEST(SpaceSession, AnAttachedGraspIsAtRestUntilItIsMovedAndIsStableWithOnePacketOfDelay) {
  NetworkModel network;
  for (auto& row : network.link)
    for (auto& link : row) link.delay_ticks = 4;
  distributed::DistributedLoop<SpaceWorld> loop(two_users(Architecture::kDistributed, true),
                                                network);
  for (int i = 0; i < 128; ++i) loop.advance_packet_period();
  EXPECT_LT(length(loop.object(0, 0).p - Vec3{0.0, 0.0, 0.025}), 1e-15);
  for (int f = 0; f < 2; ++f) loop.hands().finger(0, f).set_external_force({0.3, -0.2, 0.5});
  for (int i = 0; i < 5 * 128; ++i) loop.advance_packet_period();
  // Four springs of 300 N/m hold it all at last.
  EXPECT_LT(
      length((loop.object(0, 0).p - Vec3{0.0, 0.0, 0.025}) - Vec3{0.6, -0.4, 1.0} * (1.0 / 1200)),
      2e-5);
  EXPECT_LT(length(loop.object(0, 0).v), 1e-5);
}

TEST(SpaceSession, AStateCrossesAPacketUnchangedAndFits) {
  Random random(21);
  SiteState<SpaceWorld> state{}, back{};
  for (auto& f : state.fingers) f = {random_vector(random), random_vector(random)};
  for (auto& o : state.objects)
    o = {random_vector(random), rotation_by(random_vector(random)), random_vector(random),
         random_vector(random)};
  StatePacket packet;
  pack(state, {kMaxFingers, kMaxObjects}, packet);
  EXPECT_EQ(packet.value_count, 4 * 6 + 4 * 13);  // 76 of 128
  unpack(packet, {kMaxFingers, kMaxObjects}, back);
  EXPECT_TRUE(back.objects[3].q == state.objects[3].q &&
              back.objects[3].omega == state.objects[3].omega &&
              back.objects[0].p == state.objects[0].p && back.fingers[2].v == state.fingers[2].v);
}

TEST(SpaceSession, ContactBitsTellStateAndAxisOfTheFace) {
  const PlacedSpaceBody body(SpaceBody{});
  const SpaceShape box{{0.05, 0.04, 0.03}, 0.0, 0.0, false}, ball{Vec3{0.0}, 0.03, 0.0, true};
  FingerSpaceContact contact;
  EXPECT_EQ(SpaceWorld::contact_bits(contact), 0u);
  (void)touch(contact, finger_gains(), box, body, {{0.0, 0.0, -0.029}, Vec3{0.0}}, kTick);
  EXPECT_EQ(contact_state(SpaceWorld::contact_bits(contact), 0), ContactState::kPreSlide);
  EXPECT_EQ(contact_side(SpaceWorld::contact_bits(contact), 0), 2);
  release(contact);
  (void)touch(contact, finger_gains(), ball, body, {{0.0, 0.0, -0.029}, Vec3{0.0}}, kTick);
  EXPECT_EQ(contact_side(SpaceWorld::contact_bits(contact), 0), 3);
}

}  // namespace
}  // namespace tandem::core
