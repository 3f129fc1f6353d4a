#include "analysis/lifted.h"

#include <cmath>

#include <gtest/gtest.h>

#include "analysis/resampled.h"
#include "analysis/two_sites.h"
#include "scene/load_scene.h"
#include "tests/analysis/random_scene.h"

namespace tandem::analysis {
namespace {

core::NetworkModel round_trip(const core::Scene& scene, double packets) {
  core::NetworkModel network;
  network.set_round_trip(packets, scene.ticks_per_packet());
  return network;
}

// Deflated spectral radii of the reference analysis, section 5, full digits.
TEST(Lifted, MeasuredFromTheLoopEqualsTheReferenceOnTable61) {
  const double central[] = {0.9962412148, 0.9962394253, 0.9962376328, 1.0009051893};
  const double distributed[] = {0.9653026932769238, 0.9324125603192328, 0.9029984, 0.9220450};
  for (int d = 0; d < 4; ++d) {
    const core::Scene c = scene::load_scene("axis_central");
    EXPECT_NEAR(judge(measured_system(c, round_trip(c, d))).radius, central[d], 6e-6) << d;
    const core::Scene s = scene::load_scene("axis_distributed");
    EXPECT_NEAR(judge(measured_system(s, round_trip(s, d))).radius, distributed[d], 6e-6) << d;
  }
}

TEST(Lifted, TheRouthTestOfTwoSitesHasTheSignOfTheSpectralRadius) {
  core::Random random(5);
  int stable = 0;
  for (int i = 0; i < 2000; ++i) {
    const tests::RandomScene s = tests::random_scene(random, 2, true);
    const auto fast = TwoSites::of(s.scene, s.network);
    ASSERT_TRUE(fast.has_value()) << s.about;
    const double rho = judge(resampled_system(s.scene, s.network)).radius;
    const double margin = fast->margin(s.scene).margin;
    stable += rho < 1.0 ? 1 : 0;
    if (std::abs(margin) < 1e-9) continue;
    EXPECT_EQ(margin > 0.0, rho < 1.0) << i << ": " << s.about << " rho " << rho << " " << margin;
  }
  EXPECT_GT(stable, 200);
  EXPECT_LT(stable, 1800);
}

}  // namespace
}  // namespace tandem::analysis
