#pragma once

#include <cmath>

#include "core/random.h"
#include "core/space_wall.h"

namespace tandem::core {

inline constexpr double kTick = 1.0 / 1024.0;
inline constexpr double kHalfTurn = 3.14159265358979323846;

[[nodiscard]] inline double length(const Vec3& a) { return std::sqrt(inner(a, a)); }

[[nodiscard]] inline Vec3 random_vector(Random& random, double size = 1.0) {
  return Vec3{random.normal(), random.normal(), random.normal()} * size;
}

[[nodiscard]] inline ContactGains finger_gains(double mu_s = 0.6, double mu_k = 0.5) {
  ContactGains gains;
  gains.normal = {800.0, 3.0};
  gains.tangential = {1200.0, 10.0};
  gains.friction = {mu_s, mu_k, 0.005};
  return gains;
}

[[nodiscard]] inline ContactGains ground_gains(double mu_s, double mu_k) {
  ContactGains gains;
  gains.normal = {4000.0, 30.0};
  gains.tangential = {7000.0, 50.0};
  gains.friction = {mu_s, mu_k, 0.005};
  return gains;
}

/// Springs alone, so that forces are closed forms of positions.
[[nodiscard]] inline ContactGains without_dampers(ContactGains gains) {
  gains.normal.damping = gains.tangential.damping = 0.0;
  return gains;
}

}  // namespace tandem::core
