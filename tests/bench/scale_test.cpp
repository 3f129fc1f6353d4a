#include "bench/scale.h"

#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "bench/percentile.h"
#include "scene/load_scene.h"
#include "scene/validate_scene.h"

namespace tandem::bench {
namespace {

TEST(Percentile, IsTheSmallestValueThatTheShareDoesNotExceed) {
  std::vector<double> values;
  for (int i = 1000; i >= 1; --i) values.push_back(i);
  const Percentiles p = percentiles_of(values);
  EXPECT_EQ(p.p50, 500.0);
  EXPECT_EQ(p.p99, 990.0);
  EXPECT_EQ(p.p999, 999.0);
  EXPECT_EQ(p.max, 1000.0);
  EXPECT_EQ(p.count, 1000U);
  EXPECT_NEAR(p.mean, 500.5, 1e-9);  // rounding of 1000 sums
  EXPECT_EQ(percentiles_of({7.0}).p999, 7.0);
  EXPECT_EQ(percentiles_of({3.0, 1.0}).p50, 1.0);
  EXPECT_EQ(percentiles_of({1.0, 3.0, 2.0}).p50, 2.0);
  EXPECT_EQ(percentiles_of({}).count, 0U);
}

TEST(ScaleFit, FindsThePowerThatMadeThePoints) {
  std::vector<ScalePoint> points;
  for (const double n : {2.0, 4.0, 8.0, 20.0, 64.0}) points.push_back({n, 3.0 * std::pow(n, 1.7)});
  const PowerLaw law = fit_power_law(points);
  EXPECT_NEAR(law.exponent, 1.7, 1e-12);  // rounding of logarithms
  EXPECT_NEAR(law.factor, 3.0, 1e-11);
  EXPECT_LT(law.spread, 1e-12);
  EXPECT_EQ(law.points, 5);
}

TEST(ScaleFit, LeavesOutWhatIsBelowItsStartAndIsNothingForOnePoint) {
  // A constant part rules the first points: 100 + n^2, from 32 on nearly n^2.
  std::vector<ScalePoint> points;
  for (const double n : {2.0, 4.0, 8.0, 32.0, 64.0}) points.push_back({n, 100.0 + n * n});
  const double by_hand = std::log2((100.0 + 4096.0) / (100.0 + 1024.0));
  EXPECT_NEAR(fit_power_law(points, 32.0).exponent, by_hand, 1e-12);
  EXPECT_LT(fit_power_law(points).exponent, 1.5);
  EXPECT_TRUE(std::isnan(fit_power_law(points, 64.0).exponent));
  EXPECT_TRUE(std::isnan(fit_power_law({}).exponent));
}

TEST(ScaleFit, TheKneeIsOnTheLineBetweenTwoPointsOrWhereTheLawMeetsTheBudget) {
  const std::vector<ScalePoint> points{{2.0, 10.0}, {8.0, 160.0}};  // 2.5 n^2
  const PowerLaw law = fit_power_law(points);
  const Knee between = find_knee(points, law, 40.0);
  EXPECT_TRUE(between.measured);
  EXPECT_NEAR(between.n, 4.0, 1e-12);
  const Knee beyond = find_knee(points, law, 25000.0);
  EXPECT_FALSE(beyond.measured);
  EXPECT_NEAR(beyond.n, 100.0, 1e-9);
  EXPECT_EQ(find_knee(points, law, 5.0).n, 2.0);
  EXPECT_TRUE(std::isinf(find_knee(points, law, 2.5 * 801.0 * 801.0).n));  // 8 is the last point
  const std::vector<ScalePoint> falling{{2.0, 10.0}, {8.0, 5.0}};
  EXPECT_TRUE(std::isinf(find_knee(falling, fit_power_law(falling), 20.0).n));
}

TEST(ScaleScene, TwoUsersAndOneObjectAreTheShippedScene) {
  const core::Scene shipped = scene::load_scene("box_distributed");
  EXPECT_EQ(scene::to_text(grown_scene(shipped, {2, 1})), scene::to_text(shipped));
}

TEST(ScaleScene, EveryHandMeetsEveryObjectAndTheSceneIsValid) {
  for (const char* name : {"box_central", "box_distributed"}) {
    const core::Scene shipped = scene::load_scene(name);
    for (const ScaleSize size : {ScaleSize{8, 1}, ScaleSize{8, 4}, ScaleSize{2, 4}}) {
      const core::Scene scene = grown_scene(shipped, size);
      const auto n = static_cast<std::size_t>(size.users);
      const auto m = static_cast<std::size_t>(size.objects);
      EXPECT_EQ(scene.users.size(), n);
      EXPECT_EQ(scene.objects.size(), m);
      const bool central = scene.architecture == core::Architecture::kCentral;
      EXPECT_EQ(scene.couplers.size(), central ? n * m : m * n * (n + 1));
      for (const auto& problem : scene::validate_scene(scene))
        ADD_FAILURE() << scene.name << " " << problem.path << problem.text;
      EXPECT_EQ(scene.objects.back().mass, shipped.objects[0].mass * (size.users - 1));
    }
  }
}

TEST(ScaleScene, OthersAreRefused) {
  EXPECT_THROW((void)grown_scene(scene::load_scene("axis_central"), {4, 1}), std::invalid_argument);
  EXPECT_THROW((void)grown_scene(scene::load_scene("box_central"), {1, 1}), std::invalid_argument);
}

TEST(Scale, WhatIsBeyondTheCapacitiesIsRefusedWithTheirNumbers) {
  try {
    (void)measure_scale(scene::load_scene("box_central"), {core::kMaxUsers + 1, 1}, {});
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("holds " + std::to_string(core::kMaxUsers)),
              std::string::npos)
        << error.what();
  }
}

TEST(Scale, ThreeUsersAreMeasuredOnTheirSockets) {
  for (const char* name : {"box_central", "box_distributed"}) {
    const ScaleRow row = measure_scale(scene::load_scene(name), {3, 1}, {1, 0.3, 0});
    EXPECT_GT(row.tick_ns, 0.0);
    EXPECT_GT(row.virtual_speed, 0.0);
    EXPECT_TRUE(row.finite);
    const bool central = row.architecture == "central";
    // Two fingers of position and velocity, a box of 6; from a server two forces and a box.
    EXPECT_EQ(row.values_in, central ? 8 : 14);
    EXPECT_EQ(row.values_out, central ? 10 : 14);
    EXPECT_EQ(row.traffic.why_not, "");
    // 2 others at 128 Hz on whatever this machine does beside; the window cuts a packet at each
    // end.
    EXPECT_GT(row.traffic.in_per_s, 0.0);
    EXPECT_LT(row.traffic.in_per_s, 2 * 128 + 2 * 2 / 0.3);
    EXPECT_GT(row.traffic.delivered_per_s, 0.0);
    EXPECT_LE(row.traffic.link_share, 2.0);
  }
}

TEST(Scale, GrowthIsToldForEachArchitectureWithItsBudget) {
  std::vector<ScaleRow> rows;
  for (const int n : {2, 4, 8, 16}) {
    ScaleRow row;
    row.architecture = "mesh";
    row.size = {n, 1};
    row.tick_ns = 1000.0 * n;                                  // 1 ms at 1000
    row.virtual_speed = 100.0 / n / n;                         // real time at 10
    row.traffic.in_per_s = row.traffic.out_per_s = 128.0 * n;  // 12800 at 100
    rows.push_back(row);
  }
  int told = 0;
  for (const Growth& g : growths_of(rows, 12800.0)) {
    EXPECT_EQ(g.architecture + g.over, "meshusers");
    const auto expect = [&](double exponent, double knee, bool measured) {
      EXPECT_NEAR(g.law.exponent, exponent, 1e-12);
      EXPECT_NEAR(g.knee.n, knee, 1e-8 * knee);
      EXPECT_EQ(g.knee.measured, measured);
      ++told;
    };
    if (g.what == "tick of the site") expect(1.0, 1e3, false);
    if (g.what == "time of the session") expect(2.0, 10.0, true);
    if (g.what == "packets of the site") expect(1.0, 100.0, false);
  }
  EXPECT_EQ(told, 3);
}

}  // namespace
}  // namespace tandem::bench
