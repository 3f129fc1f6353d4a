#pragma once

#include <complex>

#include "analysis/lifted.h"

/// What a hand feels, from the lifted map: exact solves, no limit taken numerically.
namespace tandem::analysis {

/// Slow free motion: F = (damping) v + (inertia) dv/dt.
struct FreeMotion {
  double mean_damping = 0.0;  ///< against the mean velocity over a packet period [N s/m]
  /// Against the velocity at packet instants, thesis (6.2); at the first of a repeat [N s/m].
  double sampled_damping = 0.0;
  double inertia = 0.0;  ///< second order of the same expansion [kg]
};

/// (6.2) by a bordered solve: the periodic solution that moves on by T_t a period under a constant
/// force f, (M - I) X + B f = T_t t with the translation fixed. Also where the scene is unstable or
/// the damping negative. Throws std::domain_error where something holds the scene to the ground.
[[nodiscard]] FreeMotion free_motion(const LiftedSystem& system, const ForcePort& port);

/// Force over displacement at rest under a constant force, of a scene held to the ground [N/m].
[[nodiscard]] double equivalent_stiffness(const LiftedSystem& system, const ForcePort& port);

/// V/F and X/F (6.1) of one port over any number of frequencies.
class Response {
 public:
  Response(const LiftedSystem& system, const ForcePort& port);
  /// V/F at `omega` [rad/s], force held over and velocity sampled once a packet period; X/F with
  /// `of_position`. Where packet periods differ in length the answer to e^{jwt} has side bands;
  /// this is its part at omega itself, the mean of v(t_k) e^{-jw t_k} over a repeat.
  [[nodiscard]] std::complex<double> operator()(double omega, bool of_position = false) const;

 private:
  Matrix map_;
  std::vector<double> push_;
  int position_ = 0, velocity_ = 0;
  double period_ = 0.0;
  LiftedSystem repeat_;  ///< where packet periods differ; else empty
  int port_ = 0;         ///< its place in there
};

/// One value of a Response.
[[nodiscard]] std::complex<double> admittance(const LiftedSystem& system, const ForcePort& port,
                                              double omega, bool of_position = false);

/// Push on several ports at once, felt at the first.
[[nodiscard]] ForcePort joined(const ForcePort& first, const ForcePort& second);
/// The port with this name; throws std::invalid_argument.
[[nodiscard]] const ForcePort& port_named(const LiftedSystem& system, const std::string& name);

}  // namespace tandem::analysis
