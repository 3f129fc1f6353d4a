#pragma once

#include <algorithm>
#include <cmath>

#include "view/projection.h"

namespace tandem::view {

/// Looks at a point from around it; z is up.
struct Camera {
  Vec3 target{0.0};
  double azimuth = -1.25;   ///< of the eye, seen from the target, from +x to +y [rad]
  double elevation = 0.80;  ///< of the eye above the ground [rad]
  double distance = 0.5;    ///< [m]
  double fov_y = 0.62;      ///< [rad]

  [[nodiscard]] Vec3 eye() const {
    return target + Vec3{std::cos(elevation) * std::cos(azimuth),
                         std::cos(elevation) * std::sin(azimuth), std::sin(elevation)} *
                        distance;
  }

  [[nodiscard]] Picture picture(int width, int height) const {
    Picture p;
    p.width = width;
    p.height = height;
    p.view = look_at(eye(), target, Vec3{0, 0, 1});
    p.projection = projection_matrix(symmetric_frustum(fov_y, static_cast<double>(width) / height,
                                                       0.02 * distance, 50.0 * distance));
    return p;
  }

  /// Mouse on the picture: angles in radians a pixel.
  void turn(double right, double down) {
    constexpr double kPerPixel = 0.006;
    azimuth -= kPerPixel * right;
    elevation = std::clamp(elevation + kPerPixel * down, -0.2, 1.55);
  }
  void zoom(double steps) { distance = std::clamp(distance * std::exp(-0.12 * steps), 0.02, 50.0); }
  /// Moves the target in the plane of the picture, by fractions of its height.
  void pan(double right, double up) {
    const double size = 2.0 * distance * std::tan(0.5 * fov_y);
    const Vec3 x{-std::sin(azimuth), std::cos(azimuth), 0.0};
    const Vec3 y{-std::sin(elevation) * std::cos(azimuth), -std::sin(elevation) * std::sin(azimuth),
                 std::cos(elevation)};
    target += (x * right + y * up) * size;
  }
};

}  // namespace tandem::view
