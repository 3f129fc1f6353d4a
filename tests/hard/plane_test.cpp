#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "analysis/with_loop.h"
#include "core/plane_contact.h"
#include "core/random.h"
#include "core/sequence_gate.h"
#include "scene/load_scene.h"
#include "tests/hard/grasp.h"
#include "tests/hard/hard.h"

// Corners, cones, collisions, great coordinates, rough networks: contacts of the plane.
namespace tandem::hard {
namespace {

using namespace core;
using Central = central::CentralLoop<PlaneWorld>;
using Distributed = distributed::DistributedLoop<PlaneWorld>;

constexpr double kT = 1.0 / 1024.0;
constexpr double kPi = 3.14159265358979323846;

ContactGains gains_of(double stiffness, double damping, double mu_s, double mu_k) {
  ContactGains gains;
  gains.normal = {stiffness, damping};
  gains.tangential = {1200.0, 10.0};
  gains.friction = {mu_s, mu_k, 0.005};
  return gains;
}

PlaneBodyParameters body_of(double mass, double a, double b) {
  ObjectParameters object;
  object.mass = mass;
  object.size = {a, b, 0.0};
  return plane_body_parameters(object, 9.81);
}

double kinetic(const PlaneBodyParameters& p, const PlaneBody& b) {
  return 0.5 * inner(b.v, b.v) / p.inverse_mass + 0.5 * b.omega * b.omega / p.inverse_inertia;
}

/// A finger on a muscle: what a hand of `mass` does under contact force and a constant push.
void move(PlanePoint& finger, const Vec2& force, double mass, double damping) {
  finger.v += (force - finger.v * damping) * (kT / mass);
  finger.p += finger.v * kT;
}

TEST(HardPlane, ABoxWedgedInACornerByTwoFingersRestsAtTheDepthsOfTheBalance) {
  // Frictionless: floor and wall share 5 N over two corners each, 5 / (2 4000) m deep; fingers
  // stand 5 / 800 m deep in the middle of their faces.
  const PlaneBox box{{0.03, 0.03}, 0.0};
  const PlaneBodyParameters p = body_of(0.7, 0.06, 0.06);
  const std::array<PlaneWall, 2> walls{PlaneWall{{0.0, 0.0}, {0.0, 1.0}, gains_of(4000, 30, 0, 0)},
                                       PlaneWall{{0.0, 0.0}, {1.0, 0.0}, gains_of(4000, 30, 0, 0)}};
  for (const auto& [mu, integrator] :
       {std::pair{0.0, Integrator::kSemiImplicitEuler}, std::pair{0.0, Integrator::kZeroOrderHold},
        std::pair{0.6, Integrator::kSemiImplicitEuler},
        std::pair{0.6, Integrator::kZeroOrderHold}}) {
    const bool within = takes_mean_contact(integrator);
    std::array<WallContacts, 2> held{};
    std::array<FingerBoxContact, 2> touched{};
    std::array<PlaneWall, 2> rough = walls;
    for (auto& wall : rough) wall.gains = gains_of(4000, 30, mu, mu);
    PlaneBody body{{0.031, 0.032}, 0.05, {0.0, 0.0}, 0.0};
    std::array<PlanePoint, 2> finger{PlanePoint{{0.07, 0.03}, {}}, PlanePoint{{0.03, 0.07}, {}}};
    // 5 N towards the corner; across, the hand keeps its finger in the middle by 300 N/m.
    const auto push = [&](int i) {
      return i == 0 ? Vec2{-5.0, -300.0 * (finger[0].p.y - 0.03)}
                    : Vec2{-300.0 * (finger[1].p.x - 0.03), -5.0};
    };
    PlaneBody late;
    const int ticks = 40 * 1024;
    for (int k = 0; k < ticks; ++k) {
      if (k == ticks / 2) late = body;
      const PlacedBody placed(body);
      PlaneWrench w;
      for (int i = 0; i < 2; ++i) w += hold_back(held[i], rough[i], box, placed, kT, within);
      for (int i = 0; i < 2; ++i) {
        const auto f = touch(touched[i], gains_of(800, 3, mu, mu), box, placed, finger[i], kT);
        w += f.on_body;
        move(finger[i], push(i) + f.on_finger_W, 0.07, 2.0);
      }
      body = step(p, integrator, kT, body, w);
      ASSERT_TRUE(std::isfinite(body.p.x + body.p.y + body.angle));
    }
    // At rest for good, also with friction, where what rests where depends on how it came there.
    EXPECT_NEAR(body.p.x, late.p.x, 1e-12) << mu;
    EXPECT_NEAR(body.p.y, late.p.y, 1e-12) << mu;
    EXPECT_LT(kinetic(p, body), 1e-20) << mu;
    if (mu == 0.0) {
      EXPECT_NEAR(body.p.x, 0.03 - 5.0 / 8000, 1e-12);
      EXPECT_NEAR(body.p.y, 0.03 - 5.0 / 8000, 1e-12);
      EXPECT_NEAR(body.angle, 0.0, 1e-12);
      EXPECT_NEAR(finger[0].p.x - body.p.x, 0.03 - 5.0 / 800, 1e-12);
    } else {
      expect_same_bits(within ? "plane_wedged_held" : "plane_wedged",
                       {body.p.x, body.p.y, body.angle});
    }
  }
}

/// Throws one free finger at a free box and runs until they have parted.
struct Collision {
  PlaneBodyParameters p;
  PlaneBox box;
  PlaneBody body{};
  PlanePoint finger{};
  FingerBoxContact contact{};
  ContactGains gains{};
  double largest_force = 0.0;
  bool touched = false;
  static constexpr double kMass = 0.1;

  void run(int ticks) {
    for (int k = 0; k < ticks; ++k) {
      const auto f = touch(contact, gains, box, PlacedBody(body), finger, kT);
      touched |= contact.memory.state != ContactState::kFree;
      largest_force = std::fmax(largest_force, std::sqrt(inner(f.on_finger_W, f.on_finger_W)));
      move(finger, f.on_finger_W, kMass, 0.0);
      body = step(p, Integrator::kSemiImplicitEuler, kT, body, f.on_body);
    }
  }
  [[nodiscard]] double energy() const {
    return kinetic(p, body) + 0.5 * kMass * inner(finger.v, finger.v);
  }
  [[nodiscard]] Vec3 momentum() const {
    return {body.v.x / p.inverse_mass + kMass * finger.v.x,
            body.v.y / p.inverse_mass + kMass * finger.v.y,
            cross(body.p, body.v) / p.inverse_mass + body.omega / p.inverse_inertia +
                kMass * cross(finger.p, finger.v)};
  }
};

TEST(HardPlane, AFingerOnAVertexIsEitherHeldOrPassesAndNeverGainsEnergy) {
  // Along the diagonal, as exactly at the vertex as doubles can say, and a little beside it.
  int held = 0;
  for (int i = -500; i <= 500; ++i) {
    const double offset = i == 0 ? 0.0 : std::copysign(std::pow(10.0, -18 + 0.03 * std::abs(i)), i);
    for (const double radius : {0.0, 0.005}) {
      Collision c{.p = body_of(0.7, 0.06, 0.06), .box = {{0.03, 0.03}, radius}};
      c.gains = gains_of(800, 3, 0.6, 0.5);
      c.finger = {{0.045 + offset, 0.045 - offset}, {-0.5, -0.5}};
      const double before = c.energy();
      const Vec3 m = c.momentum();
      c.run(400);
      held += c.touched;
      ASSERT_LE(c.energy(), before * (1 + 1e-9)) << offset << ' ' << radius;
      ASSERT_NEAR(c.momentum().x, m.x, 1e-12);
      ASSERT_NEAR(c.momentum().y, m.y, 1e-12);
      ASSERT_NEAR(c.momentum().z, m.z, 1e-12);
      ASSERT_LT(c.largest_force, 10.0);  // sqrt(k m) v of the whole momentum: 6.3 N, and damping
    }
  }
  EXPECT_GT(held, 500);
}

TEST(HardPlane, AFingerPushedOffTheEndOfAnEdgeLeavesItsForceThere) {
  // Slides along the top face under 4 N towards its end and beyond: there nothing is left.
  const PlaneBox box{{0.03, 0.03}, 0.0};
  const PlacedBody placed(PlaneBody{});
  const ContactGains gains = gains_of(800, 3, 0.6, 0.5);
  FingerBoxContact contact;
  double work = 0.0;
  Vec2 last{0.0};
  for (int k = 0; k <= 600; ++k) {
    const double x = 0.02 + 2e-5 * k, y = 0.03 - (k > 0 ? 0.005 : -0.001);
    const auto f = touch(contact, gains, box, placed, {{x, y}, {2e-5 / kT, 0.0}}, kT);
    if (k > 1) work += 0.5 * (f.on_finger_W.x + last.x) * 2e-5;
    last = f.on_finger_W;
    if (x > 0.03) {
      ASSERT_EQ(f.on_finger_W.x, 0.0);
      ASSERT_EQ(f.on_finger_W.y, 0.0);
      ASSERT_EQ(contact.memory.state, ContactState::kFree);
    }
  }
  EXPECT_LT(work, 0.0);  // friction took, and gave nothing back at the end
  EXPECT_GT(work, -0.5 * 4.0 * 0.0101);
}

TEST(HardPlane, AThinBoxStopsAFingerAtTwoMetresASecondFromAnyDirection) {
  // 1 mm thin; a tick moves the finger by 2 mm. It never gets to the other side.
  Random random(5);
  for (std::int64_t trial = 0; trial < length(20000); ++trial) {
    const double angle = random.uniform(-0.4, 0.4) * kPi;
    Collision c{.p = body_of(0.7, 0.001, 0.08), .box = {{0.0005, 0.04}, 0.0}};
    c.gains = gains_of(4000, 5, 0.3, 0.3);
    const Vec2 way{std::cos(angle), std::sin(angle)};
    const double aim = random.uniform(-0.035, 0.035);
    c.finger = {Vec2{0.0, aim} - way * random.uniform(0.02, 0.024), way * 2.0};
    const double before = c.energy();
    // Watched in the frame of the box until they part; its spin may hand it round the end later.
    bool passed = false;
    for (int k = 0; k < 60; ++k) {
      c.run(1);
      const Vec2 at = PlacedBody(c.body).to_body(c.finger.p - c.body.p);
      if (c.touched && c.contact.memory.state == ContactState::kFree) {
        passed = at.x > 0.0005 && std::fabs(at.y) < 0.039;
        break;
      }
    }
    ASSERT_TRUE(c.touched) << trial;
    ASSERT_FALSE(passed) << trial;
    ASSERT_LE(c.energy(), before * (1 + 1e-9)) << trial;
  }
}

TEST(HardPlane, AtTheEdgeOfTheConeItHoldsBelowSlidesAboveAndLetsGoWithoutAKick) {
  const ContactGains gains = gains_of(1000, 30, 0.6, 0.5);
  const double depth = 0.002, normal = 2.0, breakaway = 0.6 * normal / 1200.0;
  for (const bool above : {false, true}) {
    ContactMemory<double> memory;
    auto f = press(memory, gains, SurfaceMotion<double>{depth, 0.0, 0.0, 0.0}, kT);
    const double stretch = breakaway * (above ? 1 + 1e-9 : 1 - 1e-9);
    for (std::int64_t k = 0; k < length(1000000); ++k)
      f = press(memory, gains, SurfaceMotion<double>{depth, 0.0, stretch, 0.0}, kT);
    if (above) {  // slipped along its own stretch to the dynamic cone, once
      EXPECT_NEAR(f.tangential, -0.5 * normal, 1e-12);
    } else {
      EXPECT_EQ(memory.anchor, 0.0);
      EXPECT_NEAR(f.tangential, -0.6 * normal, 1e-8);
    }
    // Release within 50 ms, so fast that the damper alone would pull: never out of the cone, never
    // pulls, nothing at the end.
    for (int k = 50; k >= 0; --k) {
      const double left = depth * k / 50.0;
      f = press(memory, gains, SurfaceMotion<double>{left, depth * 20, stretch, 0.0}, kT);
      ASSERT_LE(std::fabs(f.tangential), 0.6 * f.normal * (1 + 1e-12));
      ASSERT_GE(f.normal, 0.0);
    }
    EXPECT_EQ(f.tangential, 0.0);
    EXPECT_EQ(memory.state, ContactState::kFree);
  }
}

TEST(HardPlane, AMillionCyclesBelowBreakawayDriftLessThanAMicrometre) {
  // 0.1 kg held by friction alone under 2 N, shaken along the surface at 64 Hz with nine tenths of
  // the cone about a steady pull of 5 %, while the normal force breathes by 3 %.
  const ContactGains gains = gains_of(1000, 0, 0.6, 0.5);
  ContactMemory<double> memory;
  double x = 0.0, v = 0.0, sum = 0.0, first = 0.0;
  constexpr std::int64_t kCycles = 1000000;
  for (std::int64_t cycle = 0; cycle < length(kCycles); ++cycle) {
    sum = 0.0;
    for (int i = 0; i < 16; ++i) {
      static constexpr double kSine[16] = {
          0.0,  0.3826834323650898,  0.7071067811865476,  0.9238795325112867,
          1.0,  0.9238795325112867,  0.7071067811865476,  0.3826834323650898,
          0.0,  -0.3826834323650898, -0.7071067811865476, -0.9238795325112867,
          -1.0, -0.9238795325112867, -0.7071067811865476, -0.3826834323650898};
      const double depth = 0.002 * (1 + 0.03 * kSine[(3 * i) % 16]);
      const auto f = press(memory, gains, SurfaceMotion<double>{depth, 0.0, x, v}, kT);
      // Quasi-static shaking: far below the 17 Hz of 0.1 kg on 1200 N/m it would resonate.
      const double shake = 1.2 * (0.05 + 0.35 * kSine[i]);
      advance(Integrator::kSemiImplicitEuler, kT, 0.0, x, v, (f.tangential + shake) / 0.1);
      sum += x;
    }
    if (cycle == 999) first = sum / 16;
    if (cycle + 1 == checkpoint(kCycles)) expect_same_bits("plane_vibration", {x, v});
  }
  EXPECT_EQ(memory.state, ContactState::kPreSlide);
  EXPECT_NEAR(sum / 16, first, 1e-6);
  EXPECT_NEAR(sum / 16, 1.2 * 0.05 / 1200.0, 1e-6);  // the steady pull on the spring
}

TEST(HardPlane, FrictionNeverDoesPositiveWorkRoundAClosedPath) {
  // Random closed paths along the surface at constant depth, from rest, through stick and slide,
  // and back to the start with the same stretch or less.
  Random random(11);
  const ContactGains gains = gains_of(1000, 0, 0.6, 0.5);
  for (std::int64_t trial = 0; trial < length(4000); ++trial) {
    const double a = random.uniform(1e-5, 8e-3), b = random.uniform(1e-5, 8e-3);
    const double phase = random.uniform(0.0, 2 * kPi);
    const int steps = 400 + static_cast<int>(random.uniform(0.0, 4000.0));
    const auto at = [&](int k) {
      const double s = 2 * kPi * k / steps;
      return a * (std::sin(s + phase) - std::sin(phase)) +
             b * (std::sin(3 * s + 2 * phase) - std::sin(2 * phase));
    };
    ContactMemory<double> memory;
    double work = 0.0, x = 0.0;
    auto f = press(memory, gains, SurfaceMotion<double>{0.002, 0.0, 0.0, 0.0}, kT);
    for (int k = 1; k <= steps; ++k) {
      const double next = at(k);
      const auto g =
          press(memory, gains, SurfaceMotion<double>{0.002, 0.0, next, (next - x) / kT}, kT);
      work += 0.5 * (f.tangential + g.tangential) * (next - x);
      f = g;
      x = next;
    }
    // It ends where it began; a spring that is left stretched holds energy and was paid for.
    ASSERT_LE(work, 1e-12) << trial;
  }
}

/// A random closed path of one number, from 0 to 0, as smooth as its third harmonic.
struct ClosedPath {
  double a = 0.0, b = 0.0, c = 0.0, d = 0.0;
  ClosedPath(Random& random, double most)
      : a(random.uniform(-most, most)),
        b(random.uniform(-most, most)),
        c(random.uniform(0.0, 2 * kPi)),
        d(random.uniform(0.0, 2 * kPi)) {}
  [[nodiscard]] double at(double turn) const {
    return a * (std::sin(turn + c) - std::sin(c)) + b * (std::sin(3 * turn + d) - std::sin(d));
  }
};

TEST(HardPlane, FrictionNeverDoesPositiveWorkWhileThePressureBreathesAndTheContactIsLeft) {
  // Closed paths again, from micrometres to millimetres, fast and below v_tr, while the surface is
  // pressed by other closed paths, and left and touched again. All energy the contact can hold is
  // the spring's, zero at first touch, so it can give nothing on the whole.
  Random random(13);
  const ContactGains gains = gains_of(1000, 0, 0.6, 0.5);
  std::int64_t lifted = 0;
  for (std::int64_t trial = 0; trial < length(3000); ++trial) {
    const ClosedPath along(random, std::pow(10.0, random.uniform(-5.0, -2.2)));
    const ClosedPath press_by(random, random.uniform(0.0, 0.003));
    const int steps = 400 + static_cast<int>(random.uniform(0.0, 6000.0));
    ContactMemory<double> memory;
    double work = 0.0, x = 0.0, most = 0.0;
    SurfaceForce<double> f;
    bool left = false;
    for (int k = 0; k <= steps; ++k) {
      const double turn = 2 * kPi * k / steps, next = along.at(turn);
      const double depth = 0.002 + press_by.at(turn), way = next - x;
      const auto g = press(memory, gains, SurfaceMotion<double>{depth, 0.0, next, way / kT}, kT);
      left |= depth <= 0.0;
      work += 0.5 * (f.tangential + g.tangential) * way;
      // A contact that ends within a tick gives by this rule its last force for half a tick more.
      if (depth <= 0.0) most += 0.5 * std::fabs(f.tangential * way);
      ASSERT_LE(work, most + 1e-12) << trial << ' ' << k;  // on the way, too: nothing was held
      f = g;
      x = next;
    }
    lifted += left;
  }
  EXPECT_GT(lifted, length(3000) / 10);
}

TEST(HardPlane, AContactNeverDoesPositiveWorkWhileBoxAndFingerGoRoundClosedPathsTogether) {
  // The box goes and turns, the finger stays on its face but for a little of its own: pushes,
  // slides. What both are given together round the path comes from the normal spring, which ends
  // as it began, and from friction, which takes.
  Random random(17);
  const PlaneBox box{{0.03, 0.03}, 0.0};
  const ContactGains gains = gains_of(1000, 0, 0.6, 0.5);
  for (std::int64_t trial = 0; trial < length(500); ++trial) {
    const ClosedPath px(random, 0.03), py(random, 0.03), turned(random, 0.5);
    const double slip = std::pow(10.0, random.uniform(-5.0, -2.5));
    const ClosedPath along(random, slip), deeper(random, 0.0004);
    const int steps = 4000;
    FingerBoxContact contact;
    PlaneBody body{{0.0, 0.0}, 0.0, {0.0, 0.0}, 0.0};
    PlanePoint finger{{0.028, 0.0}, {0.0, 0.0}};
    auto f = touch(contact, gains, box, body, finger, kT);
    double work = 0.0;
    for (int k = 1; k <= steps; ++k) {
      const double turn = 2 * kPi * k / steps;
      PlaneBody next{{px.at(turn), py.at(turn)}, turned.at(turn), {0.0, 0.0}, 0.0};
      const Vec2 on_face{0.028 - deeper.at(turn), along.at(turn)};
      PlanePoint moved{next.p + PlacedBody(next).to_world(on_face), {0.0, 0.0}};
      next.v = (next.p - body.p) * (1.0 / kT);
      next.omega = (next.angle - body.angle) * (1.0 / kT);
      moved.v = (moved.p - finger.p) * (1.0 / kT);
      const auto g = touch(contact, gains, box, next, moved, kT);
      work += 0.5 * (inner(f.on_finger_W + g.on_finger_W, moved.p - finger.p) +
                     inner(f.on_body.force + g.on_body.force, next.p - body.p) +
                     (f.on_body.torque + g.on_body.torque) * (next.angle - body.angle));
      f = g;
      body = next;
      finger = moved;
    }
    // 2 N along 0.3 m, by chords of an arc of at most 2e-3 rad a tick: 0.6 J (2e-3)^2 / 12.
    ASSERT_LE(work, 2e-7) << trial;
  }
}

TEST(HardPlane, RandomSimultaneousContactsOfFingersAndWallsGainNoKineticEnergy) {
  Random random(29);
  const PlaneBodyParameters p = body_of(0.7, 0.1, 0.08);
  const PlaneBox box{{0.05, 0.04}, 0.0};
  std::int64_t several = 0;
  for (std::int64_t trial = 0; trial < length(100000); ++trial) {
    const double mu = random.uniform(0.0, 0.8);
    const bool mean = trial % 2 == 0;  // as scenes do by default, and with forces of tick's starts
    const Integrator integrator =
        mean ? Integrator::kZeroOrderHold : Integrator::kSemiImplicitEuler;
    const std::array<PlaneWall, 2> walls{
        PlaneWall{{0.0, 0.0}, {0.0, 1.0}, gains_of(4000, 30, mu, 0.8 * mu)},
        PlaneWall{{0.0, 0.0}, {1.0, 0.0}, gains_of(4000, 30, mu, 0.8 * mu)}};
    const ContactGains soft = gains_of(800, 3, mu, 0.8 * mu);
    std::array<WallContacts, 2> held{};
    std::array<FingerBoxContact, 2> touched{};
    PlaneBody body{{0.066, 0.066},
                   random.uniform(0.0, 2 * kPi),
                   {-random.uniform(0.0, 1.0), -random.uniform(0.0, 1.0)},
                   random.uniform(-8.0, 8.0)};
    std::array<PlanePoint, 2> finger;
    for (auto& f : finger) {
      const SinCos s = sin_cos(random.uniform(-0.25, 0.75) * kPi);
      f.p = body.p + Vec2{s.cos, s.sin} * random.uniform(0.07, 0.09);
      f.v = (body.p - f.p) * random.uniform(2.0, 20.0);
    }
    const auto energy = [&] {
      return kinetic(p, body) +
             0.05 * (inner(finger[0].v, finger[0].v) + inner(finger[1].v, finger[1].v));
    };
    const double before = energy();
    int most = 0;
    bool any = false;
    for (int k = 0; k < 100; ++k) {
      const PlacedBody placed(body);
      PlaneWrench w;
      for (int i = 0; i < 2; ++i) w += hold_back(held[i], walls[i], box, placed, kT, mean);
      int now = held[0].any + held[1].any;
      for (int i = 0; i < 2; ++i) {
        const auto f = touch(touched[i], soft, box, placed, finger[i], kT);
        now += touched[i].memory.state != ContactState::kFree;
        w += f.on_body;
        move(finger[i], f.on_finger_W, 0.1, 0.0);
      }
      body = step(p, integrator, kT, body, w);
      most = std::max(most, now);
      if (any && now == 0) {
        ASSERT_LE(energy(), before * (1 + 1e-9)) << trial;
      }
      any |= now > 0;
    }
    several += most > 1;
  }
  EXPECT_GT(several, length(100000) / 10);
}

TEST(HardPlane, ATwoFingerGraspWithRealContactsAtItsLimitStaysAtRestForTenMillionTicks) {
  Scene scene = held_grasp();
  set_stiffness(scene, {"k"}, 0.98 * kGraspLimit);

  Central loop(scene);
  constexpr std::int64_t kAll = 10000000;
  PlaneBody early{};
  for (std::int64_t i = 1; i <= length(kAll); ++i) {
    loop.tick();
    if (i == checkpoint(kAll)) {
      early = loop.object(0, 0);
      expect_same_bits("plane_grasp_at_0.98", {early.p.x, early.p.y, early.angle});
    }
  }
  const PlaneBody& late = loop.object(0, 0);
  EXPECT_NEAR(late.p.x, early.p.x, 1e-9);
  EXPECT_NEAR(late.p.y, early.p.y, 1e-9);
  EXPECT_NEAR(late.angle, early.angle, 1e-9);
  EXPECT_LT(inner(late.v, late.v), 1e-20);
  const auto& finger = loop.hands().finger(0, 0);
  EXPECT_LT(inner(finger.velocity(), finger.velocity()), 1e-16);
}

TEST(HardPlane, TenMetresFromTheOriginASessionFeelsTheSameToAMicrometre) {
  // Encoders of 1 um; the same carry at the origin and 10 m away in both directions.
  const auto at = [](const Vec3& shift) {
    Scene scene = scene::load_scene("box_distributed", std::vector<std::string>{});
    for (auto& device : scene.devices) device.encoder_step = 1e-6;
    for (auto& object : scene.objects) object.position += shift;
    for (auto& wall : scene.walls) wall.point += shift;
    for (auto& user : scene.users)
      for (auto& finger : user.fingers) finger.position += shift;
    return Distributed(scene);
  };
  const Vec3 shift{10.0, -10.0, 0.0};
  Distributed near = at(Vec3{0.0}), far = at(shift);
  double worst = 0.0;
  // Up to the push against the wall: the whole carry, touch, stick and slide included.
  for (int k = 0; k < 9 * 1024; ++k) {
    near.tick();
    far.tick();
    for (int u = 0; u < 2; ++u) {
      const Vec2 d = far.object(u, 0).p - Vec2{shift.x, shift.y} - near.object(u, 0).p;
      worst = std::fmax(worst, std::sqrt(inner(d, d)));
    }
  }
  EXPECT_LT(worst, 1e-6);
}

TEST(HardPlane, ReorderingAndBurstsAtTheMarginNeverLeaveTheDevicesLimitsAndPass) {
  // Coordination at 0.98 of its limit for a round trip of one packet, then 60 s of jitter that
  // reorders and bursts of loss, then calm: finite and limited forces, and the copies meet again.
  Scene scene = scene::load_scene("box_distributed", std::vector<std::string>{});
  set_stiffness(scene, {"ko1", "ko2"}, 0.98 * kCoordinationLimit);
  // The hands hold the box from 2 s to the end.
  for (auto& user : scene.users)
    for (auto& finger : user.fingers) finger.intent.path.resize(3);

  LinkModelParameters rough;
  rough.delay_ticks = 4.0;
  rough.jitter = JitterKind::kUniform;
  rough.jitter_ticks = 12.0;
  rough.burst_enter = 0.02;
  rough.burst_leave = 0.25;
  rough.duplicate = 0.02;
  NetworkModel network;
  network.set_all(rough);
  Distributed loop(scene, network);
  // Never less than touch and squeeze.
  const std::int64_t ticks = std::max(length(60 * 1024), std::int64_t{3 * 1024});
  for (std::int64_t k = 1; k <= ticks; ++k) {
    loop.tick();
    if (k == 3 * 1024)
      expect_same_bits("plane_rough",
                       {loop.object(0, 0).p.x, loop.hands().finger(1, 0).position().x});
    for (int u = 0; u < 2; ++u)
      for (int f = 0; f < 2; ++f) {
        const Vec2 force = loop.output(u).forces[f];
        ASSERT_TRUE(std::isfinite(force.x) && std::isfinite(force.y));
        ASSERT_LE(inner(force, force), 100.0 * (1 + 1e-12));
      }
  }
  EXPECT_LT(loop.packets_accepted(), loop.packets_sent());
}

TEST(HardPlane, SequenceNumbersGoOnPastThirtyTwoBits) {
  // A day at 1024 Hz is 8.8e7 packets; the counter has 64 bits and passes 2^32 like any number.
  SequenceGate gate;
  std::uint64_t sequence = 1;
  while (sequence < (1ull << 32) - 1000) {
    ASSERT_EQ(gate.admit(sequence), Gate::kAccept);
    sequence += SequenceGate::kMaxLeap - 1;
  }
  for (sequence = (1ull << 32) - 900; sequence < (1ull << 32) + 900; ++sequence)
    ASSERT_EQ(gate.admit(sequence), Gate::kAccept) << sequence;
  EXPECT_EQ(gate.admit((1ull << 32) - 1), Gate::kDuplicate);
}

}  // namespace
}  // namespace tandem::hard
