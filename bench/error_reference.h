#pragma once

#include <vector>

#include "bench/error_cases.h"

namespace tandem::bench {

/// The true course of a case at the grid, in extended precision, rounded to doubles at the end:
/// matrix exponentials, closed forms, events found by bisection, and for the spinning body a
/// fourth-order method at `spin_steps` a second. Shares no code with core/.
struct ErrorReference {
  /// What all are compared with: masses, hands, wall, slide, spin as they are declared; stick-slip
  /// with ideal Coulomb friction, which sticks rigidly (Rabinowicz).
  std::vector<double> ideal;
  /// Stick-slip as Tandem's contact law defines it in continuous time, with its tangential spring
  /// and threshold velocity; empty for the other cases.
  std::vector<double> law;
};

/// The exact course of what Tandem's law says: stick-slip in continuous time; masses and hands with
/// the couplers' forces sampled and held at `hz`, the whole network in one matrix exponential (that
/// is what a device does to them); of the other cases the true course.
[[nodiscard]] std::vector<double> law_course(const ErrorPoint& point, const ErrorReference& truth,
                                             int hz);

inline constexpr int kSpinSteps = 1 << 16;

[[nodiscard]] ErrorReference error_reference(const ErrorPoint& point, int spin_steps = kSpinSteps);

/// Ratio of the speeds after and before the bounce, for peers whose contacts are rigid.
[[nodiscard]] double rebound(const ErrorPoint& wall);

/// Distance of a course from the true one: the largest over the grid. Positions in [m], of the
/// spinning body its orientation in [rad]. Not a number or beyond all bounds: infinity.
[[nodiscard]] double error_of(const ErrorPoint& point, const std::vector<double>& samples,
                              const std::vector<double>& truth);

/// Largest difference of the energies over the grid, by the largest true energy [1].
[[nodiscard]] double energy_drift(const ErrorPoint& point, const std::vector<double>& samples,
                                  const std::vector<double>& truth);

}  // namespace tandem::bench
