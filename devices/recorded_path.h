#pragma once

#include <string>
#include <vector>

#include "core/vec.h"

namespace tandem::devices {

using core::Vec3;

enum class Interpolation {
  kCubic,   ///< cubic Hermite; slopes from the parabola through three neighbours, secants at the
            ///< ends
  kLinear,  ///< straight between samples; the velocity is the slope of the piece
};

/// What comes after the last sample.
enum class PathEnd {
  kHold,  ///< rests there
  kLoop,  ///< starts again, faded over the seam
};

struct PathSample {
  double time = 0.0;   ///< [s]
  Vec3 position{0.0};  ///< [m]
};

/// A recorded motion as a function of time. The time is the caller's slot number times the sample
/// period, so nothing is resampled in advance and nothing drifts. No filter: what is faster than
/// half the caller's rate folds down. Constant after construction; `at` may be called by any
/// thread.
class RecordedPath {
 public:
  struct Motion {
    Vec3 position{0.0};  ///< [m]
    Vec3 velocity{0.0};  ///< [m/s]
  };

  /// Samples in strict order of time, finite, at least two, else std::invalid_argument; the first
  /// becomes time 0. With kLoop, `seam` [s] (at most half the length) is how long the end is faded
  /// into the beginning: one lap is shorter than the recording by this much.
  RecordedPath(std::vector<PathSample> samples, Interpolation interpolation, PathEnd end,
               double seam);

  /// Before 0 the first sample at rest; after the end as PathEnd says. No allocation.
  [[nodiscard]] Motion at(double time) const noexcept;

  [[nodiscard]] double length() const noexcept { return samples_.back().time; }  ///< [s]
  /// One lap of a loop [s].
  [[nodiscard]] double lap() const noexcept { return length() - seam_; }
  [[nodiscard]] const std::vector<PathSample>& samples() const noexcept { return samples_; }
  [[nodiscard]] double mean_rate_hz() const noexcept {
    return static_cast<double>(samples_.size() - 1) / length();
  }

 private:
  [[nodiscard]] Motion within(double time) const noexcept;

  std::vector<PathSample> samples_;
  std::vector<Vec3> slopes_;  // [m/s], cubic only
  PathEnd end_;
  double seam_;
};

}  // namespace tandem::devices
