#pragma once

#include "core/scene.h"

namespace tandem::core {

/// Depth and normal velocity whose spring and damper force is the mean of a tick's.
struct MeanContact {
  double depth = 0.0;            ///< mean of what is below the surface; 0: apart all tick [m]
  double normal_velocity = 0.0;  ///< along the outward normal, times the part of the tick inside
};

/// A body's point against a wall that stands still, over the tick during which the force is held.
/// The point goes straight on, so where in the tick it meets or leaves the wall is known:
///   d_mean = 1/T integral of max(0, d - v_n t) dt,  s the part of the tick inside
///   f      = k d_mean - b s v_n
/// With x += T v + T^2 a / 2 the spring is the position Verlet scheme: second order, and no energy
/// from a held force, where a force of the tick's start gives back k T / 2 of negative damping. The
/// damper is of first order. Stable as semi-implicit Euler is, k < 4 m / T^2 - 2 b / T. Of a
/// turning body the torque takes the arm in the middle of the tick, or its energy would keep to
/// first order only. At rest nothing changes.
///
/// For simulated bodies only. A finger is a device: what it gets is held, and is computed as such.
[[nodiscard]] inline MeanContact mean_contact(double depth, double normal_velocity,
                                              double T) noexcept {
  const double after = depth - normal_velocity * T;
  const double deepest = depth > after ? depth : after;
  if (!(deepest > 0.0)) return {};
  if (depth > 0.0 && after > 0.0) return {0.5 * (depth + after), normal_velocity};
  const double inside = deepest / (depth > after ? depth - after : after - depth);
  return {0.5 * inside * deepest, inside * normal_velocity};
}

/// Which integrators take the mean force: those that hold a force and know what it does.
[[nodiscard]] constexpr bool takes_mean_contact(Integrator integrator) noexcept {
  return integrator == Integrator::kZeroOrderHold || integrator == Integrator::kExactCoupler;
}

}  // namespace tandem::core
