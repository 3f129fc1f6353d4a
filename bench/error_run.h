#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "bench/error_cases.h"
#include "bench/processor_time.h"

namespace tandem::bench {

struct ErrorRun {
  double ns_per_s = 0.0;        ///< processor time for a simulated second [ns]
  std::vector<double> samples;  ///< states at the grid, one after the other
};

/// Runs a case once for its states, then again and again for its time. `make()` returns a pointer
/// to a model at t = 0 with step() and sample(double*); making is not timed.
template <typename Make>
[[nodiscard]] ErrorRun measure(const ErrorPoint& point, int hz, Make&& make) {
  const int width = sample_width(point.which), count = sample_count(point);
  const int steps = hz / kGridRate;
  ErrorRun run;
  run.samples.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(count));
  {
    auto model = make();
    for (int i = 0; i < count; ++i) {
      for (int s = 0; s < steps; ++s) model->step();
      model->sample(run.samples.data() + static_cast<std::ptrdiff_t>(i) * width);
    }
  }
  constexpr double kEnough = 4e5;  // [ns]
  double least = 1e300, total = 0.0;
  for (int again = 0; again < 64 && (again < 2 || total < kEnough); ++again) {
    auto model = make();
    const double start = core_ns();
    for (int s = 0; s < count * steps; ++s) model->step();
    const double used = core_ns() - start;
    total += used;
    least = std::min(least, used);
  }
  run.ns_per_s = least / (static_cast<double>(count) / kGridRate);
  return run;
}

}  // namespace tandem::bench
