#include "bench/latency.h"

#include <cmath>
#include <numeric>
#include <stdexcept>
#include <string>

#include <gtest/gtest.h>

#include "bench/latency_path.h"
#include "scene/load_scene.h"

namespace tandem::bench {
namespace {

constexpr std::int64_t kMs = 1'000'000;

/// Ticks every millisecond, a packet in every eighth, with the same times behind each.
PathRun regular(int packets) {
  PathRun run;
  for (int k = 0; k <= 8 * packets; ++k) run.wakes.push_back(k * kMs);
  for (int p = 0; p <= packets; ++p) {
    const std::int64_t at = 8 * p * kMs;
    run.packets.push_back({at, at + 2'000, at + 40'000, at + 70'000, at + 500'000, at + 501'000});
  }
  return run;
}

double mean(const Stages& s, Stage stage) { return s.mean_us[static_cast<std::size_t>(stage)]; }

TEST(LatencyStages, WaitsAreHalfTheirPeriodsAndTheRestIsAsStamped) {
  Stages s;
  add_run(regular(100), 20000, 1, s);
  // Half a tick, and half of the 8 ms between packets less that; five standard deviations of a mean
  // of 20000 uniform draws over 8 ms are 82 us, over 1 ms 10 us.
  EXPECT_NEAR(mean(s, Stage::kSample), 500.0, 10.0);
  EXPECT_NEAR(mean(s, Stage::kSample) + mean(s, Stage::kSlot), 4000.0, 82.0);
  const double rounding = 1e-8;  // of 20000 sums of 1e2
  EXPECT_NEAR(mean(s, Stage::kPublish), 2.0, rounding);
  EXPECT_NEAR(mean(s, Stage::kLink), 38.0, rounding);
  EXPECT_NEAR(mean(s, Stage::kWire), 30.0, rounding);
  EXPECT_NEAR(mean(s, Stage::kApply), 430.0, rounding);
  EXPECT_NEAR(mean(s, Stage::kForce), 1.0, rounding);
  EXPECT_NEAR(std::accumulate(s.mean_us.begin(), s.mean_us.end(), 0.0), s.mean_total_us, 1e-6);
  ASSERT_EQ(s.handed_over.size(), 101U);
  EXPECT_EQ(s.handed_over[0], 68.0);
  for (const double slot : s.us[static_cast<std::size_t>(Stage::kSlot)]) {
    EXPECT_GE(slot, 0.0);
    EXPECT_LE(slot, 7000.0);
  }
}

TEST(LatencyStages, AMotionWaitsForTheNextPacketThatWasUsed) {
  PathRun run;
  run.wakes = {0, kMs, 2 * kMs};
  run.packets = {{2 * kMs, 2 * kMs, 2 * kMs, 2 * kMs, 2 * kMs, 2 * kMs}};  // that of 1 ms was lost
  Stages s;
  add_run(run, 1000, 1, s);
  for (const double total : s.total) {
    EXPECT_GE(total, 0.0);
    EXPECT_LE(total, 2000.0);
  }
  EXPECT_NEAR(s.mean_total_us, 1000.0, 5.0 * 577.0 / std::sqrt(1000.0));
}

TEST(LatencyStages, TwoRunsAreOneOfBoth) {
  Stages s;
  add_run(regular(10), 100, 1, s);
  add_run(regular(10), 300, 2, s);
  EXPECT_EQ(s.total.size(), 400U);
  EXPECT_NEAR(s.mean_total_us, std::accumulate(s.total.begin(), s.total.end(), 0.0) / 400.0, 1e-8);
  add_run({}, 100, 3, s);  // a run that left nothing
  EXPECT_EQ(s.total.size(), 400U);
}

TEST(LatencyPath, EveryPacketPassesItsStampsInOrder) {
  const PathResult path = run_path(scene::load_scene("box_distributed"), {0.5, 0.5, 0});
  EXPECT_GT(path.bytes, 112U);  // 14 values
  for (const PathRun& run : path.runs) {
    ASSERT_FALSE(run.packets.empty());
    // 64 in half a second, and what leaves in the rounding at its ends.
    EXPECT_LE(run.packets.size(), 66U);
    std::int64_t before = 0;
    for (const PathPacket& p : run.packets) {
      EXPECT_LT(before, p.sampled);
      EXPECT_LE(p.sampled, p.published);
      EXPECT_LE(p.published, p.sent);
      EXPECT_LE(p.sent, p.arrived);
      EXPECT_LE(p.used, p.felt);
      // A tick may wake before the arrival and look after it.
      EXPECT_LT(p.arrived, p.felt);
      before = p.sampled;
    }
  }
}

TEST(LatencyPath, OtherScenesAreRefused) {
  EXPECT_THROW((void)run_path(scene::load_scene("box_central"), {}), std::invalid_argument);
}

TEST(Sockperf, ItsSummaryIsRead) {
  const SockperfSummary s = read_sockperf(
      "sockperf: Summary: Latency is 31.104 usec\n"
      "sockperf: \x1b[2;35mTotal 70 observations\x1b[0m; each percentile contains 0.70\n"
      "sockperf: ---> <MAX> observation =  554.380\n"
      "sockperf: ---> percentile 99.900 =  554.000\n"
      "sockperf: ---> percentile 50.000 =   44.677\n");
  EXPECT_EQ(s.mean_us, 31.104);
  EXPECT_EQ(s.count, 70);
  EXPECT_EQ(s.at(0.5), 44.677);
  EXPECT_EQ(s.at(0.999), 554.0);
  EXPECT_EQ(s.at(1.0), 554.38);
  EXPECT_TRUE(std::isnan(s.at(0.99)));
  EXPECT_TRUE(read_sockperf("sockperf: ERROR: cannot bind\n").percentiles.empty());
}

}  // namespace
}  // namespace tandem::bench
