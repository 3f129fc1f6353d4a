#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

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
  constexpr int kGrid = 4096;
  double best = 0.5 * T * (2.0 * delay + 1.0) * stiffness - damping;  // w -> 0
  int at = 0;
  for (int i = 1; i <= kGrid; ++i)
    if (const double b = needed(std::numbers::pi * i / kGrid); b > best) best = b, at = i;
  if (at == 0) return best;
  double low = std::numbers::pi * std::max(at - 1, 1) / kGrid,
         high = std::numbers::pi * std::min(at + 1, kGrid) / kGrid;
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

/// Stiffest passive wall spring [N/m] of a device with damping b beside a virtual damper B, `delay`
/// ticks late: colgate_schenkel_damping turned round, which is convex in K. 0 where even a wall
/// without spring needs more than b.
[[nodiscard]] inline double colgate_schenkel_stiffness(double device_damping, double damping,
                                                       double T, int delay = 0) noexcept {
  const auto passive = [&](double k) {
    return colgate_schenkel_damping(k, damping, T, delay) <= device_damping;
  };
  double low = 0.0, high = 2.0 * device_damping / T;  // no damper and no delay: the most there is
  if (!(device_damping > 0.0) || !passive(0.0)) return 0.0;
  while (passive(high)) low = high, high *= 2.0;
  for (int i = 0; i < 100 && high - low > 1e-13 * high; ++i)
    (passive(0.5 * (low + high)) ? low : high) = 0.5 * (low + high);
  return low;
}

/// Largest stable coupler stiffness between two free masses, exact (3.18): 2 b / T, as long as
/// b < 2 mu / T with the reduced mass mu; else 0 [N/m].
[[nodiscard]] inline double coupled_masses_stiffness(double damping, double mass_a, double mass_b,
                                                     double T) noexcept {
  const double mu = mass_a * mass_b / (mass_a + mass_b);
  return damping < 2.0 * mu / T ? 2.0 * damping / T : 0.0;
}

/// The same with a hand stepped exactly and an object by another integrator, whose position moves
/// by (c T^2 / m) f a tick: c = 1/2 exact, 1 semi-implicit, 0 explicit Euler. From the trace and
/// determinant of the relative motion (Jury): with s = mu (1 / 2 m_h + c / m_o),
///   k < (b / T) / (1 - s)   and   b < 2 mu / T + (1/2 - s) k T.
/// s = 1/2 is 2 b / T; explicit Euler on both would be s = 0, b / T.
[[nodiscard]] inline double coupled_masses_stiffness(double damping, double hand, double object,
                                                     double c, double T) noexcept {
  const double mu = hand * object / (hand + object), s = mu * (0.5 / hand + c / object);
  const double k = damping / T / (1.0 - s);
  // The second condition is linear in k: with s > 1/2 it is an upper limit too.
  if (s <= 0.5) return damping < 2.0 * mu / T + (0.5 - s) * k * T ? k : 0.0;
  const double other = (2.0 * mu / T - damping) / ((s - 0.5) * T);
  return std::max(0.0, std::min(k, other));
}

/// By how much a virtual coupling K + B breaks Llewellyn's criterion of absolute stability, the
/// least over `count` frequencies up to Nyquist of
///   2 b Re(1 / Z_c) - |Z| (1 - cos arg Z),   Z_c = B + K T z / (z - 1),   Z = (z + 1) / 2 z
/// (impedance display, Adams and Hannaford 1999): any passive hand and any passive environment.
/// Divided by (w T / 2)^2, so that the limit of slow motion counts too. Not negative: absolutely
/// stable.
[[nodiscard]] inline double llewellyn_margin(double stiffness, double damping,
                                             double device_damping, double T, int count = 2000) {
  const double s = 0.5 * stiffness * T, r = damping + s;
  // w -> 0 in closed form.
  double least = 2.0 * device_damping * (s > 0.0 ? r / (s * s) : 1e300) - 0.5;
  for (int i = 1; i <= count; ++i) {
    const double x = 0.5 * std::numbers::pi * i / count;  // w T / 2
    const double c = std::cos(x), cot = c / std::sin(x);
    const double real = r / (r * r + s * s * cot * cot);  // Re(1 / Z_c)
    least = std::min(least, (2.0 * device_damping * real - c * (1.0 - c)) / (x * x));
  }
  return least;
}

/// Stiffest absolutely stable virtual coupling with damping B [N/m], by bisection. At most
/// (4 / T) (b + sqrt(b^2 + b B)), which is its limit in slow motion. 0 without device damping, and
/// where the damper alone is too much, B > 8 b: at w T = 2 pi / 3, 1 / B against 1 / 8 b.
[[nodiscard]] inline double llewellyn_stiffness(double damping, double device_damping, double T) {
  const double b = device_damping;
  if (!(b > 0.0)) return 0.0;
  double low = 0.0, high = 4.0 / T * (b + std::sqrt(b * b + b * damping)) * (1.0 + 1e-12);
  for (int i = 0; i < 100 && high - low > 1e-13 * high; ++i) {
    const double k = 0.5 * (low + high);
    (llewellyn_margin(k, damping, b, T) >= 0.0 ? low : high) = k;
  }
  return low;
}

}  // namespace tandem::analysis
