#include <cmath>

#include <gtest/gtest.h>

#include "analysis/growth.h"
#include "analysis/lifted.h"
#include "analysis/resampled.h"
#include "analysis/response.h"
#include "analysis/stability.h"
#include "analysis/with_loop.h"
#include "scene/load_scene.h"
#include "tests/analysis/araki_yamamoto.h"
#include "tests/analysis/random_scene.h"

namespace tandem::analysis {
namespace {

core::NetworkModel round_trip(const core::Scene& scene, double packets) {
  core::NetworkModel network;
  network.set_round_trip(packets, scene.ticks_per_packet());
  return network;
}

core::Scene edited(const char* name, const std::vector<std::string>& sets) {
  return scene::load_scene(name, sets);
}

double farthest(const Judgement& a, const Judgement& b) {
  double worst = 0.0;
  for (const auto& x : a.eigenvalues) {
    if (std::abs(x) <= 0.02) break;
    double nearest = 1e300;
    for (const auto& y : b.eigenvalues) nearest = std::min(nearest, std::abs(x - y));
    worst = std::max(worst, nearest);
  }
  return worst;
}

// Road (b) against road (a), N in {2, 3, 8}, d = 0..3. The reference analysis saw up to 7e-12
// between its own roads: (I - D F) is ill-conditioned (H6).
TEST(Roads, ArakiYamamotoHasTheEigenvaluesOfTheResampledMap) {
  core::Random random(3);
  for (const int N : {2, 3, 8})
    for (int d = 0; d < 4; ++d)
      for (int plant = 0; plant < 3; ++plant) {
        const std::string rate = "rates.packet_hz=" + std::to_string(1024.0 / N);
        core::Scene c = edited("axis_central", {rate});
        core::Scene s = edited("axis_distributed", {rate});
        for (core::Scene* scene : {&c, &s})
          for (auto& coupler : scene->couplers)
            coupler.gain = {random.uniform(50.0, coupler.name == "k2" ? 300.0 : 2500.0),
                            random.uniform(2.0, 15.0)};
        const auto g = [](const core::Scene& scene, const char* name) {
          return scene.couplers.at(core::index_of(scene.couplers, name)).gain;
        };
        const auto pull = [](Eigen::MatrixXd& f, int on, int at, core::Gain k, double sign) {
          f(on, 2 * at) += sign * k.stiffness;
          f(on, 2 * at + 1) += sign * k.damping;
        };
        tests::MultiRate p;
        p.N = N;
        p.d = d;
        p.masses = {0.1, 0.4, 0.1};  // hand 1, object, hand 2
        p.fast = p.held = p.late = p.slow = Eigen::MatrixXd::Zero(3, 6);
        const core::Gain k1 = g(c, "k1"), k2 = g(c, "k2");
        pull(p.fast, 0, 0, k1, -1), pull(p.fast, 0, 1, k1, 1);
        pull(p.fast, 1, 0, k1, 1), pull(p.fast, 1, 1, k1, -1), pull(p.fast, 1, 1, k2, -1);
        pull(p.held, 1, 2, k2, 1);
        pull(p.slow, 2, 2, k2, -1), pull(p.slow, 2, 1, k2, 1);
        EXPECT_LT(farthest(judge(resampled_system(c, round_trip(c, d))), judge(araki_yamamoto(p))),
                  1e-10)
            << "central N " << N << " d " << d;

        p.masses = {0.1, 0.4, 0.1, 0.4};  // hand and copy of user 1, of user 2
        p.fast = p.held = p.late = p.slow = Eigen::MatrixXd::Zero(4, 8);
        const char* own[] = {"k11", "k22"};
        const char* cross[] = {"k12", "k21"};
        const char* copy[] = {"ko1", "ko2"};
        for (int u = 0; u < 2; ++u) {
          const int h = 2 * u, o = h + 1, other = 2 - 2 * u;
          const core::Gain a = g(s, own[u]), b = g(s, cross[u]), k = g(s, copy[u]);
          pull(p.fast, h, h, a, -1), pull(p.fast, h, o, a, 1);
          pull(p.fast, o, h, a, 1), pull(p.fast, o, o, a, -1);
          pull(p.fast, o, o, b, -1), pull(p.fast, o, o, k, -1);
          Eigen::MatrixXd& far = u == 0 ? p.held : p.late;  // all delay on link 1 to 2
          pull(far, o, other, b, 1), pull(far, o, other + 1, k, 1);
        }
        EXPECT_LT(farthest(judge(resampled_system(s, round_trip(s, d))), judge(araki_yamamoto(p))),
                  1e-10)
            << "distributed N " << N << " d " << d;
      }
}

// Growth on the running loop has the sign the prediction says, at a thousand random points outside
// |rho - 1| < 1e-4. The slope over the periods run is exact to a tenth of that distance.
TEST(Roads, TheRunningLoopGrowsWhereThePredictionSaysSo) {
  core::Random random(21);
  int points = 0, unstable = 0;
  while (points < 1000) {
    const tests::RandomScene s = tests::random_scene(random, 2);
    const Judgement judged = judge(resampled_system(s.scene, s.network));
    const double away = std::abs(judged.radius - 1.0);
    // Where uniform motion is kept the loop's deviation drifts on by it: growth is one.
    if (away < 1e-4 || judged.removed.size() > 1) continue;
    ++points;
    unstable += judged.radius > 1.0 ? 1 : 0;
    GrowthOptions options;
    options.periods = away > 0.02 ? 400 : away > 2e-3 ? 3000 : 20000;
    options.fit_from = options.periods / 2;
    const double grown = with_loop_of<core::AxisWorld>(
        s.scene, s.network, [&](auto& loop) { return measure_growth(loop, options).per_packet; });
    EXPECT_EQ(grown > 1.0, judged.radius > 1.0)
        << s.about << " predicted " << judged.radius << ", grew " << grown;
  }
  EXPECT_GT(unstable, 100);
  EXPECT_LT(unstable, 900);
}

// H1: hand and object at rest or drifting alike are one double eigenvalue one; both are taken out.
TEST(HardCases, JordanBlocksAtOneAreTakenOutOfASingleUser) {
  core::Random random(2);
  for (int i = 0; i < 200; ++i) {
    core::Scene scene = edited("axis_single", {});
    scene.users[0].mass = random.uniform(0.02, 0.5);
    scene.objects[0].mass = random.uniform(0.05, 2.0);
    const double mu = 1.0 / (1.0 / scene.users[0].mass + 1.0 / scene.objects[0].mass);
    const double T = scene.tick(), b = random.uniform(0.01, 0.99) * 2.0 * mu / T;
    const double k = random.uniform(0.01, 0.99) * 2.0 * b / T;
    scene.couplers[0].gain = {k, b};
    const Judgement judged = judge(resampled_system(scene, {}));
    EXPECT_EQ(judged.eigenvalues.size(), 2u);
    EXPECT_LT(judged.radius, 1.0) << "k " << k << " b " << b;
  }
}

// H2: drag beside the exact one, 1 - lambda by 80-digit arithmetic (reference analysis).
TEST(HardCases, ATinyDragIsSeenBesideTheTranslation) {
  const std::pair<double, double> expected[] = {
      {100.0, 5.1705000097801565e-03}, {0.01, 5.173737e-07}, {1e-6, 5.173737e-11}};
  for (const auto& [ko, drag] : expected) {
    bool found = false;
    for (const int users_coupled : {1, 2}) {
      core::Scene scene = edited("axis_distributed", {});
      for (auto& c : scene.couplers) {
        if (c.name[1] == 'o') c.gain.stiffness = ko;
        if (users_coupled == 1 && c.user == "2") c.gain = {};
        if (c.name == "k12" || c.name == "k21") c.gain = {};
      }
      for (const auto& z : judge(resampled_system(scene, {})).eigenvalues)
        found = found || std::abs((1.0 - z.real()) / drag - 1.0) < 1e-3;
    }
    EXPECT_TRUE(found) << ko;
  }
}

// H5: stiff wall, k_w = 30000, b_w = 20 beside other dampers on 10 g: far outside, and with 512 or
// 1024 ticks a packet beyond what doubles hold. 5.23965 a tick (reference analysis).
TEST(HardCases, WhatOverflowsIsUnstableAndKeepsItsLogarithm) {
  for (const int N : {8, 64, 512, 1024}) {
    core::Scene scene = edited("axis_distributed", {"object.box.mass=0.01"});
    scene.rates.packet_hz = 1024.0 / N;
    core::WallParameters wall;
    wall.name = "wall";
    wall.normal = core::Vec3(-1, 0, 0);
    wall.gain = {30000, 20};
    wall.attached = true;
    scene.walls.push_back(wall);
    const Judgement judged = judge(resampled_system(scene, {}));
    EXPECT_FALSE(judged.stable());
    EXPECT_NEAR(judged.log2_radius / N, std::log2(5.23965), 0.002 + 1.0 / N) << N;
    if (N == 8) {
      EXPECT_NEAR(judged.radius, 664114.264374723, 1e-6);
    }
    const Judgement loop = judge(measured_system(scene, {}));
    EXPECT_FALSE(loop.stable()) << N;
    EXPECT_LT(StabilityJudge(scene, {}).margin(scene), 0.0) << N;
  }
}

// H9: a split delay that is not whole packets matters; below a tick it acts as the next tick.
TEST(HardCases, SplitDelaysOfSingleTicksAreTheReferences) {
  const core::Scene scene =
      edited("axis_distributed",
             {"coupler.k11.stiffness=800", "coupler.k22.stiffness=800", "coupler.k12.stiffness=800",
              "coupler.k21.stiffness=800", "coupler.ko1.stiffness=400", "coupler.ko2.stiffness=400",
              "coupler.k11.damping=3", "coupler.k22.damping=3", "coupler.k12.damping=3",
              "coupler.k21.damping=3", "coupler.ko1.damping=8", "coupler.ko2.damping=8"});
  const std::tuple<double, double, double> expected[] = {
      {12, 0, 1.0032910852086063}, {6, 6, 1.003472238597151},         {8, 4, 1.003291085208604},
      {4, 8, 1.0032910852086043},  {10, 2, 1.0032198975856814},       {12, 4, 1.0191417343511717},
      {11, 5, 1.0191483108718122}, {1.249, 1.249, 0.9622056525343847}};
  for (const auto& [there, back, rho] : expected) {
    core::NetworkModel network;
    network.link[0][1].delay_ticks = there;
    network.link[1][0].delay_ticks = back;
    EXPECT_NEAR(judge(resampled_system(scene, network)).radius, rho, 1e-11) << there << "+" << back;
    EXPECT_NEAR(judge(measured_system(scene, network)).radius, rho, 1e-11) << there << "+" << back;
  }
}

// H10: without damping every spring is unstable, by sqrt(1 + k T^2 / 2 mu) a tick; at b = k T / 2
// the sign is right to one part in a million.
TEST(HardCases, AnUndampedSpringIsUnstableByTheClosedForm) {
  const double T = 1.0 / 1024.0, mu = 0.08;
  for (const double k : {1000.0, 1.0, 1e-2, 1e-4}) {
    core::Scene scene = edited("axis_single", {});
    scene.rates.packet_hz = 1024.0;
    scene.couplers[0].gain = {k, 0.0};
    const double expected = std::sqrt(1.0 + k * T * T / (2.0 * mu)) - 1.0;
    const double found = judge(resampled_system(scene, {})).radius - 1.0;
    EXPECT_NEAR(found / expected, 1.0, 1e-15 / expected + 1e-9) << k;
  }
  for (const double side : {-1e-6, 1e-6}) {
    core::Scene scene = edited("axis_single", {});
    scene.couplers[0].gain = {100.0, 100.0 * T / 2.0 * (1.0 + side)};
    EXPECT_EQ(judge(resampled_system(scene, {})).stable(), side > 0.0);
  }
}

// Pieces that do not feel each other are judged one by one; none of their drifts counts.
TEST(HardCases, ScenesThatFallApartAreJudgedPieceByPiece) {
  core::Scene scene = edited("axis_central", {});
  scene.couplers[1].gain = {};
  const Judgement judged = judge(resampled_system(scene, {}));
  EXPECT_EQ(judged.parts, 2);
  EXPECT_TRUE(judged.stable());
  EXPECT_LT(judged.radius, 0.99);
}

// Dead reckoning takes the drag away at its source (reference analysis, 4.4: |b| < 6e-15); the
// uniform motion that is kept then must be taken out before judging.
TEST(HardCases, ExtrapolationIsMeasuredWithItsUniformMotionTakenOut) {
  const core::Scene scene = edited("axis_distributed", {"reconstruction.kind=EXTRAPOLATE"});
  EXPECT_FALSE(why_not_resampled(scene, {}).empty());
  const LiftedSystem system = measured_system(scene, round_trip(scene, 1));
  EXPECT_EQ(judge(system).removed.size(), 2u);
  EXPECT_NEAR(free_motion(system, system.ports[0]).mean_damping, 0.0, 1e-10);
}

}  // namespace
}  // namespace tandem::analysis
