#include "harness/prediction.h"

#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "harness/point_result.h"
#include "harness/tasks.h"
#include "harness/virtual_run.h"
#include "scene/load_scene.h"

namespace tandem::harness {
namespace {

core::NetworkModel round_trip(const core::Scene& scene, double packets) {
  core::NetworkModel network;
  network.set_round_trip(packets, scene.ticks_per_packet());
  return network;
}

// The reference analysis of the thesis: drag of Table 6.1 at N = 8, and the largest k2 at b2 = 3,
// k1 = 1000, b1 = 10 (third table of section 3).
TEST(Prediction, IsTheReferenceAnalysis) {
  const core::Scene distributed = scene::load_scene("axis_distributed");
  const double drag[] = {2.0395, 4.2566, 6.4737};
  for (int n = 0; n < 3; ++n)
    EXPECT_NEAR(predicted_drag(distributed, round_trip(distributed, n)), drag[n], 1e-4);
  const std::vector<std::string> edits{"coupler.k1.damping=10"};
  const core::Scene central = scene::load_scene("axis_central", edits);
  const double k2[] = {870.2224, 256.4799, 137.0446, 84.16866};
  for (int n = 0; n < 4; ++n) {
    const Prediction p = predict(central, round_trip(central, n));
    ASSERT_TRUE(p.judged) << p.note;
    EXPECT_NEAR(p.largest_coupling, k2[n], 2e-4 * k2[n]);  // bisected to 1e-4
    EXPECT_EQ(p.stable, n < 3);                            // k2 = 85
    EXPECT_TRUE(n < 3 || p.near_boundary);
  }
}

TEST(Prediction, DragOfHalfATickLiesBetween) {
  const core::Scene scene = scene::load_scene("axis_distributed");
  core::NetworkModel half;
  half.link[0][1].delay_ticks = half.link[1][0].delay_ticks = 2.5;
  core::NetworkModel two = half, three = half;
  two.link[0][1].delay_ticks = two.link[1][0].delay_ticks = 2.0;
  three.link[0][1].delay_ticks = three.link[1][0].delay_ticks = 3.0;
  EXPECT_NEAR(predicted_drag(scene, half),
              0.5 * (predicted_drag(scene, two) + predicted_drag(scene, three)), 1e-12);
  // Only one direction is between, and the machine's own jitter is no delay.
  half.link[1][0].delay_ticks = 1.998;
  three.link[1][0].delay_ticks = 2.0;
  EXPECT_NEAR(predicted_drag(scene, half),
              0.5 * (predicted_drag(scene, two) + predicted_drag(scene, three)), 1e-12);
}

// Measured delays are means and no whole ticks: the boundary then lies between those of the whole
// ones, and a whole tick's is that of the other road to it.
TEST(Prediction, BoundaryOfAMeanDelayIsBetweenThoseOfWholeTicks) {
  const core::Scene scene = scene::load_scene("axis_distributed");
  const auto boundary = [&](double ticks) {
    core::NetworkModel network;
    network.link[0][1].delay_ticks = network.link[1][0].delay_ticks = ticks;
    return predicted_coupling(scene, network);
  };
  const double two = boundary(2.0), half = boundary(2.5), three = boundary(3.0);
  EXPECT_GT(two, 1.1 * three);
  EXPECT_NEAR(2.0 / half, 1.0 / two + 1.0 / three, 1e-9);
  EXPECT_EQ(boundary(2.04), two);  // the machine's own jitter is no delay
  core::NetworkModel network;
  network.link[0][1].delay_ticks = network.link[1][0].delay_ticks = 2.0;
  EXPECT_NEAR(predict(scene, network).largest_coupling, two, 1e-3 * two);
}

PointResult real_point(double ratio_above, bool stable_above) {
  PointResult r;
  r.real = true;
  r.point.name = "p";
  r.prediction.judged = r.prediction.stable = true;
  r.measures.stability.judged = true;
  r.above.done = r.above.stability.judged = true;
  r.above.stability.stable = stable_above;
  r.above.ratio = ratio_above;
  return r;
}

TEST(Disagreements, AreJudgedByTheDelaysOfTheRunItself) {
  EXPECT_TRUE(disagreements({real_point(1.1, false)}).empty());
  ASSERT_EQ(disagreements({real_point(1.1, true)}).size(), 1u);
  EXPECT_TRUE(disagreements({real_point(1.02, true)}).empty());  // its packets came sooner
  EXPECT_EQ(comparisons({real_point(1.02, true)}).near_boundary, 1);
  EXPECT_EQ(comparisons({real_point(1.1, true)}).with_analysis, 2);
  EXPECT_EQ(disagreements({real_point(0.8, false)}).size(), 1u);  // and much sooner
}

TEST(Disagreements, VirtualTimeOverTheRecordedPacketsHasASayToo) {
  PointResult r = real_point(1.1, false);
  r.above.twin = {.judged = true, .stable = true, .near_boundary = false, .drag = kNotMeasured};
  ASSERT_EQ(disagreements({r}).size(), 1u);
  EXPECT_NE(disagreements({r})[0].what.find("virtual time"), std::string::npos);
  r.above.twin.near_boundary = true;
  EXPECT_TRUE(disagreements({r}).empty());
  r.measures.drag = 1.0;
  r.prediction.drag = 1.05;
  r.twin.drag = 1.2;
  ASSERT_EQ(disagreements({r}).size(), 1u);  // a sixth off; the analysis is within a tenth
}

TEST(Disagreements, ASessionOfAStalledMachineIsComparedWithNothingAndCounted) {
  PointResult r = real_point(1.1, true);  // would be one
  r.measures.drag = 2.0;
  r.prediction.drag = 1.0;  // and another
  EXPECT_EQ(disagreements({r}).size(), 2u);
  EXPECT_EQ(comparisons({r}).missed_ticks, 0);
  r.kick_missed = r.push_missed = r.above.missed_share = 1.01 * kMostMissed;
  EXPECT_TRUE(disagreements({r}).empty());
  EXPECT_EQ(comparisons({r}).missed_ticks, 2);  // kick and 1.1
  EXPECT_EQ(comparisons({r}).with_analysis, 0);
}

// 0.5 N s/m left of 10: a tenth of what is left; with extrapolation a fiftieth of the 10.
TEST(Disagreements, WhatExtrapolationLeavesIsKnownToAFiftiethOfWhatAHoldHas) {
  PointResult r = real_point(1.02, true);
  r.prediction.drag = 0.5;
  r.measures.drag = 0.69;
  r.hold_drag = 10.0;
  EXPECT_EQ(disagreements({r}).size(), 1u);
  r.point.scene.reconstruction.kind = core::ReconstructionKind::kExtrapolate;
  EXPECT_TRUE(disagreements({r}).empty());
  r.measures.drag = 0.71;
  EXPECT_EQ(disagreements({r}).size(), 1u);
  EXPECT_EQ(comparisons({r}).drags, 1);
  r.measures.drag = kNotMeasured;
  EXPECT_EQ(comparisons({r}).drags, 0);
}

TEST(Disagreements, ABoundaryInDelayIsNamedToATickAndATenth) {
  DelayBoundary b;
  b.scene = "box";
  b.tick = 1e-3;
  b.predicted = 6e-3;
  EXPECT_TRUE(disagreements(std::vector{b}).empty());  // sockets said nothing
  b.real_stable = 5.2e-3;
  b.real_not_stable = 6.1e-3;
  EXPECT_TRUE(disagreements(std::vector{b}).empty());
  b.real_stable = 7.5e-3;
  EXPECT_EQ(disagreements(std::vector{b}).size(), 1u);
  b.real_stable = 3e-3;
  b.real_not_stable = 4.5e-3;
  EXPECT_EQ(disagreements(std::vector{b}).size(), 1u);
  b.real_not_stable = kNotMeasured;
  b.in_virtual_time = 7e-3;
  EXPECT_TRUE(disagreements(std::vector{b}).empty());
  b.in_virtual_time = 7.1e-3;
  EXPECT_EQ(disagreements(std::vector{b}).size(), 1u);
}

TEST(Disagreements, ABoundaryThatIsNowhereIsNoneWhereSocketsOrVirtualTimeFindOne) {
  constexpr double kNowhere = std::numeric_limits<double>::infinity();
  DelayBoundary b;
  b.predicted = b.in_virtual_time = kNowhere;
  b.real_stable = 0.1;
  EXPECT_TRUE(disagreements(std::vector{b}).empty());
  b.real_not_stable = 0.05;
  EXPECT_EQ(disagreements(std::vector{b}).size(), 1u);
  b.real_not_stable = kNotMeasured;
  b.in_virtual_time = 0.05;
  EXPECT_EQ(disagreements(std::vector{b}).size(), 1u);
}

// Independent loss p on a link without delay: a packet period more with each packet lost, in the
// mean p / (1 - p) of them.
TEST(SteadyNetwork, HasTheMeanAgeOfALossyOne) {
  const core::Scene scene = scene::load_scene("axis_distributed");
  core::NetworkModel network;
  network.link[0][1].loss = network.link[1][0].loss = 0.2;
  EXPECT_FALSE(is_steady(network));
  const core::NetworkModel steady = steady_network(scene, network, 40000);
  EXPECT_TRUE(is_steady(steady));
  EXPECT_NEAR(steady.link[0][1].delay_ticks, 8.0 * 0.25, 0.1);  // 5 sd of 40000 packets
  EXPECT_NEAR(mean_age(scene, steady), (2.0 + 3.5) / 1024.0, 1e-4);
}

TEST(VirtualTime, SaysTheSameAsThePrediction) {
  for (const char* name : {"axis_central", "axis_distributed", "axis_distributed_split"})
    for (const double n : {0.0, 1.0, 6.0}) {
      SweepPoint point;
      point.name = name;
      point.scene = scene::load_scene(name);
      point.network.there.delay = n / 128;
      const PointResult r = run_virtual_point(point, {.seed = 1, .seconds = 8.0, .search = false});
      ASSERT_TRUE(r.prediction.judged) << r.prediction.note;
      EXPECT_TRUE(disagreements({r}).empty())
          << name << " n = " << n << ": " << disagreements({r}).front().what;
      if (!r.prediction.stable) continue;
      EXPECT_NEAR(r.measures.drag, r.prediction.drag, 0.01 * r.prediction.drag + 1e-6) << name;
      EXPECT_NEAR(r.measures.rendered_stiffness, r.prediction.stiffness,
                  0.05 * r.prediction.stiffness)  // measured at 0.5 Hz, predicted at rest
          << name;
    }
}

TEST(VirtualTime, SearchFindsThePredictedLargestCoupling) {
  const core::Scene scene = scene::load_scene("axis_central");
  const core::NetworkModel network = round_trip(scene, 1.0);
  EXPECT_NEAR(search_largest_coupling(scene, network, 10.0), 256.4799, 0.02 * 256.4799);
}

// 24 ticks from the server and none to it: the server reckons samples 12 ticks older than they are
// and carries them on too far. Search and analysis both bear less then, by the same.
TEST(VirtualTime, SearchAndPredictionKnowWhatAgesReckonedWrongCost) {
  core::Scene scene = scene::load_scene("axis_central");
  scene.reconstruction.kind = core::ReconstructionKind::kExtrapolate;
  FateStore fates;
  const core::NetworkModel as_nodes =
      modelled_network({{.delay = 24.0 / 1024}, {}}, scene, 1, fates);
  const double found = search_largest_coupling(scene, as_nodes, 10.0);
  EXPECT_NEAR(predicted_coupling(scene, as_nodes), found, 0.02 * found);
  core::NetworkModel known = as_nodes;
  for (auto& row : known.link)
    for (core::LinkModelParameters& link : row) link.age_error_ticks = 0.0;
  EXPECT_LT(found, 0.97 * predicted_coupling(scene, known));
}

// The drag that ages leave to extrapolation: -k_o (e_12 + e_21) T between the copies of the split.
TEST(Prediction, OfDragKeepsHowFarAgesAreOff) {
  core::Scene scene = scene::load_scene("axis_distributed_split");
  scene.reconstruction.kind = core::ReconstructionKind::kExtrapolate;
  core::NetworkModel network;
  network.link[0][1].delay_ticks = 8.5;  // between ticks, too
  network.link[1][0].delay_ticks = 4.0;
  network.link[0][1].age_error_ticks = 1.5;
  network.link[1][0].age_error_ticks = -2.0;
  const double expected = 300.0 * 0.5 * scene.tick();
  EXPECT_NEAR(predicted_drag(scene, network), expected, 1e-9);
  EXPECT_NEAR(predicted_drag(scene, steady_network(scene, network, 100)), expected, 1e-9);
}

// Motion of hand 1 leaves with the next packet and then takes the delay: 8 ticks of it more, 8
// ticks later.
TEST(VirtualTime, MotionTakesTheDelayToTheOthersForce) {
  SweepPoint point;
  point.scene = scene::load_scene("axis_distributed");
  double time[2];
  for (int n = 0; n < 2; ++n) {
    point.network.there.delay = n / 128.0;
    time[n] = run_virtual_point(point, {.seed = 1, .seconds = 2.0, .search = false})
                  .measures.motion_to_force;
  }
  EXPECT_NEAR(time[1] - time[0], 8.0 / 1024.0, 1.5 / 1024.0);
}

TEST(VirtualTime, SameSeedSameBits) {
  SweepPoint point;
  point.scene = scene::load_scene("axis_distributed_split");
  point.network.there = point.network.back = {.delay = 0.004, .jitter = 0.002, .loss = 0.1};
  const auto run = [&](std::uint64_t seed) {
    return run_virtual_point(point, {.seed = seed, .seconds = 4.0, .search = false}).measures;
  };
  const Measures a = run(7), b = run(7), c = run(8);
  EXPECT_EQ(a.gap_rms, b.gap_rms);
  EXPECT_EQ(a.drag, b.drag);
  EXPECT_NE(a.gap_rms, c.gap_rms);
}

}  // namespace
}  // namespace tandem::harness
