#include "net/link_statistics.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace tandem::net {
namespace {

double uniform(std::mt19937_64& random) {
  return (static_cast<double>(random() >> 11) + 0.5) * 0x1p-53;
}

// Exact answer: nearest rank in the sorted vector, mean and deviation in two passes.
TEST(DelayStatistics, AgreesWithTheSortedVectorWithinTheStatedError) {
  std::mt19937_64 random(2);
  for (const double scale : {50.0, 40e3, 3e6, 2e9}) {
    DelayStatistics statistics;
    std::vector<double> all;
    for (int i = 0; i < 100'000; ++i) {
      const auto delay = static_cast<std::int64_t>(scale * (1.0 - std::log(uniform(random))));
      statistics.record(delay);
      all.push_back(1e-9 * static_cast<double>(delay));
    }
    std::sort(all.begin(), all.end());
    const DelaySummary s = statistics.summary();
    const auto exact = [&](double f) {
      return all[static_cast<std::size_t>(std::ceil(f * static_cast<double>(all.size()))) - 1];
    };
    for (const auto& [fraction, got] :
         {std::pair{0.5, s.p50}, {0.9, s.p90}, {0.99, s.p99}, {0.999, s.p999}}) {
      EXPECT_GE(got, exact(fraction) * (1.0 - 1e-12));
      EXPECT_LE(got, exact(fraction) * (1.0 + 1.0 / 64.0));
    }
    double mean = 0.0, squares = 0.0;
    for (double d : all) mean += d / static_cast<double>(all.size());
    for (double d : all) squares += (d - mean) * (d - mean) / static_cast<double>(all.size());
    EXPECT_NEAR(s.mean, mean, 1e-10 * mean);  // rounding of 1e5 sums
    EXPECT_NEAR(s.rms_jitter, std::sqrt(squares), 1e-10 * mean);
    EXPECT_DOUBLE_EQ(s.min, all.front());
    EXPECT_DOUBLE_EQ(s.max, all.back());
    EXPECT_EQ(s.count, all.size());
  }
}

TEST(DelayStatistics, IsAllZeroBeforeTheFirstDelay) {
  const DelaySummary s = DelayStatistics().summary();
  EXPECT_EQ(s.count, 0u);
  EXPECT_EQ(s.p999, 0.0);
  EXPECT_EQ(s.rms_jitter, 0.0);
}

TEST(ArrivalJitter, SettlesAtTheMeanChangeOfTransitAsInRfc3550) {
  // Transit alternates between 5 and 7 ms, so |D| is always 2 ms: J[n] = 2 (1 - (15/16)^n) ms.
  ArrivalJitter jitter;
  for (int i = 0; i <= 40; ++i) {
    const std::int64_t send = 1'000'000'000 + i * 8'000'000ll;
    jitter.record(send, send + (i % 2 == 0 ? 5'000'000 : 7'000'000));
  }
  EXPECT_NEAR(jitter.jitter(), 2e-3 * (1.0 - std::pow(15.0 / 16.0, 40)), 1e-15);
}

TEST(LinkStatistics, CountsWhatWasSentReceivedAndWhy) {
  LinkStatistics statistics;
  core::SequenceGate gate;
  statistics.sent(100, true);
  statistics.sent(120, false);
  for (const std::uint64_t n : {1, 2, 5, 4, 4}) (void)gate.admit(n);
  statistics.received(90, Decode::kOk);
  statistics.received(10, Decode::kMalformed);
  statistics.received(90, Decode::kDuplicate);
  const LinkSnapshot s = statistics.snapshot(gate);
  EXPECT_EQ(s.packets_sent, 2u);
  EXPECT_EQ(s.bytes_sent, 220u);
  EXPECT_EQ(s.send_failures, 1u);
  EXPECT_EQ(s.packets_received, 3u);
  EXPECT_EQ(s.bytes_received, 190u);
  EXPECT_EQ(s.by_reason.of(Decode::kMalformed), 1u);
  EXPECT_EQ(s.accepted, 3u);
  EXPECT_EQ(s.lost, 1u);
  EXPECT_EQ(s.reordered, 1u);
  EXPECT_EQ(s.duplicates, 1u);
}

}  // namespace
}  // namespace tandem::net
