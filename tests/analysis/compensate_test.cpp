#include "analysis/compensate.h"

#include <cmath>

#include <gtest/gtest.h>

#include "analysis/drag.h"
#include "analysis/lifted.h"
#include "scene/load_scene.h"

namespace tandem::analysis {
namespace {

core::NetworkModel round_trip(const core::Scene& scene, double packets) {
  core::NetworkModel network;
  network.set_round_trip(packets, scene.ticks_per_packet());
  return network;
}

core::Scene table_8_2_normal() {
  core::Scene scene = scene::load_scene("axis_distributed");
  for (auto& c : scene.couplers)
    c.gain = c.user.empty() ? core::Gain{400.0, 8.0} : core::Gain{800.0, 3.0};
  return scene;
}

// "critical bc" of the reference analysis, 4.4, both models, and H14 in eleven digits.
TEST(Compensator, CancelsTheDragWhereTheReferenceSaysSo) {
  const core::Scene t61 = scene::load_scene("axis_distributed"), t82 = table_8_2_normal();
  const struct {
    const core::Scene& scene;
    double d, original, simplified_undelayed;
  } expected[] = {{t61, 0, 1.5091, 1.0634},
                  {t61, 1, 3.1496, 1.0634},
                  {t61, 2, 4.7901, 1.0634},
                  {t82, 0, 2.1523, 1.4076}};
  for (const auto& e : expected) {
    const auto found = compensators(e.scene, round_trip(e.scene, e.d), 0, 0.1);
    ASSERT_EQ(found.size(), 1u);
    EXPECT_NEAR(found[0].simplified_undelayed, e.simplified_undelayed, 5e-5);
    // The least of every user alone and all together; alone binds at these.
    EXPECT_NEAR(found[0].cancels_now, e.original, 6e-5) << e.d;
    EXPECT_NEAR(found[0].cancels_undelayed, &e.scene == &t61 ? 1.5091 : 2.1523, 6e-5);
    // The rule: nine tenths of what cancels without delay.
    EXPECT_NEAR(found[0].value, 0.9 * found[0].cancels_undelayed, 1e-12);
  }
}

// Whatever the delay, the rule's value leaves positive drag and a stable loop: by the map, and by
// the running loop under a constant force.
TEST(Compensator, OfTheRuleLeavesPositiveDragAtEveryDelay) {
  const core::Scene scene = scene::load_scene("axis_distributed");
  const auto found = compensators(scene, round_trip(scene, 1), 0, 0.1);
  const core::Scene with = compensated(scene, 0, found);
  for (int d = 0; d < 3; ++d) {
    const LoopReport r = report_loop(with, round_trip(scene, d), 0);
    EXPECT_TRUE(r.stable());
    for (const auto& user : r.drag) EXPECT_GT(user[0], 0.1);
    const core::Scene alone = with_one_hand(with, "1");
    const Drag run = measure_drag(alone, round_trip(scene, d), 0);
    EXPECT_FALSE(run.prescribed) << "a steady state under force: drag is positive";
    EXPECT_NEAR(run.n_s_per_m.value_or(0.0), r.drag[0][0], 1e-6) << d;
  }
  // -3 at one packet of round trip is what the thesis took; without delay it is unstable (4.4).
  core::Scene three = scene;
  three.objects[0].compensation = 3.0;
  EXPECT_TRUE(report_loop(three, round_trip(scene, 1), 0).stable());
  const LoopReport early = report_loop(three, round_trip(scene, 0), 0);
  EXPECT_FALSE(early.stable());
  EXPECT_NEAR(early.radius_alone, 1.023050, 1e-6);
  EXPECT_NEAR(early.radius, 1.007408, 1e-6);
  EXPECT_NEAR(early.drag[0][0], -2.0149, 5e-5);
}

// The local user of a server feels no drag (reference analysis, 4.2): nothing may be given.
TEST(Compensator, IsNothingWhereSomebodyFeelsNoDrag) {
  for (const char* name : {"axis_central", "axis_single"}) {
    const core::Scene scene = scene::load_scene(name);
    const auto found = compensators(scene, round_trip(scene, 1), 0, 0.1);
    EXPECT_EQ(found[0].value, 0.0) << name;
  }
}

// Table 8.2 whole: one number for x and y, one for rotation; both in place at once.
TEST(Compensator, OfAPlanarSceneHoldsInAllAxesAtOnce) {
  const core::Scene scene = linear_scene(scene::load_scene("box_distributed")).scene;
  const auto found = compensators(scene, round_trip(scene, 1), 0, 0.1);
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(found[0].field, "object.box.compensation");
  EXPECT_EQ(found[1].field, "object.box.compensation_rotation");
  EXPECT_GT(found[0].value, 0.0);
  EXPECT_GT(found[1].value, 0.0);
  const core::Scene with = compensated(scene, 0, found);
  for (const double d : {0.0, 1.0}) {
    const LoopReport before = report_loop(scene, round_trip(scene, d), 0);
    const LoopReport after = report_loop(with, round_trip(scene, d), 0);
    EXPECT_TRUE(after.stable()) << d;
    for (std::size_t u = 0; u < 2; ++u)
      for (std::size_t a = 0; a < 3; ++a) {
        EXPECT_GT(after.drag[u][a], 0.0);
        EXPECT_LT(after.drag[u][a], before.drag[u][a]);
      }
  }
}

// Dead reckoning: no drag (reference analysis, 4.4: |b| < 6e-15), whatever it costs.
TEST(Compensator, StandsBesideExtrapolationWithoutDrag) {
  core::Scene scene = scene::load_scene("axis_distributed");
  scene.reconstruction.kind = core::ReconstructionKind::kExtrapolate;
  const LoopReport r = report_loop(scene, round_trip(scene, 1), 0);
  for (const auto& user : r.drag) EXPECT_NEAR(user[0], 0.0, 1e-11);
  core::Scene plane = linear_scene(scene::load_scene("box_distributed")).scene;
  plane.reconstruction.kind = core::ReconstructionKind::kExtrapolate;
  for (const auto& user : report_loop(plane, round_trip(plane, 1), 0).drag)
    for (const double drag : user) EXPECT_NEAR(drag, 0.0, 1e-10);
}

TEST(Compensator, RefusesWhatIsUnstableAsItIs) {
  const core::Scene scene = table_8_2_normal();
  EXPECT_THROW((void)compensators(scene, round_trip(scene, 2), 0, 0.1), std::domain_error);
}

}  // namespace
}  // namespace tandem::analysis
