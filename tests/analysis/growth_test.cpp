#include "analysis/growth.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>

#include <gtest/gtest.h>

#include "analysis/linearised_grasp.h"
#include "core/random.h"
#include "scene/load_scene.h"
#include "tests/analysis/resampled_model.h"

namespace tandem::analysis {
namespace {

double growth_of(const core::Scene& scene, double delay_packets, double amplitude = 1.0) {
  core::NetworkModel network;
  network.set_round_trip(delay_packets, scene.ticks_per_packet());
  GrowthOptions options;
  options.amplitude = amplitude;
  return measure_growth(scene, network, options).per_packet;
}

// The slope of a logarithm over 6000 periods is exact to about |log(first/last mode)| / 6000; the
// reference analysis asks for 1e-4.
constexpr double kSlope = 1e-4;

// Deflated spectral radii of the reference analysis, Table 6.1.
TEST(Growth, EqualsTheReferenceOnTable61) {
  const double central[] = {0.996241, 0.996239, 0.996237, 1.000905};
  const double distributed[] = {0.965303, 0.932413, 0.902998, 0.922045, 0.956562};
  for (int d = 0; d < 4; ++d)
    EXPECT_NEAR(growth_of(scene::load_scene("axis_central"), d), central[d], kSlope) << d;
  for (int d = 0; d < 5; ++d)
    EXPECT_NEAR(growth_of(scene::load_scene("axis_distributed"), d), distributed[d], kSlope) << d;
}

core::Scene with_gains(core::Scene scene,
                       std::initializer_list<std::pair<const char*, core::Gain>> gains) {
  for (const auto& [name, gain] : gains)
    scene.couplers.at(core::index_of(scene.couplers, name)).gain = gain;
  return scene;
}

// Boundaries of the reference analysis, both sides of each: Fig 5.2 at k12 = 3000 has two stable
// intervals in k11, which a bisection would miss.
TEST(Growth, IsOnTheRightSideOfBothIntervalsOfADisconnectedRegion) {
  const core::Scene base = scene::load_scene("axis_distributed");
  const auto at = [&](double k11) {
    return growth_of(with_gains(base, {{"k11", {k11, 10}},
                                       {"k22", {k11, 10}},
                                       {"k12", {3000, 10}},
                                       {"k21", {3000, 10}},
                                       {"ko1", {1000, 10}},
                                       {"ko2", {1000, 10}}}),
                     1.0);
  };
  EXPECT_LT(at(530.6252 * 0.98), 1.0);
  EXPECT_GT(at(530.6252 * 1.02), 1.0);
  EXPECT_GT(at(9383.22 * 0.99), 1.0);
  EXPECT_LT(at(9383.22 * 1.02), 1.0);
  EXPECT_LT(at(21704.06 * 0.999), 1.0);
  EXPECT_GT(at(21704.06 * 1.001), 1.0);
}

// (3.18): stable exactly below 2 b / T = 20480 N/m; with one or two ticks of computation delay at
// 6434.727 and 3661.067 (reference analysis, section 1).
TEST(Growth, OfASingleUserFlipsAtTheKnownStiffness) {
  const double limit[] = {20480.0, 6434.727, 3661.067};
  for (int ticks = 0; ticks < 3; ++ticks) {
    core::Scene scene = scene::load_scene("axis_single");
    scene.rates.latency_ticks = ticks;
    scene = with_gains(scene, {{"k", {limit[ticks] * 1.002, 10}}});
    EXPECT_GT(growth_of(scene, 0), 1.0 + 1e-5) << ticks;
    // Below, everything dies out but the free drift x = v t, which is taken out.
    EXPECT_LT(growth_of(with_gains(scene, {{"k", {limit[ticks] * 0.998, 10}}}), 0), 1.0 - 1e-5)
        << ticks;
  }
}

// (3.18): the relative mode of a single user is z^2 - (2 - bT/mu - kT^2/2mu) z + 1 - bT/mu +
// kT^2/2mu; at 1000 N/m, 10 N s/m and mu = 0.08 kg its roots are complex and their product is the
// square of the radius of a tick, so that a packet period of 8 ticks has its 4th power.
TEST(Growth, OfASingleUserIsThatOfTheRelativeMode) {
  const double T = 1.0 / 1024.0, mu = 0.08, product = 1.0 - 10 * T / mu + 1000 * T * T / (2 * mu);
  const double sum = 2.0 - 10 * T / mu - 1000 * T * T / (2 * mu);
  ASSERT_LT(sum * sum, 4.0 * product);
  EXPECT_NEAR(growth_of(scene::load_scene("axis_single"), 0), std::pow(product, 4), kSlope);
}

// A velocity filter is part of the linear loop: the tick of hand, object and filter as a matrix
// written down here. Beyond the boundary, where the drift x = v t is not the largest.
TEST(Growth, CountsTheVelocityFilterOfTheDevice) {
  core::Scene scene = scene::load_scene("axis_single");
  core::DeviceParameters device;
  device.name = "d";
  device.velocity_cutoff_hz = 40.0;
  device.max_force = 1.0;  // not linear: left out
  scene.devices.push_back(device);
  scene.users[0].fingers[0].device = "d";
  const double T = 1.0 / 1024.0, a = std::exp(-2.0 * 3.14159265358979323846 * 40.0 * T);
  for (const double k : {12000.0, 18000.0}) {
    scene = with_gains(scene, {{"k", {k, 10}}});
    // States: x_h, v_h, x_o, v_o, last x_h, v estimated.
    Eigen::Matrix<double, 1, 6> estimate, force;
    estimate << (1 - a) / T, 0, 0, 0, -(1 - a) / T, a;
    force << k, 0, -k, -10, 0, 0;
    force += 10 * estimate;
    Eigen::Matrix<double, 6, 6> A = Eigen::Matrix<double, 6, 6>::Identity();
    A(0, 1) = A(2, 3) = T;
    A.row(0) -= T * T / 2 / 0.1 * force;
    A.row(1) -= T / 0.1 * force;
    A.row(2) += T * T / 2 / 0.4 * force;
    A.row(3) += T / 0.4 * force;
    A.row(4) << 1, 0, 0, 0, 0, 0;
    A.row(5) = estimate;
    const Eigen::Matrix<std::complex<double>, 6, 1> roots = A.eigenvalues();
    double radius = 0.0;
    for (const auto& z : roots) radius = std::max(radius, std::abs(z));
    ASSERT_GT(radius, 1.001);
    EXPECT_NEAR(growth_of(linearised_at_grasp(scene), 0), std::pow(radius, 8), kSlope) << k;
  }
}

// Fates of packets change the number of those in flight: refused, never measured beyond the end.
// 12 / n times the integral of (u - 3/2) ln u from 1 to 2, which is 3/4 - ln 2, n = 6000 periods;
// the sum is the integral to about one part in n.
TEST(Growth, OfAFreeDriftIsTheSlopeOfTheLogarithm) {
  const double expected = 12.0 * (0.75 - std::log(2.0)) / 6000.0;
  EXPECT_NEAR(std::log(drift_growth({})) / expected, 1.0, 1e-3);
}

TEST(Growth, RefusesANetworkWithFates) {
  const core::Scene scene = scene::load_scene("axis_distributed");
  core::NetworkModel network;
  network.set_round_trip(2.0, scene.ticks_per_packet());
  network.link[0][1].loss = 0.1;
  EXPECT_THROW((void)measure_growth(scene, network), std::invalid_argument);
}

// A copy of 0.01 kg on its dampers grows at every tick by itself: 10^187 times in a packet period
// of 512 ticks, whose squares are no numbers any more, and beyond all numbers in 1024. Neither is
// the same as having died out.
TEST(Growth, IsMeasuredAsFarAsThereAreNumbersAndInfiniteBeyond) {
  core::Scene scene = scene::load_scene("axis_distributed");
  scene.objects[0].mass = 0.01;
  scene.rates.packet_hz = 2.0;
  const double half = growth_of(scene, 0);
  EXPECT_TRUE(std::isfinite(half));
  EXPECT_GT(half, 1e160);
  scene.rates.packet_hz = 1.0;
  EXPECT_EQ(growth_of(scene, 0), std::numeric_limits<double>::infinity());
}

// Two independent ways to the same number: the running loop, and matrices written down in the test.
TEST(Growth, EqualsTheResampledModelOnRandomScenes) {
  core::Random random(7);
  const auto spring = [&](double k_max) {
    return tests::Spring{random.uniform(20.0, k_max), random.uniform(2.0, 20.0)};
  };
  for (int i = 0; i < 24; ++i) {
    tests::TwoUsers p;
    p.N = 1 + static_cast<int>(random.uniform() * 12.0);
    p.d = static_cast<int>(random.uniform() * 4.0);
    p.m1 = random.uniform(0.05, 0.3);
    p.m2 = random.uniform(0.05, 0.3);
    p.mo = random.uniform(0.1, 1.0);
    const bool central = i % 2 == 0;
    core::Scene scene = scene::load_scene(central ? "axis_central" : "axis_distributed");
    scene.rates.packet_hz = 1024.0 / p.N;
    scene.users[0].mass = p.m1;
    scene.users[1].mass = p.m2;
    scene.objects[0].mass = p.mo;
    double expected = 0.0;
    const auto gain = [](tests::Spring s) { return core::Gain{s.k, s.b}; };
    if (central) {
      const auto k1 = spring(3000), k2 = spring(400);
      expected = tests::central_radius(p, k1, k2);
      scene = with_gains(scene, {{"k1", gain(k1)}, {"k2", gain(k2)}});
    } else {
      const auto k11 = spring(4000), k22 = spring(4000), k12 = spring(1500), k21 = spring(1500),
                 ko = spring(1500);
      expected = tests::distributed_radius(p, k11, k22, k12, k21, ko);
      scene = with_gains(scene, {{"k11", gain(k11)},
                                 {"k22", gain(k22)},
                                 {"k12", gain(k12)},
                                 {"k21", gain(k21)},
                                 {"ko1", gain(ko)},
                                 {"ko2", gain(ko)}});
    }
    EXPECT_NEAR(growth_of(scene, p.d), expected, kSlope)
        << (central ? "central" : "distributed") << " N=" << p.N << " d=" << p.d;
  }
}

// Compensator -3 N s/m of Fig 6.4 at n = 1 (reference analysis, 4.4): one hand 0.997868, both
// coupled 0.970676; at n = 0 the same is unstable, 1.023050 and 1.007408.
TEST(Growth, WithCompensationEqualsTheReference) {
  core::Scene scene = scene::load_scene("axis_distributed");
  scene.objects[0].compensation = 3.0;
  EXPECT_NEAR(growth_of(scene, 1), 0.970676, kSlope);
  EXPECT_NEAR(growth_of(scene, 0), 1.007408, kSlope);
}

// Where a delay is split between the links only its sum matters, if it is whole packets.
TEST(Growth, DependsOnTheSumOfWholeDelaysOnly) {
  const core::Scene scene = scene::load_scene("axis_distributed");
  core::NetworkModel split;
  split.link[0][1].delay_ticks = 8.0;
  split.link[1][0].delay_ticks = 8.0;
  const double both = measure_growth(scene, split).per_packet;
  EXPECT_NEAR(both, growth_of(scene, 2), 2e-6);
}

// Delays in ticks, all on one link (reference analysis, H9): not monotone, and the truth for Table
// 8.2 lies between 11 and 12 ticks.
TEST(Growth, FollowsDelaysOfSingleTicks) {
  const core::Scene base = scene::load_scene("axis_distributed");
  const core::Scene table82 = with_gains(base, {{"k11", {800, 3}},
                                                {"k22", {800, 3}},
                                                {"k12", {800, 3}},
                                                {"k21", {800, 3}},
                                                {"ko1", {400, 8}},
                                                {"ko2", {400, 8}}});
  const std::pair<int, double> expected[] = {{0, 0.948788},  {1, 0.942683},  {8, 0.984141},
                                             {11, 0.998830}, {12, 1.003291}, {40, 1.071962}};
  for (const auto& [ticks, rho] : expected)
    EXPECT_NEAR(growth_of(table82, ticks / 8.0), rho, kSlope) << ticks;
}

// A wall holds the object to the ground: nothing may be removed, and the scene of thesis 6.2 with
// both users is stable (reference analysis, section 5: 0.9353412381996122 at d = 1, Table 8.2).
TEST(Growth, KeepsTheTranslationWhereAWallBreaksTheSymmetry) {
  core::Scene scene = with_gains(scene::load_scene("axis_distributed"), {{"k11", {800, 3}},
                                                                         {"k22", {800, 3}},
                                                                         {"k12", {800, 3}},
                                                                         {"k21", {800, 3}},
                                                                         {"ko1", {400, 8}},
                                                                         {"ko2", {400, 8}}});
  core::WallParameters wall;
  wall.name = "wall";
  wall.normal = core::Vec3(-1, 0, 0);
  wall.gain = {4000, 30};
  wall.attached = true;
  scene.walls.push_back(wall);
  EXPECT_NEAR(growth_of(scene, 1), 0.9353412381996122, kSlope);
}

// Section 8.1 of the thesis: with a packet period of round trip the distributed grasp can be used,
// the centralized one of Table 8.1 cannot, and the one with reduced remote gains can.
TEST(Growth, OfTheLinearisedGraspsSaysWhatTheExperimentSaid) {
  const auto at_grasp = [](const char* name) {
    return growth_of(linearised_at_grasp(scene::load_scene(name)), 1, 1e-6);
  };
  EXPECT_LT(at_grasp("box_distributed"), 0.995);
  EXPECT_GT(at_grasp("box_central_table_8_1"), 1.1);
  EXPECT_LT(at_grasp("box_central"), 0.999);
}

}  // namespace
}  // namespace tandem::analysis
