#pragma once

#include <cmath>

#include "core/finite_guard.h"

namespace tandem::core {

/// The vector cut to length `limit`, its direction kept; also where its square overflows.
template <typename V>
[[nodiscard]] inline V cut_to(const V& x, double limit, bool& was_cut) noexcept {
  double squared = inner(x, x);
  if (squared <= limit * limit) return x;
  was_cut = true;
  V scaled = x;
  if (!(squared < 1e300)) {
    double largest = 0.0;
    for (int i = 0; i < kComponents<V>; ++i)
      largest = std::fmax(largest, std::fabs(component(x, i)));
    scaled = x * (1.0 / largest);
    squared = inner(scaled, scaled);
  }
  // A hair below the limit, so that rounding of the length cannot exceed it.
  return scaled * (limit * (1.0 - 0x1p-50) / std::sqrt(squared));
}

/// The last step before the motors: finite, then at most `max_force`, then at most `max_slew`
/// away per second from the last command, in this order. 0 means not limited. A force that is not
/// finite is taken as zero and reached at the slew limit too. The first command slews from zero.
template <typename V>
class ForceGuard {
 public:
  ForceGuard() noexcept = default;
  ForceGuard(double max_force, double max_slew, double T) noexcept
      : max_force_(max_force), max_step_(max_slew * T) {}

  /// What may be sent [N]; remembered as the last command.
  [[nodiscard]] V pass(const V& wanted, Fault& faults) noexcept {
    V force = finite_or_zero(wanted, faults);
    bool cut = false, slewed = false;
    if (max_force_ > 0.0) force = cut_to(force, max_force_, cut);
    if (max_step_ > 0.0) {
      const V change = cut_to(force - last_, max_step_, slewed);
      if (slewed) force = last_ + change;
      // Between two points of the ball, but for rounding.
      bool again = false;
      if (slewed && max_force_ > 0.0) force = cut_to(force, max_force_, again);
    }
    if (cut) faults |= Fault::kForceSaturated;
    if (slewed) faults |= Fault::kForceSlewed;
    last_ = force;
    return force;
  }

  /// After the motors were switched off: the next command slews from zero.
  void reset() noexcept { last_ = V{0.0}; }
  [[nodiscard]] const V& last() const noexcept { return last_; }

 private:
  double max_force_ = 0.0;  // [N]
  double max_step_ = 0.0;   // [N] per tick
  V last_{0.0};
};

}  // namespace tandem::core
