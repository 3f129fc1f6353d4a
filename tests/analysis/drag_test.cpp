#include "analysis/drag.h"

#include <gtest/gtest.h>

#include "scene/load_scene.h"

namespace tandem::analysis {
namespace {

Drag drag_of(const core::Scene& scene, double delay_packets) {
  core::NetworkModel network;
  network.set_round_trip(delay_packets, scene.ticks_per_packet());
  const int user = drag_user(scene);
  const core::Scene alone = with_one_hand(scene, scene.users[user].name);
  return measure_drag(alone, network, user);
}

// Reference analysis, 4.1: exact by a direct solve, affine in the delay.
TEST(Drag, EqualsTheReferenceOnTable61) {
  const double expected[] = {2.0395358830, 4.2565966938, 6.4736575046, 8.6907183154};
  for (int d = 0; d < 4; ++d) {
    const Drag drag = drag_of(scene::load_scene("axis_distributed"), d);
    ASSERT_TRUE(drag.n_s_per_m.has_value());
    EXPECT_NEAR(*drag.n_s_per_m, expected[d], 1e-6) << d;
    EXPECT_FALSE(drag.prescribed);
  }
}

TEST(Drag, OfTheRemoteUserOfAServerDoesNotDependOnTheDelay) {
  for (int d = 0; d < 4; ++d)
    EXPECT_NEAR(drag_of(scene::load_scene("axis_central"), d).n_s_per_m.value_or(-1.0),
                0.2937320305, 1e-6)
        << d;
}

// b(d) = b(0) + d T_t k11 ko (ko + k21) / (k11 k21 + ko k21 + k11 ko) (reference analysis, 4.1).
TEST(Drag, GrowsWithTheDelayAsTheClosedFormSays) {
  core::Scene scene = scene::load_scene("axis_distributed");
  const double k11 = 1700, k21 = 250, ko = 520;
  for (auto& c : scene.couplers) {
    if (c.name == "k11" || c.name == "k22") c.gain = {k11, 12};
    if (c.name == "k12" || c.name == "k21") c.gain = {k21, 4};
    if (c.name == "ko1" || c.name == "ko2") c.gain = {ko, 9};
  }
  const double slope = (1.0 / 128.0) * k11 * ko * (ko + k21) / (k11 * k21 + ko * k21 + k11 * ko);
  const double b0 = drag_of(scene, 0).n_s_per_m.value();
  EXPECT_NEAR(drag_of(scene, 1).n_s_per_m.value() - b0, slope, 1e-7);
  EXPECT_NEAR(drag_of(scene, 2).n_s_per_m.value() - b0, 2 * slope, 1e-7);
}

// The compensator of Fig 6.4: -3 N s/m leaves 0.2022 at n = 1; at n = 0 it leaves -2.0149, where
// no steady state exists under a force and the motion is prescribed (reference analysis, 4.4).
TEST(Drag, IsGivenBackByCompensationAndMeasuredByMotionWhereItIsNegative) {
  core::Scene scene = scene::load_scene("axis_distributed");
  scene.objects[0].compensation = 3.0;
  EXPECT_NEAR(drag_of(scene, 1).n_s_per_m.value(), 0.2022, 5e-5);
  const Drag negative = drag_of(scene, 0);
  EXPECT_TRUE(negative.prescribed);
  EXPECT_NEAR(negative.n_s_per_m.value_or(0.0), -2.0149, 5e-3);
}

// A single user's momentum is kept: no drag, also where a stiff coupler and a tick of computation
// delay leave nothing but rounding to settle.
TEST(Drag, OfASingleUserIsNothing) {
  core::Scene scene = scene::load_scene("axis_single");
  scene.rates.latency_ticks = 1;
  scene.couplers[0].gain.stiffness = 6400.0;
  EXPECT_NEAR(drag_of(scene, 0).n_s_per_m.value_or(1.0), 0.0, 1e-9);
}

// Dead reckoning takes the drag away at its source (reference analysis, 4.4: |b| < 6e-15).
TEST(Drag, IsGoneWithExtrapolation) {
  core::Scene scene = scene::load_scene("axis_distributed");
  scene.reconstruction.kind = core::ReconstructionKind::kExtrapolate;
  for (int d = 0; d < 3; ++d)
    EXPECT_NEAR(drag_of(scene, d).n_s_per_m.value_or(1.0), 0.0, 1e-9) << d;
}

}  // namespace
}  // namespace tandem::analysis
