#include <iomanip>

#include <gtest/gtest.h>

#include "analysis/lifted.h"
#include "analysis/stability.h"
#include "tests/hard/grasp.h"

namespace tandem::hard {
namespace {

TEST(HardPlane, TheLimitOfATwoFingerGraspIsWhereTheAnalysisFindsIt) {
  // Free drift of the lone grasp has modulus one: unstable is what is clearly above.
  core::Scene linear = analysis::linear_scene(held_grasp()).scene;
  const analysis::Knob knob(linear, "coupler.k.stiffness");
  analysis::StabilityJudge judge(linear, {});
  double low = 500.0, high = 500.0;
  const auto grows = [&](double k) {
    knob.set(linear, k);
    return judge.radius(linear) > 1.0 + 1e-6;
  };
  ASSERT_FALSE(grows(low));
  while (!grows(high)) high *= 1.05;
  ASSERT_LT(high, 40000.0);
  for (int i = 0; i < 30; ++i) (grows(0.5 * (low + high)) ? high : low) = 0.5 * (low + high);
  // The same halvings in every build: the same bits.
  EXPECT_EQ(low, kGraspLimit) << std::setprecision(17) << low;
}

TEST(HardPlane, TheLimitOfCoordinationIsWhereTheAnalysisFindsIt) {
  const core::Scene scene = scene::load_scene("box_distributed", std::vector<std::string>{});
  core::NetworkModel calm;
  calm.set_round_trip(1.0, 8);
  core::Scene linear = analysis::linear_scene(scene).scene;
  const analysis::Knob knob(linear, "coupler.ko1.stiffness,coupler.ko2.stiffness");
  analysis::StabilityJudge judge(linear, calm);
  analysis::IntervalOptions options;
  options.samples = 20;
  options.tolerance = 1e-6;
  const auto stable = analysis::stable_intervals(judge, linear, knob, 10.0, 20000.0, options);
  ASSERT_FALSE(stable.empty());
  ASSERT_LT(stable[0].high, 19000.0);
  EXPECT_EQ(stable[0].high, kCoordinationLimit) << std::setprecision(17) << stable[0].high;
}

}  // namespace
}  // namespace tandem::hard
