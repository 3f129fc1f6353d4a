#pragma once

#include "core/integrate.h"
#include "core/scene.h"
#include "core/space_state.h"

namespace tandem::core {

struct SpaceBodyParameters {
  double inverse_mass = 1.0;  ///< [1/kg]
  Vec3 inertia{1.0};          ///< principal moments, along the axes of B [kg m^2]
  Vec3 inverse_inertia{1.0};  ///< [1/(kg m^2)]
  double weight = 0.0;        ///< along -z [N]; 0: none
  /// Negative damping that gives back the drag of the packet rate (thesis chapter 6), >= 0.
  double compensation = 0.0;           ///< [N s/m]
  double compensation_rotation = 0.0;  ///< [N m s/rad]
};

/// Principal moments of the whole object; 0 in the scene: uniform density,
///   box m (b^2 + c^2) / 12, sphere 2/5 m r^2.
[[nodiscard]] inline Vec3 principal_moments(const ObjectParameters& object) noexcept {
  const Vec3& j = object.inertia;
  if (j.x > 0.0 && j.y > 0.0 && j.z > 0.0) return j;
  if (object.shape == Shape::kSphere)
    return Vec3{0.4 * object.mass * object.radius * object.radius};
  const Vec3 square = object.size * object.size;
  return Vec3{square.y + square.z, square.z + square.x, square.x + square.y} * (object.mass / 12.0);
}

/// Parameters of a copy that carries `share` of the object's mass (1, or 1/N of N joined copies).
/// `gravity` is 0 where objects have no weight [m/s^2].
[[nodiscard]] inline SpaceBodyParameters space_body_parameters(const ObjectParameters& object,
                                                               double gravity,
                                                               double share = 1.0) noexcept {
  SpaceBodyParameters p;
  p.inverse_mass = 1.0 / (share * object.mass);
  p.inertia = principal_moments(object) * share;
  p.inverse_inertia = Vec3{1.0} / p.inertia;
  p.weight = share * object.mass * gravity;
  p.compensation = object.compensation;
  p.compensation_rotation = object.compensation_rotation;
  return p;
}

/// Rotation vector, in B, by which a body of angular momentum `momentum` (in B, at the start) turns
/// freely in T. The implicit midpoint rule on the momentum,
///   r = T J^-1 (m0 + m1) / 2,   m1 = exp(-r) m0,
/// by fixed-point iteration. As m1 - m0 = -(2 tan(|r|/2) / |r|) r x (m0 + m1) / 2 is normal to
/// J^-1 (m0 + m1), the energy m.J^-1 m / 2 is kept exactly; that the momentum in W is kept is the
/// caller's doing. Second order in T, the same backwards in time, exact about a principal axis.
/// Source: Simo & Wong, Int. J. Numer. Meth. Eng. 31, 1991 (their implicit algorithm that keeps
/// energy and momentum).
///
/// The iteration contracts by about half the angle turned in a tick: below 100 rad/s it ends after
/// 2 to 8 steps. Where it does not converge (a turn of radians a tick) only the energy errs, and
/// that stays below |m|^2 / (2 min J) as the momentum is kept: it can't blow up.
[[nodiscard]] inline Vec3 free_turn(const Vec3& inverse_inertia, double T,
                                    const Vec3& momentum) noexcept {
  constexpr int kMostSteps = 16;
  constexpr double kSettled = 1e-28;  // square of the relative error left
  Vec3 turn = inverse_inertia * momentum * T;
  double last = inner(turn, turn);
  for (int i = 0; i < kMostSteps; ++i) {
    const Quat half = rotation_by(turn);
    const Vec3 v{half.x, half.y, half.z};
    const Vec3 c = cross(v, momentum);
    const Vec3 next = inverse_inertia * (momentum - c * half.w + cross(v, c)) * T;
    const Vec3 change = next - turn;
    turn = next;
    // Changes c shrink geometrically: what is left is about c_k^2 / c_(k-1).
    const double now = inner(change, change);
    if (!(now * now > kSettled * last * inner(turn, turn))) break;
    last = now;
  }
  return turn;
}

/// Rotation over T with the torque held. The torque's impulse T tau is given before and after a
/// free turn in the parts that the linear formulas of core/integrate.h give theirs:
///   zero-order hold: half, half     semi-implicit Euler: all, 0     explicit Euler: 0, all
/// so about a fixed principal axis the angle obeys the very formula of the plane. The angular
/// momentum in W grows by T tau to rounding, whatever the body's shape and speed.
inline void turn_body(const SpaceBodyParameters& p, Integrator integrator, double T,
                      const Vec3& torque, Quat& q, Vec3& omega) noexcept {
  const double before = integrator == Integrator::kSemiImplicitEuler ? 1.0
                        : integrator == Integrator::kExplicitEuler   ? 0.0
                                                                     : 0.5;
  const Axes axes = axes_of(q);
  const Vec3 omega_B = axes.to_body(omega);
  const Vec3 momentum = p.inertia * omega_B, impulse = axes.to_body(torque) * T;
  const Quat turn = rotation_by(free_turn(p.inverse_inertia, T, momentum + impulse * before));
  q = normalised(q * turn);

  // The change of omega, seen from where the body was; E is the turn:
  //   E J^-1 E^-1 (m + T tau) - J^-1 m
  // Only the small change is rounded in the products: errors neither of the axes' lengths nor of
  // J J^-1 add up from tick to tick, as they would with omega taken anew from the momentum.
  const Vec3 v{turn.x, turn.y, turn.z};
  const auto turned_away = [&](const Vec3& a, double w) {  // E a - a; E^-1 a - a with -w
    const Vec3 c = cross(v, a);
    return (c * w + cross(v, c)) * 2.0;
  };
  const Vec3 gained = p.inverse_inertia * (impulse + turned_away(momentum + impulse, -turn.w));
  omega += axes.to_world(gained + turned_away(omega_B + gained, turn.w));
}

/// Advances a body by T with the wrench held over the tick. Weight and the compensation of
/// SpaceBodyParameters are added here.
[[nodiscard]] inline SpaceBody step(const SpaceBodyParameters& p, Integrator integrator, double T,
                                    const SpaceBody& now, const SpaceWrench& wrench) noexcept {
  SpaceBody next = now;
  Vec3 force = wrench.force + now.v * p.compensation;
  force.z -= p.weight;
  advance(integrator, T, 0.0, next.p, next.v, force * p.inverse_mass);
  turn_body(p, integrator, T, wrench.torque + now.omega * p.compensation_rotation, next.q,
            next.omega);
  return next;
}

}  // namespace tandem::core
