#pragma once

#include <complex>
#include <string>
#include <vector>

#include "analysis/lifted.h"
#include "core/scene.h"

/// What a user feels who holds an object with all fingers: along x on an axis; along x and y and in
/// rotation in a plane. Exact solves on the lifted map, as in response.h for one finger.
namespace tandem::analysis {

/// One axis of a grasp. A force of one newton is shared by the user's fingers evenly; a torque of
/// one newton metre about the object's centre by forces across their arms. The motion is the one
/// that this force does work on: the mean of the fingers, the turning that fits their motion best.
struct GraspAxis {
  std::string name;              ///< "x", "y", "rotation"
  std::vector<double> push;      ///< change of every state over a period by the force held
  std::vector<double> position;  ///< motion = position . state, [m] or [rad]
  std::vector<double> velocity;  ///< the same of velocities
  std::vector<double> rigid;     ///< everything moved by one metre, or turned by one radian
  [[nodiscard]] bool turns() const { return name == "rotation"; }
};

/// Of `user` (index) around object `object`. Throws std::domain_error where the scene does not
/// move freely or a rotation has no arm.
[[nodiscard]] std::vector<GraspAxis> grasp_axes(const LiftedSystem& system,
                                                const core::Scene& scene, int user, int object);

/// The same with the force on every copy of the object itself, no hands: the simplified model of
/// thesis Fig 6.3. `system` must be resampled: those have ports of objects.
[[nodiscard]] std::vector<GraspAxis> object_axes(const LiftedSystem& system,
                                                 const core::Scene& scene, int object);

/// Slow free motion: F = damping v + inertia dv/dt, matrices over the axes (rows: forces).
struct FeltMotion {
  Matrix mean_damping;     ///< against the mean velocity [N s/m, N m s/rad]
  Matrix sampled_damping;  ///< against the velocity at packet instants, thesis (6.2)
  Matrix inertia;          ///< second order of the sampled expansion [kg, kg m^2]
};

/// (6.2) for all axes at once by a bordered solve: (M - I) X + B f = T_t r for each rigid motion r.
/// Also where the scene is unstable. Diagonal entries are the force along an axis in pure motion
/// along it; the others hold the remaining axes straight.
[[nodiscard]] FeltMotion felt_motion(const LiftedSystem& system,
                                     const std::vector<GraspAxis>& axes);

/// V/F (6.1) of one axis at `omega` [rad/s], the other axes free; X/F with `of_position`.
[[nodiscard]] std::complex<double> admittance(const LiftedSystem& system, const GraspAxis& axis,
                                              double omega, bool of_position = false);

}  // namespace tandem::analysis
