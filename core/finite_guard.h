#pragma once

#include <cmath>

#include "core/components.h"
#include "core/fault.h"

namespace tandem::core {

template <typename V>
[[nodiscard]] inline bool is_finite(const V& x) noexcept {
  for (int i = 0; i < kComponents<V>; ++i)
    if (!std::isfinite(component(x, i))) return false;
  return true;
}

/// The value itself if all of it is finite, otherwise zero (all of it: half a vector is a wrong
/// direction) and Fault::kNotFinite. V is double, Vec2 or Vec3.
template <typename V>
[[nodiscard]] inline V finite_or_zero(const V& x, Fault& faults) noexcept {
  if (is_finite(x)) return x;
  faults |= Fault::kNotFinite;
  return V{0.0};
}

}  // namespace tandem::core
