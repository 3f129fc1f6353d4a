// Planar scenes linearised at a grasp, against axis scenes of the same parameters and against the
// running loop.

#include <cmath>

#include <gtest/gtest.h>

#include "analysis/grasp_response.h"
#include "analysis/growth.h"
#include "analysis/resampled.h"
#include "analysis/response.h"
#include "analysis/stability.h"
#include "scene/load_scene.h"

namespace tandem::analysis {
namespace {

core::NetworkModel round_trip(const core::Scene& scene, double packets) {
  core::NetworkModel network;
  network.set_round_trip(packets, scene.ticks_per_packet());
  return network;
}

/// box_* at its grasp, fingers on the middle of the faces: then x, y and rotation do not feel each
/// other, and each is an axis scene of its own.
core::Scene centred(const char* name, const std::vector<std::string>& sets = {}) {
  core::Scene scene = linear_scene(scene::load_scene(name, sets)).scene;
  for (auto& user : scene.users)
    for (auto& finger : user.fingers) finger.position.y = 0.0;
  return scene;
}

/// The axis scene with the gains, masses and arms of one axis of a centred planar scene. Two
/// fingers move as one mass of two; in rotation at 30 mm as 2 m r^2, on the object's inertia.
core::Scene as_axis(const core::Scene& plane, const std::string& axis) {
  const double r = 0.03;
  core::Scene scene = plane;
  scene.space = core::Space::kAxis;
  for (auto& object : scene.objects) {
    object.position = core::Vec3(0.0);
    if (axis == "rotation") {
      object.mass *= (0.06 * 0.06 + 0.06 * 0.06) / 12.0;
      object.compensation = object.compensation_rotation;
    }
  }
  for (auto& user : scene.users) {
    user.fingers.resize(1);
    user.fingers[0].position = core::Vec3(0.0);
    user.mass *= axis == "rotation" ? 2.0 * r * r : 2.0;
  }
  for (auto& c : scene.couplers) {
    if (c.user.empty()) {
      if (axis == "rotation") c.gain = c.rotation;
      continue;
    }
    const core::Gain g = axis == "x" ? c.gain : c.tangential;
    const double times = axis == "rotation" ? 2.0 * r * r : 2.0;
    c.gain = {times * g.stiffness, times * g.damping};
  }
  return scene;
}

double nearest(const Judgement& among, const std::complex<double>& z) {
  double best = 1e300;
  for (const auto& x : among.eigenvalues) best = std::min(best, std::abs(x - z));
  return best;
}

// Every eigenvalue of the three axis scenes is one of the planar scene, drag and admittance are
// equal axis by axis; delays, both architectures, compensation, extrapolation.
TEST(Plane, AnAxisOfACentredGraspIsTheAxisSceneOfTheSameParameters) {
  const std::vector<std::string> none,
      compensation{"object.box.compensation=0.88", "object.box.compensation_rotation=0.002"};
  for (const char* name : {"box_distributed", "box_distributed_split", "box_central"})
    for (const auto& sets : {none, compensation})
      for (const bool extrapolate : {false, true})
        for (const double d : {0.0, 1.0, 1.5}) {
          core::Scene plane = centred(name, sets);
          if (extrapolate) plane.reconstruction.kind = core::ReconstructionKind::kExtrapolate;
          const LiftedSystem whole = resampled_system(plane, round_trip(plane, d));
          const Judgement judged = judge(whole);
          double largest = 0.0;
          const auto felt = felt_motion(whole, grasp_axes(whole, plane, 1, 0));
          const auto axes = grasp_axes(whole, plane, 1, 0);
          for (int a = 0; a < 3; ++a) {
            const core::Scene line = as_axis(plane, axes[a].name);
            const LiftedSystem one = resampled_system(line, round_trip(line, d));
            const Judgement alone = judge(one);
            largest = std::max(largest, alone.radius);
            for (const auto& z : alone.eigenvalues)
              if (std::abs(z) > 0.02) {
                EXPECT_LT(nearest(judged, z), 1e-9) << name << d << axes[a].name << z;
              }
            // Sizes from 1e-3 (rotation) to 10; both are direct solves.
            const FreeMotion m = free_motion(one, one.ports[1]);
            const double scale = std::max(std::abs(m.mean_damping), 1e-3);
            EXPECT_NEAR(felt.mean_damping(a, a), m.mean_damping, 1e-9 * scale);
            EXPECT_NEAR(felt.sampled_damping(a, a), m.sampled_damping, 1e-9 * scale);
            EXPECT_NEAR(felt.inertia(a, a) / m.inertia, 1.0, 1e-8);
            for (const double w : {1.0, 40.0, 300.0}) {
              const auto expected = admittance(one, one.ports[1], w);
              EXPECT_LT(std::abs(admittance(whole, axes[a], w) - expected),
                        1e-9 * std::abs(expected))
                  << name << d << axes[a].name << w;
            }
          }
          // The fingers of a hand may also move against each other: no axis scene has that.
          EXPECT_GE(judged.radius, largest - 1e-9) << name << d;
        }
}

// Table 8.2 and 8.1 as they are, fingers 12 mm off the middle: the resampled map against the map
// measured on the running loop by finite differences (1e-6 m: rounding leaves some 1e-8), and
// against its growth.
TEST(Plane, TheTablesOfChapter8AreJudgedAsTheRunningLoopGrows) {
  for (const char* name : {"box_distributed", "box_central", "box_central_table_8_1"})
    for (const double d : {0.0, 1.0, 2.0}) {
      const core::Scene scene = linear_scene(scene::load_scene(name)).scene;
      const core::NetworkModel network = round_trip(scene, d);
      const Judgement fast = judge(resampled_system(scene, network));
      const Judgement loop = judge(measured_system(scene, network));
      EXPECT_NEAR(fast.radius, loop.radius, 1e-7) << name << d;
      EXPECT_EQ(fast.removed.size(), 3u) << name << d;
      GrowthOptions options;
      options.amplitude = 1e-6;
      options.periods = 4000;
      options.fit_from = 2000;
      const double grown = measure_growth(scene, network, options).per_packet;
      EXPECT_NEAR(grown, fast.radius, 1e-3) << name << d;  // a slope over 2000 periods
    }
}

// A user alone with a box drifts and spins freely: three double ones, all exact, all taken out.
TEST(Plane, FreeMotionOfASingleUserIsTakenOutInAllThreeAxes) {
  const core::Scene scene = linear_scene(scene::load_scene("plane_single")).scene;
  const Judgement judged = judge(resampled_system(scene, {}));
  EXPECT_EQ(judged.removed.size(), 6u);
  EXPECT_LT(judged.radius, 0.9999);
  const auto system = resampled_system(scene, {});
  const auto m = felt_motion(system, grasp_axes(system, scene, 0, 0));
  // Two fingers of 70 g and the box of 700 g; no drag of any kind.
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) EXPECT_NEAR(m.mean_damping(i, j), 0.0, 1e-10);
  EXPECT_NEAR(m.inertia(0, 0), 0.84, 1e-8);
}

// What is stable does not hang on where the box lies and how it is turned (fingers turned with it).
TEST(Plane, TheGraspMayLieAnywhere) {
  core::Scene scene = linear_scene(scene::load_scene("box_distributed")).scene;
  const core::NetworkModel network = round_trip(scene, 1);
  const double here = judge(resampled_system(scene, network)).radius;
  const double turn = 0.7, c = std::cos(turn), s = std::sin(turn);
  scene.objects[0].angle = turn;
  for (auto& user : scene.users)
    for (auto& f : user.fingers) {
      const core::Vec3 p = f.position;
      f.position = core::Vec3(c * p.x - s * p.y + 0.4, s * p.x + c * p.y - 0.2, 0.0);
    }
  scene.objects[0].position = core::Vec3(0.4, -0.2, 0.0);
  EXPECT_NEAR(judge(resampled_system(scene, network)).radius, here, 1e-11);
}

// Where the fingers are matters for rotation: closer to the centre, less arm.
TEST(Plane, FingersNearerTheCentreTurnTheBoxWithLessDrag) {
  core::Scene scene = centred("box_distributed");
  const core::NetworkModel network = round_trip(scene, 1);
  double before = 0.0;
  for (const double x : {0.03, 0.02, 0.01}) {
    for (auto& user : scene.users)
      for (auto& f : user.fingers) f.position.x = f.position.x < 0.0 ? -x : x;
    const auto system = resampled_system(scene, network);
    const double drag = felt_motion(system, grasp_axes(system, scene, 0, 0)).mean_damping(2, 2);
    if (before > 0.0) {
      EXPECT_LT(drag, before);
    }
    before = drag;
  }
}

TEST(Plane, KnobsReachEveryDirection) {
  core::Scene scene = linear_scene(scene::load_scene("box_distributed")).scene;
  Knob(scene, "coupler.k11.tangential.stiffness").set(scene, 7.0);
  EXPECT_EQ(scene.couplers[0].tangential.stiffness, 7.0);
  Knob(scene, "coupler.ko1.rotation.damping,coupler.ko2.rotation.damping").set(scene, 0.5);
  EXPECT_EQ(scene.couplers[5].rotation.damping, 0.5);
  Knob(scene, "coupler.*.stiffness").set(scene, 2.0);  // a factor on what is there now
  EXPECT_EQ(scene.couplers[0].tangential.stiffness, 14.0);
  EXPECT_EQ(scene.couplers[4].rotation.stiffness, 20.0);
  EXPECT_THROW(Knob(scene, "coupler.k11.sideways.stiffness"), std::invalid_argument);
  EXPECT_THROW(Knob(scene, "coupler.nobody.stiffness"), std::invalid_argument);
}

// A lone grasp drifts freely in x, y and rotation. The map by finite differences on the loop, exact
// to some 1e-8, has to take that out too; a drag of 0.01 N s/m, 1 - 9e-5 a packet, it may not.
TEST(PlaneGrasp, FreeDriftIsTakenOutOfTheMeasuredMapAndDragIsNot) {
  const core::Scene scene = linear_scene(scene::load_scene("plane_single")).scene;
  const Judgement exact = judge(resampled_system(scene, {}));
  const Judgement measured = judge(measured_system(scene, {}));
  EXPECT_EQ(exact.removed.size(), 6u);
  EXPECT_EQ(measured.removed.size(), 6u);
  EXPECT_LT(exact.radius, 0.9);
  EXPECT_NEAR(measured.radius, exact.radius, 1e-7);

  core::Scene braked = scene;
  for (auto& finger : braked.users[0].fingers) finger.damping = 0.005;
  const Judgement drag = judge(measured_system(braked, {}));
  EXPECT_NEAR(1.0 - drag.radius, 0.01 / 128.0 / 0.84, 1e-5);
}

}  // namespace
}  // namespace tandem::analysis
