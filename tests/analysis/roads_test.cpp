// Three roads to the lifted map, and the running loop's growth, on random scenes. Built once, run
// twice: 100 scenes in every test run, TANDEM_ROADS=1000 in the sweep (label slow).

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include <gtest/gtest.h>

#include "analysis/growth.h"
#include "analysis/lifted.h"
#include "analysis/resampled.h"
#include "scene/load_scene.h"
#include "tests/analysis/araki_yamamoto.h"
#include "tests/analysis/random_scene.h"

namespace tandem::analysis {
namespace {

int scenes_to_try() {
  const char* asked = std::getenv("TANDEM_ROADS");
  return asked != nullptr ? std::atoi(asked) : 100;
}

/// Largest distance of an eigenvalue above 0.02 in modulus to the nearest one of the other list.
double mismatch(const Judgement& a, const Judgement& b) {
  double worst = 0.0;
  for (const auto& pair : {std::pair{&a, &b}, std::pair{&b, &a}})
    for (const auto& x : pair.first->eigenvalues) {
      if (std::abs(x) <= 0.02) break;
      double nearest = 1e300;
      for (const auto& y : pair.second->eigenvalues) nearest = std::min(nearest, std::abs(x - y));
      worst = std::max(worst, nearest);
    }
  return worst;
}

// 1e-10 on eigenvalues above 0.02, every scene: at worst 4.4e-11 and 3.7e-11 in 1000. The maps must
// be in states that rounding does not hurt: forces in flight, not the samples they come from.
TEST(Roads, AllThreeHaveTheSameEigenvaluesOnRandomScenes) {
  core::Random random(11);
  const int scenes = scenes_to_try();
  double worst_a = 0.0, worst_b = 0.0;
  for (int i = 0; i < scenes; ++i) {
    const tests::RandomScene s = tests::random_scene(random, 4);
    const Judgement c = judge(measured_system(s.scene, s.network));
    const Judgement a = judge(resampled_system(s.scene, s.network));
    const Judgement b = judge(tests::araki_yamamoto(tests::multi_rate_of(s.scene, s.network)));
    EXPECT_EQ(c.removed, a.removed) << i << ": " << s.about;
    const double ac = mismatch(a, c), bc = mismatch(b, c);
    worst_a = std::max(worst_a, ac);
    worst_b = std::max(worst_b, bc);
    EXPECT_LT(ac, 1e-10) << i << ": " << s.about << " rho " << c.radius << " " << a.radius;
    EXPECT_LT(bc, 1e-10) << i << ": " << s.about << " rho " << c.radius << " " << b.radius;
  }
  std::printf("%d scenes: (a)-(c) at worst %.2g, (b)-(c) %.2g\n", scenes, worst_a, worst_b);
}

// Growth on the running loop has the sign the prediction says, outside |rho - 1| < 1e-4. The slope
// over the periods run is exact to a tenth of that distance.
TEST(Roads, TheRunningLoopGrowsWhereThePredictionSaysSo) {
  core::Random random(21);
  const int wanted = scenes_to_try();
  int points = 0, unstable = 0, wrong = 0;
  while (points < wanted) {
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
    const double grown = measure_growth(s.scene, s.network, options).per_packet;
    wrong += (grown > 1.0) != (judged.radius > 1.0) ? 1 : 0;
    EXPECT_EQ(grown > 1.0, judged.radius > 1.0)
        << s.about << " predicted " << judged.radius << ", grew " << grown;
  }
  EXPECT_GT(unstable, points / 10);
  EXPECT_LT(unstable, points * 9 / 10);
  std::printf("%d points, %d unstable, %d of the wrong sign\n", points, unstable, wrong);
}

}  // namespace
}  // namespace tandem::analysis
