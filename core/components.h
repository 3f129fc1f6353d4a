#pragma once

#include "core/vec.h"

/// Reads and writes one coordinate of a scalar or vector alike, so that a law can be written once
/// for an axis (double), a plane (Vec2) and a space (Vec3).
namespace tandem::core {

template <typename T>
inline constexpr int kComponents = T::length();
template <>
inline constexpr int kComponents<double> = 1;

[[nodiscard]] inline double component(const double& x, int) noexcept { return x; }
[[nodiscard]] inline double component(const Vec2& x, int i) noexcept { return x[i]; }
[[nodiscard]] inline double component(const Vec3& x, int i) noexcept { return x[i]; }
inline double& component(double& x, int) noexcept { return x; }
inline double& component(Vec2& x, int i) noexcept { return x[i]; }
inline double& component(Vec3& x, int i) noexcept { return x[i]; }

/// Scalar product, also of scalars.
[[nodiscard]] inline double inner(double a, double b) noexcept { return a * b; }
[[nodiscard]] inline double inner(const Vec2& a, const Vec2& b) noexcept {
  return a.x * b.x + a.y * b.y;
}
[[nodiscard]] inline double inner(const Vec3& a, const Vec3& b) noexcept {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

/// The part of a 3-vector of the scene that a space has: x; x, y; x, y, z.
template <typename T>
[[nodiscard]] T from_vec3(const Vec3& v) noexcept {
  T out{0.0};
  for (int i = 0; i < kComponents<T>; ++i) component(out, i) = v[i];
  return out;
}

template <typename T>
[[nodiscard]] Vec3 to_vec3(const T& v) noexcept {
  Vec3 out{0.0};
  for (int i = 0; i < kComponents<T>; ++i) out[i] = component(v, i);
  return out;
}

}  // namespace tandem::core
