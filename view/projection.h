#pragma once

#include <optional>

#include <glm/mat4x4.hpp>

#include "core/vec.h"

/// From the world to the picture. OpenGL's conventions: the eye looks along -z, y is up, clip
/// coordinates -1 .. 1.
namespace tandem::view {

using core::Vec2;
using core::Vec3;
using Mat4 = glm::dmat4;

/// Window on the near plane, in the frame of the eye [m].
struct Frustum {
  double left = -1, right = 1, bottom = -1, top = 1;
  double near = 0.01, far = 100.0;
};

/// An eye in front of the middle of its picture. `fov_y`: full vertical angle [rad].
[[nodiscard]] Frustum symmetric_frustum(double fov_y, double aspect, double near, double far);

/// A screen that hangs in the room and an eye that moves before it. Screen frame S: origin in the
/// middle of the screen, x to the right, y up, z towards the eye; `eye_S` has z > 0. The edges of
/// the screen, seen from the eye, scaled to the near plane:
///   left = (-width/2 - x_e) near / z_e,   and so on
/// Throws std::invalid_argument for an eye in or behind the screen, or a screen without size.
[[nodiscard]] Frustum off_axis_frustum(double width, double height, const Vec3& eye_S, double near,
                                       double far);

[[nodiscard]] Mat4 projection_matrix(const Frustum& frustum);
[[nodiscard]] Mat4 look_at(const Vec3& eye, const Vec3& target, const Vec3& up);

/// Everything that takes a point of the world to a pixel.
struct Picture {
  Mat4 view{1.0};        ///< W to eye
  Mat4 projection{1.0};  ///< eye to clip
  int x = 0, y = 0;      ///< of the viewport's lower left corner [pixel]
  int width = 1, height = 1;

  [[nodiscard]] Mat4 matrix() const { return projection * view; }
  /// Pixel of a point, from the upper left corner of the viewport; nothing if it is behind the eye.
  [[nodiscard]] std::optional<Vec2> pixel(const Vec3& p_W) const;
  [[nodiscard]] Vec3 eye() const;
  /// Direction from the eye through a pixel, unit, in W.
  [[nodiscard]] Vec3 ray(const Vec2& pixel) const;
};

}  // namespace tandem::view
