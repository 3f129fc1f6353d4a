#pragma once

#include "core/scene.h"

namespace tandem::core {

/// Depth and normal velocity whose spring and damper force is the mean of a tick's.
struct MeanContact {
  double depth = 0.0;            ///< mean of what is below the surface; 0: apart all tick [m]
  double normal_velocity = 0.0;  ///< along the outward normal, times the part of the tick inside
};

/// A free body's point against a wall that stands still, over the tick during which the force is
/// held. The point goes straight on, so where in the tick it meets or leaves the wall is known:
///   s       part of the tick below the surface
///   d_mean  = 1/T integral of max(0, d + r t) dt,  r = -v_n
///   f       = (k d_mean + b s r) / (1 + b s w T / 2)
/// The last is the damper on the velocity in the middle of the tick, r - w T f / 2; `w` is by how
/// much a force along the normal moves the point [1/kg]. With x += T v + T^2 a / 2 the spring is
/// the position Verlet scheme: second order, no energy from a held force, stable as semi-implicit
/// Euler is, k < 4 m / T^2 - 2 b / T for small b. Of a turning body the torque takes the arm in the
/// middle of the tick, or its energy would keep to first order only. At rest nothing changes.
///
/// For simulated bodies only. A finger is a device: what it gets is held, and is computed as such.
[[nodiscard]] inline MeanContact mean_contact(const Gain& gain, double depth,
                                              double normal_velocity, double w, double T) noexcept {
  const double approach = -normal_velocity;
  const double after = depth + approach * T;
  const double deepest = depth > after ? depth : after;
  if (!(deepest > 0.0)) return {};
  double inside = 1.0, mean = 0.5 * (depth + after);
  if (!(depth > 0.0) || !(after > 0.0)) {
    inside = deepest / (depth > after ? depth - after : after - depth);
    mean = 0.5 * inside * deepest;
  }
  const double b = gain.damping * inside;
  const double f = (gain.stiffness * mean + b * approach) / (1.0 + 0.5 * b * w * T);
  return {mean, -inside * (f > 0.0 ? approach - 0.5 * w * T * f : approach)};
}

/// Which integrators take the mean force: those that hold a force and know what it does.
[[nodiscard]] constexpr bool takes_mean_contact(Integrator integrator) noexcept {
  return integrator == Integrator::kZeroOrderHold || integrator == Integrator::kExactCoupler;
}

}  // namespace tandem::core
