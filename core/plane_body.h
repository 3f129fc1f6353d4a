#pragma once

#include "core/ground_friction.h"
#include "core/integrate.h"
#include "core/plane_state.h"
#include "core/scene.h"

namespace tandem::core {

struct PlaneBodyParameters {
  double inverse_mass = 1.0;     ///< [1/kg]
  double inverse_inertia = 1.0;  ///< about the centre [1/(kg m^2)]
  /// Negative damping that gives back the drag of the packet rate (thesis chapter 6), >= 0.
  double compensation = 0.0;           ///< [N s/m]
  double compensation_rotation = 0.0;  ///< [N m s/rad]
  GroundFriction ground;
};

/// Parameters of a copy that carries `share` of the object's mass (1, or 1/N of N joined copies).
/// Inertia 0 in the scene: a box of uniform density, m (a^2 + b^2) / 12.
[[nodiscard]] inline PlaneBodyParameters plane_body_parameters(const ObjectParameters& object,
                                                               double gravity,
                                                               double share = 1.0) noexcept {
  const double a = object.size.x, b = object.size.y;
  const double whole =
      object.inertia.z > 0.0 ? object.inertia.z : object.mass * (a * a + b * b) / 12.0;
  PlaneBodyParameters p;
  p.inverse_mass = 1.0 / (share * object.mass);
  p.inverse_inertia = whole > 0.0 ? 1.0 / (share * whole) : 0.0;
  p.compensation = object.compensation;
  p.compensation_rotation = object.compensation_rotation;
  p.ground = ground_friction(object.ground_friction, object.ground_friction_rotation,
                             share * object.mass, gravity, {0.5 * a, 0.5 * b});
  return p;
}

/// Advances a body by T with the wrench held over the tick. Friction with the ground and the
/// compensation of PlaneBodyParameters are added here; a body that sticks is exactly at rest.
[[nodiscard]] inline PlaneBody step(const PlaneBodyParameters& p, Integrator integrator, double T,
                                    const PlaneBody& now, const PlaneWrench& wrench) noexcept {
  PlaneBody next = now;
  advance(integrator, T, p.ground.force * p.inverse_mass, next.p, next.v,
          (wrench.force + now.v * p.compensation) * p.inverse_mass);
  advance(integrator, T, p.ground.torque * p.inverse_inertia, next.angle, next.omega,
          (wrench.torque + now.omega * p.compensation_rotation) * p.inverse_inertia);
  return next;
}

}  // namespace tandem::core
