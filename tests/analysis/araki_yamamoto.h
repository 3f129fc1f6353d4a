#pragma once

#include <cmath>
#include <vector>

#include <Eigen/Dense>

#include "analysis/lifted.h"

/// Road (b), the other opinion: the direct multi-rate state space of Araki and Yamamoto (thesis
/// 4.12-4.30 with appendix A), with the corrections of the reference analysis: l_i = T_i / t_lcm
/// and N_i = N_lcm / l_i kept apart in (4.18) and (A.*), (A.9) with l = N_0 for nu = 0 and l = nu
/// l_j otherwise, x_D(k) in (4.21), signs of (4.25)-(4.28) with x_2 turned round. Only tests use
/// it.
namespace tandem::tests {

/// Forces linear in positions and velocities (x1 v1 x2 v2 ...) of samples taken at packet instants.
struct HeldForce {
  int delay_ticks = 0;   ///< from the instant to the first tick that uses it
  int periods_late = 0;  ///< the sample was that old already when it was sent (a server's reply)
  Eigen::MatrixXd force;
};

/// What a held force does to one mass: its last values are states, newest first.
struct KeptForce {
  const HeldForce* from;
  Eigen::Index mass;
  Eigen::Index first;
};

/// Masses at one network rate and one control rate.
struct MultiRate {
  double T = 1.0 / 1024.0;
  int N = 8;
  std::vector<double> masses;
  std::vector<double> ground_k, ground_b;  ///< springs and dampers to the ground, continuous
  Eigen::MatrixXd fast;                    ///< forces from the state at the same tick
  std::vector<HeldForce> held;
  bool grounded = false;
};

/// [x v]+ = A [x v] + B f of one mass over t: exponential of [[0 1 0][-k/m -b/m 1/m][0 0 0]].
inline Eigen::Matrix3d one_mass_over(double t, double m, double k, double b) {
  Eigen::Matrix3d a = Eigen::Matrix3d::Zero();
  a(0, 1) = 1.0;
  a(1, 0) = -k / m, a(1, 1) = -b / m, a(1, 2) = 1.0 / m;
  const Eigen::Matrix3d step = a * (t / 64.0);
  Eigen::Matrix3d sum = Eigen::Matrix3d::Identity(), term = sum;
  for (int i = 1; i < 20; ++i) sum += term = (term * step / i).eval();
  for (int i = 0; i < 6; ++i) sum = (sum * sum).eval();
  return sum;
}

inline analysis::LiftedSystem araki_yamamoto(const MultiRate& p) {
  using Eigen::MatrixXd;
  const Eigen::Index m = static_cast<Eigen::Index>(p.masses.size()), n = 2 * m, N = p.N;
  // e^{A l T} and the effect of forces held over one tick.
  const auto over = [&](double t) {
    MatrixXd a = MatrixXd::Zero(n, n);
    for (Eigen::Index i = 0; i < m; ++i)
      a.block(2 * i, 2 * i, 2, 2) =
          one_mass_over(t, p.masses[i], p.ground_k[i], p.ground_b[i]).topLeftCorner(2, 2);
    return a;
  };
  MatrixXd tick = MatrixXd::Zero(n, m);
  for (Eigen::Index i = 0; i < m; ++i)
    tick.block(2 * i, i, 2, 1) =
        one_mass_over(p.T, p.masses[i], p.ground_k[i], p.ground_b[i]).topRightCorner(2, 1);
  // (A.1)-(A.5): inputs are N forces of one tick each.
  MatrixXd A = MatrixXd::Zero(N * n, N * n), B = MatrixXd::Zero(N * n, N * m);
  for (Eigen::Index l = 1; l <= N; ++l) {
    A.block((l - 1) * n, (N - 1) * n, n, n) = over(static_cast<double>(l) * p.T);
    for (Eigen::Index mu = 0; mu < l; ++mu)
      B.block((l - 1) * n, mu * m, n, m) = over(static_cast<double>(l - mu - 1) * p.T) * tick;
  }
  // (4.18)-(4.20): outputs at ticks 0 .. N-1; tick 0 is the last block of the old state.
  MatrixXd U1 = MatrixXd::Identity(N * n, N * n), U2 = MatrixXd::Zero(N * n, N * n),
           C(N * n, N * n);
  U1.bottomRightCorner(n, n).setZero();
  U2.bottomRightCorner(n, n).setIdentity();
  C.setZero();
  C.block(0, (N - 1) * n, n, n).setIdentity();
  for (Eigen::Index nu = 1; nu < N; ++nu) C.block(nu * n, (nu - 1) * n, n, n).setIdentity();
  const MatrixXd Ch = C * U1 * A + C * U2, Dh = C * U1 * B;
  // (4.21), (4.22): packet samples of the last periods are states; forces from outputs and them.
  const auto age = [&](const HeldForce& h, Eigen::Index mu) {  // of the sample used [periods]
    const int behind = h.delay_ticks - static_cast<int>(mu);
    return (behind > 0 ? (behind + p.N - 1) / p.N : 0) + h.periods_late;
  };
  // What is kept of a sample is the force it makes, one number a held force and mass: position and
  // velocity kept apart, but only used together, leave a Jordan block at zero as long as the delay,
  // whose rounding spoils the other eigenvalues.
  Eigen::Index size = N * n;
  std::vector<KeptForce> kept;
  for (const HeldForce& h : p.held)
    for (Eigen::Index i = 0; i < m; ++i) {
      if (age(h, 0) == 0 || h.force.row(i).isZero(0.0)) continue;
      kept.push_back({&h, i, size});
      size += age(h, 0);
    }
  MatrixXd F = MatrixXd::Zero(N * m, N * n), G = MatrixXd::Zero(N * m, size);
  for (Eigen::Index mu = 0; mu < N; ++mu) {
    F.block(mu * m, mu * n, m, n) += p.fast;
    for (const HeldForce& h : p.held)
      if (age(h, mu) == 0) F.block(mu * m, 0, m, n) += h.force;
    for (const KeptForce& k : kept)
      if (const int old = age(*k.from, mu); old > 0) G(mu * m + k.mass, k.first + old - 1) = 1.0;
  }
  // (4.30)
  MatrixXd CC = MatrixXd::Zero(N * n, size);
  CC.leftCols(N * n) = Ch;
  // No tick feels a later one: I - D F is triangular, and solved tick by tick.
  const MatrixXd loop = MatrixXd::Identity(N * n, N * n) - Dh * F;
  const MatrixXd Y = loop.triangularView<Eigen::UnitLower>().solve(CC + Dh * G);  // outputs
  const MatrixXd U = F * Y + G;
  MatrixXd M = MatrixXd::Zero(size, size);
  M.topLeftCorner(N * n, N * n) = A;
  M.topRows(N * n) += B * U;
  for (const KeptForce& k : kept) {
    M.row(k.first) = k.from->force.row(k.mass) * Y.topRows(n);
    for (int i = 1; i < age(*k.from, 0); ++i) M(k.first + i, k.first + i - 1) = 1.0;
  }

  analysis::LiftedSystem out;
  out.period = p.N * p.T;
  out.grounded = p.grounded;
  out.transition = analysis::Matrix(static_cast<int>(size), static_cast<int>(size));
  for (int i = 0; i < size; ++i)
    for (int j = 0; j < size; ++j) out.transition(i, j) = M(i, j);
  analysis::Symmetry t{"translation x", std::vector<double>(size, 0.0),
                       static_cast<std::size_t>((N - 1) * n)};
  for (Eigen::Index i = 0; i < N * n; i += 2) t.direction[i] = 1.0;
  for (const KeptForce& k : kept)
    for (int i = 0; i < age(*k.from, 0); ++i)
      t.direction[k.first + i] =
          Eigen::Map<const Eigen::VectorXd>(t.direction.data(), n).dot(k.from->force.row(k.mass));
  out.symmetries.push_back(t);
  out.velocities.assign(size, 0.0);
  for (Eigen::Index i = 1; i < N * n; i += 2) out.velocities[i] = 1.0;
  return out;
}

/// Force on mass `on` from the state of mass `at`: sign (k x + b v).
inline void pull(Eigen::MatrixXd& f, int on, int at, const core::Gain& g, double sign) {
  f(on, 2 * at) += sign * g.stiffness;
  f(on, 2 * at + 1) += sign * g.damping;
}

/// Any linear axis scene with one object, one finger a user, walls on the object, forces at the
/// tick: written down from the thesis's figures, not from the laws.
inline MultiRate multi_rate_of(const core::Scene& s, const core::NetworkModel& network) {
  using core::Architecture;
  MultiRate p;
  p.T = s.tick();
  p.N = s.most_ticks_per_packet();  // whole ratios only
  const int users = static_cast<int>(s.users.size());
  const bool central = s.architecture == Architecture::kCentral;
  const int copies = central ? 1 : users;
  const double mass =
      s.objects[0].mass / (s.architecture == Architecture::kDistributedSplit ? 1.0 * users : 1.0);
  const auto copy = [&](int i) { return users + (central ? 0 : i); };
  for (const auto& u : s.users) {  // hands first, then copies
    p.masses.push_back(u.mass);
    p.ground_k.push_back(u.fingers[0].hand.stiffness);
    p.ground_b.push_back(u.fingers[0].hand.damping + u.fingers[0].damping);
    p.grounded = p.grounded || u.fingers[0].hand.stiffness > 0.0;
  }
  const int all = users + copies;
  p.fast = Eigen::MatrixXd::Zero(all, 2 * all);
  for (int i = 0; i < copies; ++i) {
    p.masses.push_back(mass);
    p.ground_k.push_back(0.0);
    p.ground_b.push_back(0.0);
    pull(p.fast, copy(i), copy(i), {0.0, s.objects[0].compensation}, 1.0);
    for (const auto& w : s.walls) pull(p.fast, copy(i), copy(i), w.gain, -1.0);
  }
  p.grounded = p.grounded || !s.walls.empty();
  const auto held = [&](double delay, int late) -> Eigen::MatrixXd& {
    p.held.push_back(
        {static_cast<int>(std::ceil(delay)), late, Eigen::MatrixXd::Zero(all, 2 * all)});
    return p.held.back().force;
  };
  constexpr int kServer = core::NetworkModel::kServer;
  for (const auto& c : s.couplers) {
    const int j = core::index_of(s.users, c.user);
    if (central) {
      const int o = copy(0);
      pull(p.fast, o, o, c.gain, -1.0);
      if (s.users[j].local) {
        pull(p.fast, o, j, c.gain, 1.0), pull(p.fast, j, o, c.gain, 1.0);
        pull(p.fast, j, j, c.gain, -1.0);
        continue;
      }
      const double up = std::ceil(network.link[j][kServer].delay_ticks),
                   down = network.link[kServer][j].delay_ticks;
      const int replied = (static_cast<int>(up) + p.N - 1) / p.N;
      pull(held(up, 0), o, j, c.gain, 1.0);
      pull(held(down, 0), j, o, c.gain, 1.0);
      pull(held(down, replied), j, j, c.gain, -1.0);
      continue;
    }
    const int i = core::index_of(s.users, c.copy), o = copy(i);
    if (c.user.empty()) {
      for (int other = 0; other < users; ++other) {
        if (other == i) continue;
        pull(p.fast, o, o, c.gain, -1.0);
        pull(held(network.link[other][i].delay_ticks, 0), o, copy(other), c.gain, 1.0);
      }
      continue;
    }
    pull(p.fast, o, o, c.gain, -1.0);
    if (i == j) {
      pull(p.fast, o, j, c.gain, 1.0), pull(p.fast, j, o, c.gain, 1.0);
      pull(p.fast, j, j, c.gain, -1.0);
    } else {
      pull(held(network.link[j][i].delay_ticks, 0), o, j, c.gain, 1.0);
    }
  }
  return p;
}

}  // namespace tandem::tests
