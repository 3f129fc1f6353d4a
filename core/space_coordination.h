#pragma once

#include "core/scene.h"
#include "core/space_state.h"

namespace tandem::core {

/// Coupler between two copies of a body (thesis k_o) in space: the wrench on the own copy,
///   f   = k (p_other - p_self) + b (v_other - v_self)
///   tau = k_r r + b_r (omega_other - omega_self),   exp(r) = q_other q_self^-1 in W
/// r is the shortest way from one to the other, up to half a turn: copies a full turn apart look
/// the same. The torque is the exact gradient of k_r |r|^2 / 2 and equal and opposite on the other
/// copy.
[[nodiscard]] inline SpaceWrench coordinate(const Gain& linear, const Gain& rotation,
                                            const SpaceBody& self,
                                            const SpaceBody& other) noexcept {
  return {(other.p - self.p) * linear.stiffness + (other.v - self.v) * linear.damping,
          rotation_between(self.q, other.q) * rotation.stiffness +
              (other.omega - self.omega) * rotation.damping};
}

}  // namespace tandem::core
