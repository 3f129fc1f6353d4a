#pragma once

#include "analysis/matrix.h"

namespace tandem::analysis {

/// A^n and I + A + ... + A^(n-1), both times 2^-scale, by doubling: never by (A - I)^-1, which free
/// motion makes singular. The scale is not zero only where doubles would overflow.
struct Power {
  Matrix power, sum;
  double scale = 0.0;
};

[[nodiscard]] Power power_of(const Matrix& a, int n);

}  // namespace tandem::analysis
