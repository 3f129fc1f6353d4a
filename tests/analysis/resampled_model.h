#pragma once

#include <complex>
#include <vector>

#include <Eigen/Dense>

/// The axis scenes of two users as matrices over one packet period, written down independently of
/// the laws: zero-order-hold discretisation (3.14-3.15), resampling by recursive sums instead of
/// (4.4)'s inverse, delay by augmentation, closed as in (4.7), (4.10); signs of (4.25)-(4.28)
/// with x2 turned round. Only tests use it: it is the other opinion.
namespace tandem::tests {

using Matrix = Eigen::MatrixXd;

struct TwoUsers {
  double T = 1.0 / 1024.0;
  int N = 8;
  int d = 0;  ///< round trip [packet periods]
  double m1 = 0.1, m2 = 0.1, mo = 0.4;
  double compensation = 0.0;
};
struct Spring {
  double k = 0.0, b = 0.0;
};

/// Free masses: states (x, v) each, one force each.
inline void free_masses(const std::vector<double>& masses, double T, Matrix& A, Matrix& B) {
  const auto n = static_cast<Eigen::Index>(masses.size());
  A = Matrix::Identity(2 * n, 2 * n);
  B = Matrix::Zero(2 * n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    A(2 * i, 2 * i + 1) = T;
    B(2 * i, i) = T * T / (2 * masses[i]);
    B(2 * i + 1, i) = T / masses[i];
  }
}

/// x+ = A x + B u held for N steps.
inline void resample(Matrix& A, Matrix& B, int N) {
  Matrix power = Matrix::Identity(A.rows(), A.cols()), sum = Matrix::Zero(A.rows(), A.cols());
  for (int i = 0; i < N; ++i) {
    sum += power;
    power = (power * A).eval();
  }
  B = (sum * B).eval();
  A = power;
}

/// Largest eigenvalue modulus after removing the translation t (t[pivot] = 1) exactly.
inline double deflated_radius(const Matrix& M, const Eigen::VectorXd& t, Eigen::Index pivot) {
  const Eigen::Index n = M.rows();
  Matrix R(n - 1, n - 1);
  for (Eigen::Index i = 0, r = 0; i < n; ++i) {
    if (i == pivot) continue;
    for (Eigen::Index j = 0, c = 0; j < n; ++j) {
      if (j == pivot) continue;
      R(r, c++) = M(i, j) - t[i] * M(pivot, j);
    }
    ++r;
  }
  return Eigen::EigenSolver<Matrix>(R, false).eigenvalues().cwiseAbs().maxCoeff();
}

/// Distributed: each site (h, o) with inputs (h_other, o_other); all delay on link 1 to 2.
inline double distributed_radius(const TwoUsers& p, Spring k11, Spring k22, Spring k12, Spring k21,
                                 Spring ko) {
  const auto site = [&](double mh, Spring own, Spring other, Matrix& A, Matrix& B) {
    Matrix F;
    free_masses({mh, p.mo}, p.T, A, F);
    Matrix state(2, 4), input(2, 4);  // forces on (h, o) by (xh vh xo vo) and by the inputs
    state << -own.k, -own.b, own.k, own.b, own.k, own.b, -own.k - other.k - ko.k,
        -own.b - other.b - ko.b + p.compensation;
    input << 0, 0, 0, 0, other.k, other.b, ko.k, ko.b;
    A = (A + F * state).eval();
    B = F * input;
    resample(A, B, p.N);
  };
  Matrix A1, B1, A2, B2;
  site(p.m1, k11, k12, A1, B1);
  site(p.m2, k22, k21, A2, B2);
  // State: site 1, site 2, then d packets (h1, o1) in flight, newest first.
  const Eigen::Index n = 8 + 4 * p.d;
  Matrix M = Matrix::Zero(n, n);
  M.block(0, 0, 4, 4) = A1;
  M.block(0, 4, 4, 4) = B1;
  M.block(4, 4, 4, 4) = A2;
  if (p.d == 0) {
    M.block(4, 0, 4, 4) = B2;
  } else {
    M.block(4, 8 + 4 * (p.d - 1), 4, 4) = B2;
    M.block(8, 0, 4, 4) = Matrix::Identity(4, 4);
    for (int i = 1; i < p.d; ++i) M.block(8 + 4 * i, 4 + 4 * i, 4, 4) = Matrix::Identity(4, 4);
  }
  Eigen::VectorXd t = Eigen::VectorXd::Zero(n);
  for (Eigen::Index i = 0; i < n; i += 2) t[i] = 1.0;
  return deflated_radius(M, t, 0);
}

/// Centralized: server with h1 and o, remote h2 whose force, sampled once a packet period, comes
/// back d packets late.
inline double central_radius(const TwoUsers& p, Spring k1, Spring k2) {
  Matrix A, F;
  free_masses({p.m1, p.mo}, p.T, A, F);
  Matrix state(2, 4), input(2, 2);
  state << -k1.k, -k1.b, k1.k, k1.b, k1.k, k1.b, -k1.k - k2.k, -k1.b - k2.b + p.compensation;
  input << 0, 0, k2.k, k2.b;
  A = (A + F * state).eval();
  Matrix B = F * input;
  resample(A, B, p.N);
  Matrix Ar, Br;
  free_masses({p.m2}, p.N * p.T, Ar, Br);
  // Force on the remote hand: -K2 (h2 - o), of d periods ago.
  const Eigen::Index n = 6 + p.d;
  Eigen::RowVectorXd force = Eigen::RowVectorXd::Zero(n);
  force[2] = k2.k, force[3] = k2.b, force[4] = -k2.k, force[5] = -k2.b;
  Matrix M = Matrix::Zero(n, n);
  M.block(0, 0, 4, 4) = A;
  M.block(0, 4, 4, 2) = B;
  M.block(4, 4, 2, 2) = Ar;
  if (p.d == 0) {
    M.block(4, 0, 2, n) += Br * force;
  } else {
    M.block(4, 6 + p.d - 1, 2, 1) = Br;
    M.row(6) = force;
    for (int i = 1; i < p.d; ++i) M(6 + i, 5 + i) = 1.0;
  }
  Eigen::VectorXd t = Eigen::VectorXd::Zero(n);
  t[0] = t[2] = t[4] = 1.0;
  return deflated_radius(M, t, 0);
}

}  // namespace tandem::tests
