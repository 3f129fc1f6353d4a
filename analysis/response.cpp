#include "analysis/response.h"

#include <cmath>
#include <stdexcept>
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

Response::Response(const LiftedSystem& system, const ForcePort& port) : period_(system.period) {
  Piece p = piece_of(system, port);
  map_ = std::move(p.m);
  push_ = std::move(p.push);
  position_ = p.position;
  velocity_ = p.velocity;
}

std::complex<double> Response::operator()(double omega, bool of_position) const {
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
