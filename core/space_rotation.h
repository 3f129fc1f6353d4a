#pragma once

#include <cmath>

#include "core/trigonometry.h"
#include "core/vec.h"

/// Rotations in space from arithmetic alone, so that a law's bits do not hang on the C library of
/// the machine: quaternion of a rotation vector and back, and the axes of a rotation.
namespace tandem::core {

[[nodiscard]] inline Vec3 cross(const Vec3& a, const Vec3& b) noexcept {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

namespace detail {

/// s with atan(t) = t - t s, z = t^2, |t| < 7/16: the polynomial of fdlibm's s_atan.c (Sun
/// Microsystems, 1993), below one unit in the last place.
[[nodiscard]] inline double arctangent_defect(double z) noexcept {
  const double w = z * z;
  const double odd =
      z * (3.33333333333329318027e-01 +
           w * (1.42857142725034663711e-01 +
                w * (9.09088713343650656196e-02 +
                     w * (6.66107313738753120669e-02 +
                          w * (4.97687799461593236017e-02 + w * 1.62858201153657823623e-02)))));
  const double even =
      w * (-1.99999999998764832476e-01 +
           w * (-1.11111104054623557880e-01 +
                w * (-7.69187620504482999495e-02 +
                     w * (-5.83357013379057348645e-02 + w * -3.65315727442169155270e-02))));
  return odd + even;
}

}  // namespace detail

/// Angle of the point (x, y) above the x axis, in 0 .. pi/2, for x >= 0 and y >= 0; one or two
/// units in the last place. Both zero gives not-a-number. fdlibm's reduction to |t| < 7/16.
[[nodiscard]] inline double arctangent(double y, double x) noexcept {
  double high = 0.0, low = 0.0, t = 0.0;
  if (y < 0.4375 * x) {
    t = y / x;
  } else if (y < 0.6875 * x) {
    high = 4.63647609000806093515e-01, low = 2.26987774529616870924e-17;
    t = (2.0 * y - x) / (2.0 * x + y);
  } else if (y < 1.1875 * x) {
    high = 7.85398163397448278999e-01, low = 3.06161699786838301793e-17;
    t = (y - x) / (y + x);
  } else if (y < 2.4375 * x) {
    high = 9.82793723247329054082e-01, low = 1.39033110312309984516e-17;
    t = (y - 1.5 * x) / (x + 1.5 * y);
  } else {
    high = 1.57079632679489655800e+00, low = 6.12323399573676603587e-17;
    t = -x / y;
  }
  return high - ((t * detail::arctangent_defect(t * t) - low) - t);
}

/// The rotation by |r| [rad] about r: exp(r/2). Series up to 0.2 rad, where a tick lives; sin_cos
/// beyond. Relative error of a few 1e-16, of unit length to the same.
[[nodiscard]] inline Quat rotation_by(const Vec3& r) noexcept {
  const double h2 = 0.25 * (r.x * r.x + r.y * r.y + r.z * r.z);
  double cosine = 1.0, half_sinc = 0.5;
  if (h2 < 0.01) {  // the first terms left out are h^10/10! and h^10/11!, below 3e-17
    cosine = 1.0 + h2 * (-1.0 / 2 + h2 * (1.0 / 24 + h2 * (-1.0 / 720 + h2 * (1.0 / 40320))));
    half_sinc = 0.5 + h2 * (-0.5 / 6 + h2 * (0.5 / 120 + h2 * (-0.5 / 5040 + h2 * (0.5 / 362880))));
  } else {
    const double h = std::sqrt(h2);
    const SinCos turn = sin_cos(h);
    cosine = turn.cos;
    half_sinc = 0.5 * turn.sin / h;
  }
  return {cosine, r.x * half_sinc, r.y * half_sinc, r.z * half_sinc};
}

/// The rotation vector of q, the shortest way round: length 0 .. pi [rad]. The length of q does not
/// matter; a zero quaternion (never a rotation) gives zero. At half a turn, where both ways are as
/// short, the sign of q's parts decides.
[[nodiscard]] inline Vec3 rotation_vector(const Quat& q) noexcept {
  const double sign = q.w < 0.0 ? -1.0 : 1.0;
  const double w = sign * q.w;
  const double s2 = q.x * q.x + q.y * q.y + q.z * q.z;
  double scale = 0.0;
  if (s2 < 0.19140625 * w * w) {  // half the angle below atan(7/16): no root needed
    scale = 2.0 / w * (1.0 - detail::arctangent_defect(s2 / (w * w)));
  } else if (s2 > 0.0) {
    const double s = std::sqrt(s2);
    scale = 2.0 * arctangent(s, w) / s;
  }
  scale *= sign;
  return {q.x * scale, q.y * scale, q.z * scale};
}

/// Rotation vector, in W, that turns `from` into `to` the shortest way.
[[nodiscard]] inline Vec3 rotation_between(const Quat& from, const Quat& to) noexcept {
  return rotation_vector(to * glm::conjugate(from));
}

[[nodiscard]] inline Quat normalised(const Quat& q) noexcept {
  const double scale = 1.0 / std::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
  return {q.w * scale, q.x * scale, q.y * scale, q.z * scale};
}

/// The axes of a body frame B as they stand in W: a rotation matrix by columns.
struct Axes {
  Vec3 x{1.0, 0.0, 0.0}, y{0.0, 1.0, 0.0}, z{0.0, 0.0, 1.0};

  /// A vector of B in W, and back.
  [[nodiscard]] Vec3 to_world(const Vec3& a) const noexcept {
    return {x.x * a.x + y.x * a.y + z.x * a.z, x.y * a.x + y.y * a.y + z.y * a.z,
            x.z * a.x + y.z * a.y + z.z * a.z};
  }
  [[nodiscard]] Vec3 to_body(const Vec3& a) const noexcept {
    return {x.x * a.x + x.y * a.y + x.z * a.z, y.x * a.x + y.y * a.y + y.z * a.z,
            z.x * a.x + z.y * a.y + z.z * a.z};
  }
};

/// Orthonormal for any q but zero, whatever its length.
[[nodiscard]] inline Axes axes_of(const Quat& q) noexcept {
  const double s = 2.0 / (q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
  const double sx = s * q.x, sy = s * q.y, sz = s * q.z;
  const double xx = sx * q.x, xy = sx * q.y, xz = sx * q.z, xw = sx * q.w;
  const double yy = sy * q.y, yz = sy * q.z, yw = sy * q.w, zz = sz * q.z, zw = sz * q.w;
  return {{1.0 - (yy + zz), xy + zw, xz - yw},
          {xy - zw, 1.0 - (xx + zz), yz + xw},
          {xz + yw, yz - xw, 1.0 - (xx + yy)}};
}

}  // namespace tandem::core
