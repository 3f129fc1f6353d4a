#include "analysis/response.h"

#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <utility>

namespace tandem::analysis {

namespace {

/// The states that the port reaches or that reach them, for pieces apart make the solve singular.
struct Piece {
  Matrix m;
  std::vector<double> t, push;
  int position = 0, velocity = 0;
};

Piece piece_of(const LiftedSystem& system, const ForcePort& port) {
  const int n = system.states();
  std::vector<int> place(n, -1), kept{port.position};
  place[port.position] = 0;
  for (std::size_t at = 0; at < kept.size(); ++at)
    for (int j = 0; j < n; ++j)
      if (place[j] < 0 &&
          (system.transition(kept[at], j) != 0.0 || system.transition(j, kept[at]) != 0.0)) {
        place[j] = static_cast<int>(kept.size());
        kept.push_back(j);
      }
  const int size = static_cast<int>(kept.size());
  Piece out{Matrix(size, size), {}, {}, 0, place[port.velocity]};
  if (out.velocity < 0) throw std::domain_error(port.name + " moves without its velocity");
  for (int i = 0; i < size; ++i) {
    out.push.push_back(port.push[kept[i]]);
    out.t.push_back(system.symmetries.empty() ? 0.0 : system.symmetries[0].direction[kept[i]]);
    for (int j = 0; j < size; ++j) out.m(i, j) = system.transition(kept[i], kept[j]);
  }
  return out;
}

}  // namespace

FreeMotion free_motion(const LiftedSystem& system, const ForcePort& port) {
  if (system.grounded || system.symmetries.size() != 1)
    throw std::domain_error("no free motion: something holds the scene to the ground");
  const Piece p = piece_of(system, port);
  const int n = p.m.rows;
  // Unknowns: states without the port's position (it stands for the translation), the mean
  // velocity, the force. Equations: the states, and velocity one at the packet instant.
  Matrix a(n + 1, n + 1);
  std::vector<double> right(n + 1, 0.0);
  for (int i = 0; i < n; ++i) {
    for (int j = 1; j < n; ++j) a(i, j - 1) = (i == j ? 1.0 : 0.0) - p.m(i, j);
    a(i, n - 1) = system.period * p.t[i];
    a(i, n) = -p.push[i];
  }
  a(n, p.velocity - 1) = 1.0;
  right[n] = 1.0;
  const std::vector<double> uniform = solve(a, right);
  for (int i = 0; i < n; ++i) right[i] = i == 0 ? 0.0 : -uniform[i - 1];
  right[n] = 0.0;
  const std::vector<double> accelerated = solve(a, right);
  return {uniform[n] / uniform[n - 1], uniform[n], accelerated[n] * system.period};
}

double equivalent_stiffness(const LiftedSystem& system, const ForcePort& port) {
  if (!system.grounded)
    throw std::domain_error("no equivalent stiffness: nothing holds the scene to the ground");
  const Piece p = piece_of(system, port);
  Matrix a = p.m;
  for (int i = 0; i < a.rows; ++i)
    for (int j = 0; j < a.cols; ++j) a(i, j) = (i == j ? 1.0 : 0.0) - a(i, j);
  return 1.0 / solve(a, p.push)[p.position];
}

namespace {

using Complex = std::complex<double>;

std::vector<Complex> step(const PacketPeriod& period, int port, const std::vector<Complex>& x,
                          Complex force) {
  std::vector<Complex> y(static_cast<std::size_t>(period.map.rows));
  for (int i = 0; i < period.map.rows; ++i) {
    y[i] = period.push[port][i] * force;
    for (int j = 0; j < period.map.cols; ++j) y[i] += period.map(i, j) * x[j];
  }
  return y;
}

/// The state X e^{jwt} carried through a repeat of packet periods of different length.
Complex admittance_over_repeat(const LiftedSystem& system, int p, double omega, bool of_position) {
  const ForcePort& port = system.ports[p];
  std::int64_t ticks = 0;
  for (const int k : system.order) ticks += system.periods[k].ticks;
  const double T = system.period / static_cast<double>(ticks);
  const auto carry = [&](std::vector<Complex> x, auto&& use) {
    std::int64_t tick = 0;
    for (const int k : system.order) {
      const Complex phase = std::polar(1.0, omega * T * static_cast<double>(tick));
      use(x, phase);
      x = step(system.periods[k], p, x, phase);
      tick += system.periods[k].ticks;
    }
    return x;
  };
  const std::size_t n = static_cast<std::size_t>(system.states());
  const auto none = [](const std::vector<Complex>&, Complex) {};
  const std::vector<Complex> forced = carry(std::vector<Complex>(n), none);
  std::vector<double> real(n), imaginary(n);
  for (std::size_t i = 0; i < n; ++i) real[i] = forced[i].real(), imaginary[i] = forced[i].imag();
  const Complex z = std::polar(1.0, omega * system.period);
  const auto a = solve_shifted(system.transition, z, real);
  const auto b = solve_shifted(system.transition, z, imaginary);
  std::vector<Complex> x(n);
  for (std::size_t i = 0; i < n; ++i) x[i] = a[i] + Complex(0.0, 1.0) * b[i];
  Complex sum = 0.0;
  const int at = of_position ? port.position : port.velocity;
  carry(x, [&](const std::vector<Complex>& now, Complex phase) { sum += now[at] / phase; });
  return sum / static_cast<double>(system.packets);
}

}  // namespace

Response::Response(const LiftedSystem& system, const ForcePort& port) : period_(system.period) {
  if (system.packets > 1) {
    if (system.order.empty())
      throw std::domain_error("no frequency response: the packet ticks repeat only after " +
                              std::to_string(system.packets) + " packets");
    repeat_ = system;
    const int count = static_cast<int>(system.ports.size());
    while (port_ < count && system.ports[port_].name != port.name) ++port_;
    if (port_ == count) throw std::domain_error("no port " + port.name + " in the measured map");
    return;
  }
  Piece p = piece_of(system, port);
  map_ = std::move(p.m);
  push_ = std::move(p.push);
  position_ = p.position;
  velocity_ = p.velocity;
}

std::complex<double> Response::operator()(double omega, bool of_position) const {
  if (repeat_.packets > 1) return admittance_over_repeat(repeat_, port_, omega, of_position);
  const auto x = solve_shifted(map_, std::polar(1.0, omega * period_), push_);
  return x[of_position ? position_ : velocity_];
}

std::complex<double> admittance(const LiftedSystem& system, const ForcePort& port, double omega,
                                bool of_position) {
  return Response(system, port)(omega, of_position);
}

ForcePort joined(const ForcePort& first, const ForcePort& second) {
  ForcePort out = first;
  for (std::size_t i = 0; i < out.push.size(); ++i) out.push[i] += second.push[i];
  return out;
}

const ForcePort& port_named(const LiftedSystem& system, const std::string& name) {
  std::string known;
  for (const ForcePort& port : system.ports) {
    if (port.name == name) return port;
    known += " " + port.name;
  }
  throw std::invalid_argument("no port " + name + "; there are:" + known);
}

}  // namespace tandem::analysis
