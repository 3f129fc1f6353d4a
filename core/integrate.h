#pragma once

#include "core/scene.h"

namespace tandem::core {

/// Advances one coordinate by T with the acceleration held over the step.
///   zero-order hold:     x += T v + T^2/2 a,  v += T a     (exact)
///   semi-implicit Euler: v += T a,            x += T v
///   explicit Euler:      x += T v,            v += T a     (thesis 7.2.3)
/// Positions and velocities may be scalars or vectors.
template <typename T_>
inline void integrate(Integrator integrator, double T, T_& x, T_& v, const T_& a) noexcept {
  const T_ v0 = v;
  v += a * T;
  switch (integrator) {
    case Integrator::kZeroOrderHold: x += v0 * T + a * (0.5 * T * T); break;
    case Integrator::kSemiImplicitEuler: x += v * T; break;
    case Integrator::kExplicitEuler: x += v0 * T; break;
  }
}

}  // namespace tandem::core
