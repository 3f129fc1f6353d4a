#include "analysis/fast_response.h"

#include <stdexcept>
#include <string>

#include "analysis/resampled.h"

namespace tandem::analysis {

namespace {

using Complex = std::complex<double>;

/// x+ = a x + b, in place.
void step(const Matrix& a, std::vector<Complex>& x, const std::vector<Complex>& b) {
  std::vector<Complex> next = b;
  for (int i = 0; i < a.rows; ++i)
    for (int j = 0; j < a.cols; ++j) next[i] += a(i, j) * x[j];
  x = std::move(next);
}

}  // namespace

FastResponse::FastResponse(const core::Scene& scene, const core::NetworkModel& network, int user,
                           int finger)
    : map_(1, 1), body_(-1) {
  LiftedSystem system = resampled_system(scene, network);
  if (system.scale != 0.0) throw std::domain_error("the map overflows: no response exists");
  map_ = std::move(system.transition);
  w_ = workstations_of(scene, network);
  for (std::size_t s = 0; s < w_.sites.size() && body_ < 0; ++s) {
    site_ = static_cast<int>(s);
    body_ = w_.sites[s].of_finger(user, finger);
  }
  if (body_ < 0) throw std::domain_error("no finger " + std::to_string(user));
}

Complex FastResponse::operator()(double omega, bool of_position) const {
  const Workstation& site = w_.sites[site_];
  const int n = site.a.rows;
  const auto turn = [&](int k) { return std::polar(1.0, omega * w_.tick * k); };
  std::vector<Complex> force(n), x(n);
  const auto push = [&](int k) {
    for (int i = 0; i < n; ++i) force[i] = site.external(i, body_) * turn(k);
  };
  for (int k = 0; k < w_.ticks; ++k) {
    push(k);
    step(site.a, x, force);
  }
  // The whole at the packet instant: z X = M X + what the force did in between.
  std::vector<double> real(w_.states, 0.0), imaginary(w_.states, 0.0);
  for (int i = 0; i < n; ++i) {
    real[site.offset + i] = x[i].real();
    imaginary[site.offset + i] = x[i].imag();
  }
  const Complex z = turn(w_.ticks), j(0.0, 1.0);
  const auto a = solve_shifted(map_, z, real), b = solve_shifted(map_, z, imaginary);
  std::vector<Complex> whole(w_.states);
  for (int i = 0; i < w_.states; ++i) whole[i] = a[i] + j * b[i];
  // Through the period once more, now with all that comes in.
  for (int i = 0; i < n; ++i) x[i] = whole[site.offset + i];
  const int seen = 2 * body_ + (of_position ? 0 : 1);
  Complex sum;
  for (int k = 0; k < w_.ticks; ++k) {
    sum += x[seen] * std::conj(turn(k));
    push(k);
    for (const Signal& signal : w_.signals) {
      if (signal.to != site_) continue;
      const std::vector<double> row = w_.value(signal, w_.age(signal, k));
      Complex held;
      for (int i = 0; i < w_.states; ++i) held += row[i] * whole[i];
      held *= w_.factor(signal, k);
      const std::vector<double> pushed = multiply(site.coupled, signal.push);
      for (int i = 0; i < n; ++i) force[i] += pushed[i] * held;
    }
    step(site.a, x, force);
  }
  return sum / static_cast<double>(w_.ticks);
}

}  // namespace tandem::analysis
