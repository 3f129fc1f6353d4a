#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

/// Passivity bounds from the literature for one sampled wall or coupler, beside which the exact
/// answers of lifted.h stand. They ask for passivity: any hand, not this one; so they are narrower.
namespace tandem::analysis {

/// Device damping [N s/m] that a virtual wall K + B (z - 1) / (T z), `delay` ticks late, needs to
/// be passive (Colgate and Schenkel 1997):
///   b > T/2 max_w Re{(1 - e^-jwT) H(e^jwT)} / (1 - cos wT),  0 < w <= pi / T
/// which is K T / 2 + |B| without delay and (2 delay + 1) K T / 2 for a spring. By a grid of 4096
/// frequencies whose best is refined; the limit w -> 0 is taken in closed form.
[[nodiscard]] inline double colgate_schenkel_damping(double stiffness, double damping, double T,
                                                     int delay = 0) noexcept {
  // Re{(1 - e^-ja) (K + B/T (1 - e^-ja)) e^-jda} / (1 - cos a), a = w T.
  const auto needed = [&](double a) {
    const double c = std::cos(a);
    const auto part = [&](int k) { return std::cos(k * a); };
    const double spring = part(delay) - part(delay + 1);
    const double damper = part(delay) - 2.0 * part(delay + 1) + part(delay + 2);
    return 0.5 * T * (stiffness * spring + damping / T * damper) / (1.0 - c);
  };
  constexpr double kPi = 3.14159265358979323846;
  constexpr int kGrid = 4096;
  double best = 0.5 * T * (2.0 * delay + 1.0) * stiffness - damping;  // w -> 0
  int at = 0;
  for (int i = 1; i <= kGrid; ++i)
    if (const double b = needed(kPi * i / kGrid); b > best) best = b, at = i;
  if (at == 0) return best;
  double low = kPi * std::max(at - 1, 1) / kGrid, high = kPi * std::min(at + 1, kGrid) / kGrid;
  for (int i = 0; i < 80; ++i) {
    const double a = low + (high - low) / 3.0, b = high - (high - low) / 3.0;
    if (needed(a) < needed(b))
      low = a;
    else
      high = b;
  }
  return std::max(best, needed(0.5 * (low + high)));
}

/// Stiffest passive spring wall of a device with damping b, Coulomb friction [N] and encoder step
/// [m] (Abbott and Okamura 2005): K <= min(2 b / T, 2 f_c / step) [N/m].
[[nodiscard]] inline double abbott_okamura_stiffness(double device_damping, double friction,
                                                     double encoder_step, double T) noexcept {
  const double quantised =
      encoder_step > 0.0 ? 2.0 * friction / encoder_step : std::numeric_limits<double>::infinity();
  return std::min(2.0 * device_damping / T, quantised);
}

/// Stiffness [N/m] below which a wall delayed by `delay` [s] loses energy in large motions,
/// K (T/2 + delay) <= b, and does not chatter at rest, K step / 2 <= f_c (Diolaiti et al. 2006).
[[nodiscard]] inline double diolaiti_stiffness(double device_damping, double friction,
                                               double encoder_step, double T,
                                               double delay) noexcept {
  const double rest =
      encoder_step > 0.0 ? 2.0 * friction / encoder_step : std::numeric_limits<double>::infinity();
  return std::min(device_damping / (0.5 * T + delay), rest);
}

/// Largest stable coupler stiffness between two free masses, exact (3.18): 2 b / T, as long as
/// b < 2 mu / T with the reduced mass mu; else 0 [N/m].
[[nodiscard]] inline double coupled_masses_stiffness(double damping, double mass_a, double mass_b,
                                                     double T) noexcept {
  const double mu = mass_a * mass_b / (mass_a + mass_b);
  return damping < 2.0 * mu / T ? 2.0 * damping / T : 0.0;
}

}  // namespace tandem::analysis
