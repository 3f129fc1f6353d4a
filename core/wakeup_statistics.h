#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>

namespace tandem::core {

/// How late a periodic loop woke: percentiles in fixed memory (18 kB), no allocation, trivially
/// copyable. Lateness is counted in buckets of 1/64 of its power of two, so a percentile is never
/// below the true one and above it by at most 1.6 %; below 128 ns, and the maximum, are exact.
/// For one thread; copy it across with LatestValue.
class WakeupStatistics {
 public:
  /// One wake-up, `lateness_ns` after its deadline (negative counts as 0), that skipped `missed`
  /// slots.
  void record(std::int64_t lateness_ns, std::int64_t missed = 0) noexcept {
    const auto late = static_cast<std::uint64_t>(std::max<std::int64_t>(lateness_ns, 0));
    ++buckets_[bucket_of(late)];
    ++count_;
    max_ns_ = std::max(max_ns_, static_cast<std::int64_t>(late));
    missed_ += missed;
  }

  /// The smallest lateness that at least `fraction` (0 to 1) of the wake-ups did not exceed [ns];
  /// 0 when nothing was recorded.
  [[nodiscard]] std::int64_t percentile_ns(double fraction) const noexcept {
    if (count_ == 0) return 0;
    const double rank = std::ceil(std::clamp(fraction, 0.0, 1.0) * static_cast<double>(count_));
    const auto needed = std::max<std::uint64_t>(1, static_cast<std::uint64_t>(rank));
    std::uint64_t seen = 0;
    for (std::size_t i = 0; i < kBuckets; ++i) {
      seen += buckets_[i];
      if (seen >= needed) return std::min(highest_of(i), max_ns_);
    }
    return max_ns_;
  }

  [[nodiscard]] std::uint64_t count() const noexcept { return count_; }
  [[nodiscard]] std::int64_t missed() const noexcept { return missed_; }
  [[nodiscard]] std::int64_t max_ns() const noexcept { return max_ns_; }

 private:
  // Values below 2 kSteps have a bucket each; above, each power of two is cut into kSteps.
  static constexpr int kStepBits = 6;
  static constexpr std::uint64_t kSteps = 1u << kStepBits;
  static constexpr int kTopBit = 41;  // 2^41 ns = 37 minutes; later still counts in the last bucket
  static constexpr std::size_t kBuckets = (kTopBit - kStepBits + 1) * kSteps;

  static std::size_t bucket_of(std::uint64_t value) noexcept {
    if (value < 2 * kSteps) return value;
    const int shift = static_cast<int>(std::bit_width(value)) - 1 - kStepBits;
    const std::size_t bucket = static_cast<std::size_t>(shift) * kSteps + (value >> shift);
    return std::min(bucket, kBuckets - 1);
  }

  static std::int64_t highest_of(std::size_t bucket) noexcept {
    if (bucket < 2 * kSteps) return static_cast<std::int64_t>(bucket);
    const std::uint64_t shift = bucket / kSteps - 1;
    const std::uint64_t step = bucket - shift * kSteps;
    return static_cast<std::int64_t>(((step + 1) << shift) - 1);
  }

  std::array<std::uint64_t, kBuckets> buckets_{};
  std::uint64_t count_ = 0;
  std::int64_t max_ns_ = 0;
  std::int64_t missed_ = 0;
};

}  // namespace tandem::core
