#include <cmath>
#include <numbers>

#include "analysis/lifted.h"

namespace tandem::analysis {

namespace {

using Complex = std::complex<double>;

/// Phase by which the hands' velocities turn over a repeat, counted from packet to packet.
double turned(const LiftedSystem& system, std::vector<Complex> x) {
  double sum = 0.0;
  for (const int k : system.order) {
    const Matrix& m = system.periods[k].map;
    std::vector<Complex> next(static_cast<std::size_t>(m.rows));
    for (int i = 0; i < m.rows; ++i)
      for (int j = 0; j < m.cols; ++j) next[i] += m(i, j) * x[j];
    Complex overlap = 0.0;
    for (const ForcePort& port : system.ports)
      overlap += next[port.velocity] * std::conj(x[port.velocity]);
    sum += std::arg(overlap);
    x = std::move(next);
  }
  return sum;
}

}  // namespace

std::vector<Complex> packet_modes(const LiftedSystem& system, const Judgement& judged) {
  if (system.packets == 1) return judged.eigenvalues;
  std::vector<Complex> modes;
  constexpr double kTurn = 2.0 * std::numbers::pi;
  const double share = 1.0 / system.packets;
  for (const Complex& z : judged.eigenvalues) {
    const double modulus = std::pow(std::abs(z), share);
    double angle = std::arg(z);
    if (!system.order.empty() && std::abs(z) > 0.0 && z.imag() != 0.0) {
      // An eigenvector by one step of inverse iteration, so near that one is enough.
      std::vector<double> start(static_cast<std::size_t>(system.states()));
      for (std::size_t i = 0; i < start.size(); ++i)
        start[i] = 1.0 / (1.0 + static_cast<double>(i));
      const auto vector = solve_shifted(system.transition, z * (1.0 + 1e-10), start);
      angle += kTurn * std::round((turned(system, vector) - angle) / kTurn);
    }
    modes.push_back(std::polar(modulus, angle * share));
  }
  return modes;
}

}  // namespace tandem::analysis
