#include "analysis/matrix_power.h"

#include <algorithm>
#include <cmath>

namespace tandem::analysis {

namespace {

Matrix identity(int n) {
  Matrix m(n, n);
  for (int i = 0; i < n; ++i) m(i, i) = 1.0;
  return m;
}

void shrink(Power& p) {
  double largest = 0.0;
  for (const Matrix* m : {&p.power, &p.sum})
    for (const double x : m->values) largest = std::max(largest, std::abs(x));
  if (!(largest > 1e120) || !std::isfinite(largest)) return;
  const int e = std::ilogb(largest);
  for (Matrix* m : {&p.power, &p.sum})
    for (double& x : m->values) x = std::ldexp(x, -e);
  p.scale += e;
}

}  // namespace

Power power_of(const Matrix& a, int n) {
  const Matrix one = identity(a.rows);
  Power p{one, Matrix(a.rows, a.rows), 0.0};
  for (int bit = 30; bit >= 0; --bit) {
    const auto grow = [&](const Matrix& m, const Matrix& s, const Power& old) {
      // from (A^k, S_k) with A^j, S_j: A^(j+k), S_k + A^k S_j
      return Power{product(old.power, m),
                   [&] {
                     Matrix t = product(old.power, s);
                     // S_k is held at old.scale, S_j unscaled when j = 1.
                     for (std::size_t i = 0; i < t.values.size(); ++i)
                       t.values[i] += old.sum.values[i];
                     return t;
                   }(),
                   old.scale};
    };
    if (p.scale == 0.0 && (n >> bit) > 1) {
      p = grow(p.power, p.sum, p);
    } else if ((n >> bit) > 1) {
      // 2^-s A^k times 2^-s A^k carries 2^-2s; the single sum is 2^s too small beside it.
      Power next{product(p.power, p.power), product(p.power, p.sum), 2.0 * p.scale};
      for (std::size_t i = 0; i < next.sum.values.size(); ++i)
        next.sum.values[i] += std::ldexp(p.sum.values[i], -static_cast<int>(p.scale));
      p = next;
    }
    if ((n >> bit) & 1) p = grow(a, one, p);
    shrink(p);
  }
  return p;
}

}  // namespace tandem::analysis
