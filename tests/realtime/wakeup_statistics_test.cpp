#include "core/wakeup_statistics.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <type_traits>
#include <vector>

#include <gtest/gtest.h>

namespace tandem::core {
namespace {

static_assert(std::is_trivially_copyable_v<WakeupStatistics>);

TEST(WakeupStatistics, NothingRecordedIsZero) {
  const WakeupStatistics statistics;
  EXPECT_EQ(statistics.count(), 0u);
  EXPECT_EQ(statistics.percentile_ns(0.99), 0);
  EXPECT_EQ(statistics.max_ns(), 0);
}

TEST(WakeupStatistics, SmallValuesAreExact) {
  WakeupStatistics statistics;
  for (int i = 1; i <= 100; ++i) statistics.record(i);
  EXPECT_EQ(statistics.percentile_ns(0.50), 50);
  EXPECT_EQ(statistics.percentile_ns(0.99), 99);
  EXPECT_EQ(statistics.percentile_ns(1.0), 100);
  EXPECT_EQ(statistics.percentile_ns(0.0), 1);
}

// Independent answer: the sorted samples themselves. The bound is the class's promise.
TEST(WakeupStatistics, PercentilesAreThoseOfTheSortedSamplesWithinABucket) {
  std::mt19937_64 random(5);
  std::vector<std::int64_t> samples;
  WakeupStatistics statistics;
  for (int i = 0; i < 20'000; ++i) {
    // Log-uniform over 1 ns to 1 s: every power of two is used.
    const double exponent = 9.0 * static_cast<double>(random() >> 11) * 0x1p-53;
    const auto late = static_cast<std::int64_t>(std::pow(10.0, exponent));
    samples.push_back(late);
    statistics.record(late);
  }
  std::sort(samples.begin(), samples.end());
  for (const double fraction : {0.001, 0.01, 0.1, 0.25, 0.5, 0.75, 0.9, 0.99, 0.999, 0.9999}) {
    const auto rank =
        static_cast<std::size_t>(std::ceil(fraction * static_cast<double>(samples.size())));
    const std::int64_t exact = samples[rank - 1];
    EXPECT_GE(statistics.percentile_ns(fraction), exact) << fraction;
    EXPECT_LE(static_cast<double>(statistics.percentile_ns(fraction)),
              static_cast<double>(exact) * (1.0 + 1.0 / 64))
        << fraction;
  }
  EXPECT_EQ(statistics.max_ns(), samples.back());
  EXPECT_EQ(statistics.percentile_ns(1.0), samples.back());
}

TEST(WakeupStatistics, CountsMissedAndSurvivesAbsurdValues) {
  WakeupStatistics statistics;
  statistics.record(-5);
  statistics.record(std::int64_t{1} << 60, 7);
  statistics.record(100, 2);
  EXPECT_EQ(statistics.missed(), 9);
  EXPECT_EQ(statistics.max_ns(), std::int64_t{1} << 60);
  EXPECT_EQ(statistics.percentile_ns(0.01), 0);
  EXPECT_EQ(statistics.count(), 3u);
}

}  // namespace
}  // namespace tandem::core
