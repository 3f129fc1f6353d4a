#pragma once

#include <cmath>

#include "core/components.h"
#include "core/elementary.h"
#include "core/vec.h"

namespace tandem::core {

/// Limits of Coulomb friction between a body and the ground it lies on.
struct GroundFriction {
  double force = 0.0;   ///< against sliding [N]; 0: none
  double torque = 0.0;  ///< against spinning [N m]; 0: none
};

/// Mean distance of a rectangle's points from its centre [m], half edges p, q > 0, h the half
/// diagonal:  (1/3) (h + p^2/(2q) ln((q+h)/p) + q^2/(2p) ln((p+h)/q)).
[[nodiscard]] inline double mean_radius(const Vec2& half) noexcept {
  const double p = half.x, q = half.y;
  if (!(p > 0.0) || !(q > 0.0)) return 0.5 * std::fmax(p, q);  // a rod: half its half length
  const double h = std::sqrt(p * p + q * q);
  return (h + p * p / (2.0 * q) * natural_log((q + h) / p) +
          q * q / (2.0 * p) * natural_log((p + h) / q)) /
         3.0;
}

/// Limits of a box of evenly spread weight: mu m g against sliding, mu_R m g r_mean against
/// spinning. The two are kept separate, as in the thesis: a sliding box does not spin more easily.
[[nodiscard]] inline GroundFriction ground_friction(double coefficient, double rotation_coefficient,
                                                    double mass, double gravity,
                                                    const Vec2& half) noexcept {
  const double weight = mass * gravity;
  return {coefficient * weight, rotation_coefficient * weight * mean_radius(half)};
}

/// Takes the impulse of friction out of one tick. `v0` is the velocity before it, `v` the one after
/// it without friction, `limit` = T F / m [m/s]. True: the body comes to rest within this tick.
/// Then `v` is exactly zero, and so it stays while T |force| / m <= limit; it never reverses.
/// The cone is round: only the direction of `v` counts. V is double or Vec2.
template <typename V>
[[nodiscard]] inline bool rub_on_ground(double limit, V& v) noexcept {
  const double squared = inner(v, v);
  if (squared <= limit * limit) {
    v = V{0.0};
    return true;
  }
  v *= 1.0 - limit / std::sqrt(squared);
  return false;
}
[[nodiscard]] inline bool rub_on_ground(double limit, double& v) noexcept {
  if (std::fabs(v) <= limit) {
    v = 0.0;
    return true;
  }
  v -= std::copysign(limit, v);
  return false;
}

/// Way of a body that comes to rest within the tick, `free_v` being its velocity at the end of the
/// tick without friction: it is braked by the constant deceleration along v0,
///   t_stop = T |v0|^2 / (limit |v0| - (free_v - v0).v0),  x = v0 t_stop / 2.
template <typename V>
[[nodiscard]] inline V stopping_way(double T, double limit, const V& v0, const V& free_v) noexcept {
  const double squared = inner(v0, v0);
  if (!(squared > 0.0)) return V{0.0};
  const double braking = limit * std::sqrt(squared) - inner(free_v - v0, v0);
  const double part = braking > squared ? squared / braking : 1.0;
  return v0 * (0.5 * T * part);
}

}  // namespace tandem::core
