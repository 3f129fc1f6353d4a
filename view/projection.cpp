#include "view/projection.h"

#include <cmath>
#include <stdexcept>
#include <string>

#include <glm/gtc/matrix_transform.hpp>

namespace tandem::view {

Frustum symmetric_frustum(double fov_y, double aspect, double near, double far) {
  const double top = near * std::tan(0.5 * fov_y);
  return {-top * aspect, top * aspect, -top, top, near, far};
}

Frustum off_axis_frustum(double width, double height, const Vec3& eye_S, double near, double far) {
  if (!(width > 0.0 && height > 0.0))
    throw std::invalid_argument("screen of " + std::to_string(width) + " x " +
                                std::to_string(height) + " m: both must be above 0");
  if (!(eye_S.z > 0.0))
    throw std::invalid_argument("the eye is at z = " + std::to_string(eye_S.z) +
                                " m of the screen's frame: it must be in front of it, z > 0");
  const double scale = near / eye_S.z;
  return {(-0.5 * width - eye_S.x) * scale,
          (0.5 * width - eye_S.x) * scale,
          (-0.5 * height - eye_S.y) * scale,
          (0.5 * height - eye_S.y) * scale,
          near,
          far};
}

Mat4 projection_matrix(const Frustum& f) {
  return glm::frustum(f.left, f.right, f.bottom, f.top, f.near, f.far);
}

Mat4 look_at(const Vec3& eye, const Vec3& target, const Vec3& up) {
  return glm::lookAt(eye, target, up);
}

std::optional<Vec2> Picture::pixel(const Vec3& p_W) const {
  const glm::dvec4 clip = matrix() * glm::dvec4(p_W, 1.0);
  if (clip.w <= 0.0) return std::nullopt;
  return Vec2{0.5 * (clip.x / clip.w + 1.0) * width, 0.5 * (1.0 - clip.y / clip.w) * height};
}

Vec3 Picture::eye() const { return Vec3(glm::inverse(view) * glm::dvec4(0, 0, 0, 1)); }

Vec3 Picture::ray(const Vec2& pixel) const {
  const glm::dvec4 clip(2.0 * pixel.x / width - 1.0, 1.0 - 2.0 * pixel.y / height, 1.0, 1.0);
  const glm::dvec4 far = glm::inverse(matrix()) * clip;
  return glm::normalize(Vec3(far) / far.w - eye());
}

}  // namespace tandem::view
