#pragma once

#include <Eigen/Dense>

#include "analysis/lifted.h"

/// Road (b), the other opinion: the direct multi-rate state space of Araki and Yamamoto (thesis
/// 4.12-4.30 with appendix A), with the corrections of the reference analysis: l_i = T_i / t_lcm
/// and N_i = N_lcm / l_i kept apart in (4.18) and (A.*), (A.9) with l = N_0 for nu = 0 and l = nu
/// l_j otherwise, x_D(k) in (4.21), signs of (4.25)-(4.28) with x_2 turned round. Only tests use
/// it.
namespace tandem::tests {

/// Free masses at one network rate and one control rate; all forces linear in positions and
/// velocities (x1 v1 x2 v2 ...).
struct MultiRate {
  double T = 1.0 / 1024.0;
  int N = 8;
  int d = 0;  ///< packet periods of delay of `late` and `slow`
  std::vector<double> masses;
  Eigen::MatrixXd fast;  ///< forces from the state at the same tick
  Eigen::MatrixXd held;  ///< from the sample of the packet instant, held over the period
  Eigen::MatrixXd late;  ///< from the sample d periods old, held
  Eigen::MatrixXd slow;  ///< forces held over the whole period, from the sample d periods old
};

inline analysis::LiftedSystem araki_yamamoto(const MultiRate& p) {
  using Eigen::MatrixXd;
  const Eigen::Index m = static_cast<Eigen::Index>(p.masses.size()), n = 2 * m, N = p.N;
  // e^{A l T} and the effect of forces held over one tick.
  const auto over = [&](double t) {
    MatrixXd a = MatrixXd::Identity(n, n);
    for (Eigen::Index i = 0; i < m; ++i) a(2 * i, 2 * i + 1) = t;
    return a;
  };
  const auto held_over = [&](double t) {
    MatrixXd b = MatrixXd::Zero(n, m);
    for (Eigen::Index i = 0; i < m; ++i) {
      b(2 * i, i) = t * t / (2 * p.masses[i]);
      b(2 * i + 1, i) = t / p.masses[i];
    }
    return b;
  };
  // (A.1)-(A.5): inputs are N forces of one tick each, then one of N ticks.
  MatrixXd A = MatrixXd::Zero(N * n, N * n), B = MatrixXd::Zero(N * n, (N + 1) * m);
  for (Eigen::Index l = 1; l <= N; ++l) {
    const double t = static_cast<double>(l) * p.T;
    A.block((l - 1) * n, (N - 1) * n, n, n) = over(t);
    for (Eigen::Index mu = 0; mu < l; ++mu)
      B.block((l - 1) * n, mu * m, n, m) =
          over(static_cast<double>(l - mu - 1) * p.T) * held_over(p.T);
    B.block((l - 1) * n, N * m, n, m) = held_over(t);
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
  // (4.21), (4.22): samples of the last d periods are states; forces from outputs and from them.
  const Eigen::Index size = N * n + p.d * n, oldest = N * n + (p.d - 1) * n;
  MatrixXd F = MatrixXd::Zero((N + 1) * m, N * n), G = MatrixXd::Zero((N + 1) * m, size);
  for (Eigen::Index mu = 0; mu < N; ++mu) {
    F.block(mu * m, mu * n, m, n) += p.fast;
    F.block(mu * m, 0, m, n) += p.held;
    if (p.d == 0)
      F.block(mu * m, 0, m, n) += p.late;
    else
      G.block(mu * m, oldest, m, n) += p.late;
  }
  if (p.d == 0)
    F.block(N * m, 0, m, n) += p.slow;
  else
    G.block(N * m, oldest, m, n) += p.slow;
  // (4.30)
  MatrixXd CC = MatrixXd::Zero(N * n, size);
  CC.leftCols(N * n) = Ch;
  const MatrixXd I = MatrixXd::Identity(N * n, N * n);
  const MatrixXd Y = (I - Dh * F).partialPivLu().solve(CC + Dh * G);  // outputs from the state
  const MatrixXd U = F * Y + G;
  MatrixXd M = MatrixXd::Zero(size, size);
  M.topLeftCorner(N * n, N * n) = A;
  M.topRows(N * n) += B * U;
  if (p.d > 0) M.block(N * n, 0, n, size) = Y.topRows(n);
  for (int i = 1; i < p.d; ++i) M.block(N * n + i * n, N * n + (i - 1) * n, n, n).setIdentity();

  analysis::LiftedSystem out;
  out.period = p.N * p.T;
  out.transition = analysis::Matrix(static_cast<int>(size), static_cast<int>(size));
  for (int i = 0; i < size; ++i)
    for (int j = 0; j < size; ++j) out.transition(i, j) = M(i, j);
  analysis::Symmetry t{"translation x", std::vector<double>(size, 0.0),
                       static_cast<std::size_t>((N - 1) * n)};
  for (Eigen::Index i = 0; i < size; i += 2) t.direction[i] = 1.0;
  out.symmetries.push_back(t);
  out.velocities.assign(size, 0.0);
  for (Eigen::Index i = 1; i < size; i += 2) out.velocities[i] = 1.0;
  return out;
}

}  // namespace tandem::tests
