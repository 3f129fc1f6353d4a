#pragma once

#include <complex>
#include <vector>

namespace tandem::analysis {

/// Dense real matrix, rows one after the other. Plain, so that only .cpp files need Eigen.
struct Matrix {
  int rows = 0, cols = 0;
  std::vector<double> values;

  Matrix() = default;
  Matrix(int r, int c) : rows(r), cols(c), values(static_cast<std::size_t>(r) * c, 0.0) {}

  [[nodiscard]] double& operator()(int r, int c) {
    return values[static_cast<std::size_t>(r) * cols + c];
  }
  [[nodiscard]] double operator()(int r, int c) const {
    return values[static_cast<std::size_t>(r) * cols + c];
  }
};

[[nodiscard]] std::vector<double> multiply(const Matrix& a, const std::vector<double>& x);
[[nodiscard]] Matrix product(const Matrix& a, const Matrix& b);
[[nodiscard]] bool all_finite(const Matrix& a);

/// Eigenvalues of a square matrix, balanced first by powers of two so that the units of its states
/// do not matter; largest modulus first. Not finite where the matrix is not.
[[nodiscard]] std::vector<std::complex<double>> eigenvalues(Matrix a);

/// x with a x = b (least squares, smallest, where a is singular or not square).
[[nodiscard]] std::vector<double> solve(const Matrix& a, const std::vector<double>& b);

/// x with (z I - a) x = b.
[[nodiscard]] std::vector<std::complex<double>> solve_shifted(const Matrix& a,
                                                              std::complex<double> z,
                                                              const std::vector<double>& b);

}  // namespace tandem::analysis
