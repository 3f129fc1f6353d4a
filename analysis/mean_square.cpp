#include "analysis/mean_square.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tandem::analysis {

namespace {

constexpr int kMostDense = 300;  ///< eigenvalues of such a matrix take a fraction of a second

Matrix transposed(const Matrix& a) {
  Matrix t(a.cols, a.rows);
  for (int i = 0; i < a.rows; ++i)
    for (int j = 0; j < a.cols; ++j) t(j, i) = a(i, j);
  return t;
}

double trace(const std::vector<Matrix>& x) {
  double sum = 0.0;
  for (const Matrix& m : x)
    for (int i = 0; i < m.rows; ++i) sum += m(i, i);
  return sum;
}

/// Powers of two, one a state, that make the maps' rows and columns alike: positions, velocities
/// and forces differ by thousands, and the iteration would lose digits. One a mode and state.
std::vector<std::vector<double>> balance(const JumpSystem& system) {
  std::vector<std::vector<double>> scale;
  for (const int n : system.states) scale.emplace_back(static_cast<std::size_t>(n), 1.0);
  for (int sweep = 0; sweep < 20; ++sweep) {
    std::vector<std::vector<double>> in, out;  // what a state gets, and gives
    for (const int n : system.states) {
      in.emplace_back(static_cast<std::size_t>(n), 0.0);
      out.emplace_back(static_cast<std::size_t>(n), 0.0);
    }
    for (const JumpSystem::Jump& jump : system.jumps) {
      const Matrix& a = system.maps[jump.map];
      for (int i = 0; i < a.rows; ++i)
        for (int j = 0; j < a.cols; ++j) {
          if (i == j && jump.from == jump.to) continue;
          const double x =
              std::abs(a(i, j)) * scale[jump.from][j] / scale[jump.to][i] * jump.probability;
          in[jump.to][i] += x;
          out[jump.from][j] += x;
        }
    }
    bool changed = false;
    for (std::size_t m = 0; m < scale.size(); ++m)
      for (std::size_t i = 0; i < scale[m].size(); ++i) {
        if (!(in[m][i] > 0.0) || !(out[m][i] > 0.0)) continue;
        const int e = static_cast<int>(std::lround(0.5 * std::log2(in[m][i] / out[m][i])));
        scale[m][i] = std::ldexp(scale[m][i], e);
        changed = changed || e != 0;
      }
    if (!changed) break;
  }
  return scale;
}

JumpSystem balanced(const JumpSystem& system) {
  const auto scale = balance(system);
  JumpSystem out = system;
  out.maps.clear();
  for (JumpSystem::Jump& jump : out.jumps) {
    Matrix a = system.maps[jump.map];
    for (int i = 0; i < a.rows; ++i)
      for (int j = 0; j < a.cols; ++j) a(i, j) *= scale[jump.from][j] / scale[jump.to][i];
    jump.map = static_cast<int>(out.maps.size());
    out.maps.push_back(std::move(a));
  }
  return out;
}

/// The half-vectorised Kronecker matrix: column for column what one jump makes of E_ij + E_ji.
double dense_radius(const JumpSystem& system, int size) {
  std::vector<int> offset{0};
  for (const int n : system.states) offset.push_back(offset.back() + n * (n + 1) / 2);
  const auto place = [](int i, int j) {
    return i >= j ? i * (i + 1) / 2 + j : j * (j + 1) / 2 + i;
  };
  Matrix k(size, size);
  for (const JumpSystem::Jump& jump : system.jumps) {
    const Matrix& a = system.maps[jump.map];
    for (int i = 0; i < a.rows; ++i)
      for (int j = 0; j <= i; ++j) {
        const int row = offset[jump.to] + place(i, j);
        for (int p = 0; p < a.cols; ++p)
          for (int q = 0; q <= p; ++q) {
            double x = a(i, p) * a(j, q);
            if (p != q) x += a(i, q) * a(j, p);
            k(row, offset[jump.from] + place(p, q)) += jump.probability * x;
          }
      }
  }
  const auto found = eigenvalues(std::move(k));
  return found.empty() ? 0.0 : std::abs(found.front());
}

}  // namespace

std::vector<Matrix> advance_second_moment(const JumpSystem& system,
                                          const std::vector<Matrix>& before) {
  std::vector<Matrix> after;
  for (const int n : system.states) after.emplace_back(n, n);
  for (const JumpSystem::Jump& jump : system.jumps) {
    const Matrix& a = system.maps[jump.map];
    const Matrix y = product(product(a, before[jump.from]), transposed(a));
    Matrix& sum = after[jump.to];
    for (std::size_t i = 0; i < sum.values.size(); ++i)
      sum.values[i] += jump.probability * y.values[i];
  }
  return after;
}

SecondMoment second_moment(const JumpSystem& given) {
  SecondMoment out;
  for (const int n : given.states) out.size += n * (n + 1) / 2;
  for (const Matrix& m : given.maps)
    if (!all_finite(m)) {
      out.radius = std::numeric_limits<double>::infinity();
      return out;
    }
  const JumpSystem system = balanced(given);
  if (out.size <= kMostDense) {
    out.dense = true;
    out.radius = dense_radius(system, out.size);
    return out;
  }
  std::vector<Matrix> x;
  for (const int n : system.states) {
    x.emplace_back(n, n);
    for (int i = 0; i < n; ++i) x.back()(i, i) = 1.0;
  }
  constexpr int kMost = 20000, kSteady = 20;
  double previous = 0.0;
  int steady = 0;
  while (out.iterations < kMost) {
    double growth = 1.0;  // over one period of the chain
    for (int k = 0; k < system.period; ++k) {
      const double before = trace(x);
      x = advance_second_moment(system, x);
      const double after = trace(x);
      growth *= after / before;
      ++out.iterations;
      if (after == 0.0) return out;  // everything dies out
      for (Matrix& m : x)
        for (double& v : m.values) v /= after;
    }
    out.radius = std::pow(growth, 1.0 / system.period);
    steady = std::abs(out.radius - previous) <= 1e-10 * out.radius / system.period ? steady + 1 : 0;
    if (steady == kSteady) return out;
    previous = out.radius;
  }
  out.converged = false;
  return out;
}

}  // namespace tandem::analysis
