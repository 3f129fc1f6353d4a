#include "analysis/matrix.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include <Eigen/Dense>

namespace tandem::analysis {

namespace {

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

Eigen::Map<const RowMajor> map(const Matrix& a) { return {a.values.data(), a.rows, a.cols}; }

/// The first half of balancing: what nothing else drives, or what drives nothing else, has its
/// diagonal entry as an eigenvalue, exactly. Samples that are overwritten before they are read are
/// such; left in they are Jordan blocks at zero, whose rounding spoils the rest. Returns those
/// eigenvalues and leaves what is not isolated in `a`.
std::vector<double> isolate(Matrix& a) {
  std::vector<double> isolated;
  std::vector<int> kept(static_cast<std::size_t>(a.rows));
  std::iota(kept.begin(), kept.end(), 0);
  const auto alone = [&](int i) {
    bool row = true, column = true;
    for (const int j : kept) {
      row = row && (j == i || a(i, j) == 0.0);
      column = column && (j == i || a(j, i) == 0.0);
    }
    return row || column;
  };
  for (bool changed = true; changed;) {
    changed = false;
    for (std::size_t k = kept.size(); k-- > 0;) {
      if (!alone(kept[k])) continue;
      isolated.push_back(a(kept[k], kept[k]));
      kept.erase(kept.begin() + static_cast<std::ptrdiff_t>(k));
      changed = true;
    }
  }
  if (isolated.empty()) return isolated;
  Matrix rest(static_cast<int>(kept.size()), static_cast<int>(kept.size()));
  for (int i = 0; i < rest.rows; ++i)
    for (int j = 0; j < rest.cols; ++j) rest(i, j) = a(kept[i], kept[j]);
  a = std::move(rest);
  return isolated;
}

/// Osborne's balancing, the second half: a similarity by powers of two, exact, that makes rows and
/// columns alike.
void balance(Matrix& a) {
  for (bool changed = true; changed;) {
    changed = false;
    for (int i = 0; i < a.rows; ++i) {
      double row = 0.0, column = 0.0;
      for (int j = 0; j < a.cols; ++j) {
        if (j == i) continue;
        row += std::abs(a(i, j));
        column += std::abs(a(j, i));
      }
      if (!(row > 0.0) || !(column > 0.0)) continue;
      const int e = static_cast<int>(std::lround(0.5 * std::log2(row / column)));
      const double f = std::ldexp(1.0, e);
      if (e == 0 || column * f + row / f > 0.95 * (row + column)) continue;
      changed = true;
      for (int j = 0; j < a.cols; ++j) a(i, j) /= f;
      for (int j = 0; j < a.cols; ++j) a(j, i) *= f;
    }
  }
}

}  // namespace

std::vector<double> multiply(const Matrix& a, const std::vector<double>& x) {
  std::vector<double> y(static_cast<std::size_t>(a.rows), 0.0);
  for (int i = 0; i < a.rows; ++i)
    for (int j = 0; j < a.cols; ++j)
      if (x[j] != 0.0) y[i] += a(i, j) * x[j];
  return y;
}

Matrix product(const Matrix& a, const Matrix& b) {
  Matrix c(a.rows, b.cols);
  for (int i = 0; i < a.rows; ++i)
    for (int k = 0; k < a.cols; ++k) {
      const double x = a(i, k);
      if (x == 0.0) continue;
      for (int j = 0; j < b.cols; ++j) c(i, j) += x * b(k, j);
    }
  return c;
}

bool all_finite(const Matrix& a) {
  return std::all_of(a.values.begin(), a.values.end(), [](double x) { return std::isfinite(x); });
}

std::vector<std::complex<double>> eigenvalues(Matrix a) {
  if (a.rows == 0) return {};
  if (!all_finite(a))
    return std::vector<std::complex<double>>(a.rows, std::numeric_limits<double>::infinity());
  const std::vector<double> isolated = isolate(a);
  std::vector<std::complex<double>> out(isolated.begin(), isolated.end());
  if (a.rows > 0) {
    balance(a);
    const Eigen::EigenSolver<Eigen::MatrixXd> solver(Eigen::MatrixXd(map(a)), false);
    if (solver.info() != Eigen::Success)
      return std::vector<std::complex<double>>(out.size() + static_cast<std::size_t>(a.rows),
                                               std::numeric_limits<double>::quiet_NaN());
    out.insert(out.end(), solver.eigenvalues().begin(), solver.eigenvalues().end());
  }
  std::sort(out.begin(), out.end(), [](const auto& x, const auto& y) {
    const double ax = std::abs(x), ay = std::abs(y);
    return ax != ay ? ax > ay : x.imag() > y.imag();
  });
  return out;
}

std::vector<double> solve(const Matrix& a, const std::vector<double>& b) {
  // Rows and columns scaled by powers of two: lengths, speeds and forces are alike then.
  Eigen::MatrixXd m = map(a);
  Eigen::VectorXd right = Eigen::Map<const Eigen::VectorXd>(b.data(), a.rows);
  Eigen::VectorXd column = Eigen::VectorXd::Ones(a.cols);
  for (int pass = 0; pass < 3; ++pass) {
    for (int i = 0; i < a.rows; ++i) {
      const double largest = m.row(i).cwiseAbs().maxCoeff();
      if (!(largest > 0.0) || !std::isfinite(largest)) continue;
      const double f = std::ldexp(1.0, -std::ilogb(largest));
      m.row(i) *= f;
      right[i] *= f;
    }
    for (int j = 0; j < a.cols; ++j) {
      const double largest = m.col(j).cwiseAbs().maxCoeff();
      if (!(largest > 0.0) || !std::isfinite(largest)) continue;
      const double f = std::ldexp(1.0, -std::ilogb(largest));
      m.col(j) *= f;
      column[j] *= f;
    }
  }
  const Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> decomposition(m);
  Eigen::VectorXd x = decomposition.solve(right);
  for (int pass = 0; pass < 2; ++pass) x += decomposition.solve(right - m * x);
  std::vector<double> out(a.cols);
  for (int j = 0; j < a.cols; ++j) out[j] = x[j] * column[j];
  return out;
}

std::vector<std::complex<double>> solve_shifted(const Matrix& a, std::complex<double> z,
                                                const std::vector<double>& b) {
  Eigen::MatrixXcd m = -map(a).cast<std::complex<double>>();
  m.diagonal().array() += z;
  const Eigen::VectorXcd right =
      Eigen::Map<const Eigen::VectorXd>(b.data(), a.rows).cast<std::complex<double>>();
  const Eigen::PartialPivLU<Eigen::MatrixXcd> lu(m);
  Eigen::VectorXcd x = lu.solve(right);
  x += lu.solve(right - m * x);
  return {x.data(), x.data() + x.size()};
}

}  // namespace tandem::analysis
