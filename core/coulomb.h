#pragma once

#include <cmath>

#include "core/components.h"

namespace tandem::core {

/// Coulomb friction as an impulse after a tick without it: takes at most `impulse_limit` / m = `loss`
/// from the speed, never more than there is, so a body at rest stays exactly at rest while the
/// force on it is below the limit, and one that slides stops inside the tick without reversing.
/// The position is corrected with the mean of the two velocities.
template <typename V>
inline void rub(double T, double loss, V& x, V& v) noexcept {
  const double speed = std::sqrt(inner(v, v));
  const V before = v;
  v = speed <= loss ? V{0.0} : v * (1.0 - loss / speed);
  x += (v - before) * (0.5 * T);
}

}  // namespace tandem::core
