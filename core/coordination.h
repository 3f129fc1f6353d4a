#pragma once

#include <numbers>

#include "core/plane_state.h"
#include "core/scene.h"

namespace tandem::core {

/// The difference of two angles that belong to copies of one thing. Copies integrate their angles
/// without wrapping, so the difference is the true twist and is used as it is, up to half a turn.
/// Beyond, whole turns are taken out: copies a full turn apart look the same (one span on while the
/// other's packets were away) and must not be wound back. The torque changes sign at half a turn,
/// where no direction is better than the other.
[[nodiscard]] inline double twist(double other, double self) noexcept {
  double difference = other - self;
  if (difference > std::numbers::pi || difference < -std::numbers::pi)
    difference -= 2.0 * std::numbers::pi * std::floor(difference / (2.0 * std::numbers::pi) + 0.5);
  return difference;
}

/// Coupler between two copies of a body (thesis k_o): the wrench on the own copy,
///   f = k (p_other - p_self) + b (v_other - v_self),  tau likewise with the rotation gain.
/// Linear in the states while the copies are less than half a turn apart.
[[nodiscard]] inline PlaneWrench coordinate(const Gain& linear, const Gain& rotation,
                                            const PlaneBody& self,
                                            const PlaneBody& other) noexcept {
  return {(other.p - self.p) * linear.stiffness + (other.v - self.v) * linear.damping,
          twist(other.angle, self.angle) * rotation.stiffness +
              (other.omega - self.omega) * rotation.damping};
}

}  // namespace tandem::core
