#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace tandem::bench {

/// The smallest value that at least `fraction` (above 0, to 1) of the values do not exceed: one of
/// them, never between two. Of at least one value, sorted.
[[nodiscard]] inline double percentile_of_sorted(const std::vector<double>& sorted,
                                                 double fraction) {
  const double rank = std::ceil(fraction * static_cast<double>(sorted.size()));
  const double last = static_cast<double>(sorted.size());
  return sorted[static_cast<std::size_t>(std::clamp(rank, 1.0, last)) - 1];
}

struct Percentiles {
  double mean = 0.0, p50 = 0.0, p99 = 0.0, p999 = 0.0, max = 0.0;
  std::size_t count = 0;
};

/// All 0 of no values.
[[nodiscard]] inline Percentiles percentiles_of(std::vector<double> values) {
  Percentiles out;
  out.count = values.size();
  if (values.empty()) return out;
  std::sort(values.begin(), values.end());
  for (const double v : values) out.mean += v / static_cast<double>(values.size());
  out.p50 = percentile_of_sorted(values, 0.5);
  out.p99 = percentile_of_sorted(values, 0.99);
  out.p999 = percentile_of_sorted(values, 0.999);
  out.max = values.back();
  return out;
}

}  // namespace tandem::bench
