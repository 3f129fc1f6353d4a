#pragma once

#include "core/ground_friction.h"
#include "core/scene.h"

namespace tandem::core {

/// One coordinate (vector or angle) over T with force and friction limit per mass.
///   zero-order hold:     x += T (v0 + v1) / 2, exact; with friction to the stop, not beyond
///   semi-implicit Euler: x += T v1
///   explicit Euler:      x += T v0 (thesis 7.2.3); a body at rest that stays at rest does not move
template <typename V>
inline void advance(Integrator integrator, double T, double friction, V& x, V& v,
                    const V& acceleration) noexcept {
  const V v0 = v;
  v += acceleration * T;
  const V free_v = v;
  const double limit = T * friction;
  const bool stopped = limit > 0.0 && rub_on_ground(limit, v);
  switch (integrator) {
    case Integrator::kZeroOrderHold:
    case Integrator::kExactCoupler:  // where nothing but held forces acts
      x += stopped ? stopping_way(T, limit, v0, free_v) : (v0 + v) * (0.5 * T);
      break;
    case Integrator::kSemiImplicitEuler:
      x += v * T;
      break;
    case Integrator::kExplicitEuler:
      x += v0 * T;
      break;
  }
}

}  // namespace tandem::core
