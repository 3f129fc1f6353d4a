#pragma once

#include <numbers>

#include "core/components.h"
#include "core/elementary.h"

namespace tandem::core {

/// Velocity from quantised position: backward difference, then a first-order low-pass with the
/// cut-off f_c, discretised exactly for an input held over the tick:
///   v[k] = a v[k-1] + (1 - a) (p[k] - p[k-1]) / T,  a = e^(-2 pi f_c T)
/// A constant velocity is estimated without error once settled, a quantum q gives steps of
/// (1 - a) q / T. First sample: zero. f_c <= 0: the plain difference. V is double, Vec2 or Vec3.
template <typename V>
class VelocityEstimate {
 public:
  VelocityEstimate() noexcept = default;
  VelocityEstimate(double cutoff_hz, double T) noexcept
      : inverse_T_(1.0 / T),
        keep_(cutoff_hz > 0.0 ? natural_exp(-2.0 * std::numbers::pi * cutoff_hz * T) : 0.0) {}

  [[nodiscard]] V update(const V& position) noexcept {
    if (!primed_) {
      primed_ = true;
      last_ = position;
      return velocity_;
    }
    const V difference = (position - last_) * inverse_T_;
    velocity_ = velocity_ * keep_ + difference * (1.0 - keep_);
    last_ = position;
    return velocity_;
  }

  [[nodiscard]] const V& velocity() const noexcept { return velocity_; }

  /// Visits last position and velocity; these are the states.
  template <typename Visitor>
  void visit_state(Visitor&& visitor) {
    visitor.position(last_);
    visitor.velocity(velocity_);
  }

 private:
  double inverse_T_ = 0.0;
  double keep_ = 0.0;
  bool primed_ = false;
  V last_{0.0};
  V velocity_{0.0};
};

}  // namespace tandem::core
