#pragma once

#include <cmath>
#include <cstdint>

#include "core/box_faces.h"
#include "core/scene.h"
#include "core/space_state.h"

/// Where a finger sphere meets a box or a sphere: which face it came through, and from that the
/// outward normal and the depth. Geometry only; all in the frame B of the body.
namespace tandem::core {

struct SpaceShape {
  Vec3 half{0.0};              ///< box: half edges along the axes of B [m]
  double radius = 0.0;         ///< sphere [m]
  double finger_radius = 0.0;  ///< of the fingers that touch it; 0 is a point [m]
  bool is_sphere = false;
};

[[nodiscard]] inline SpaceShape shape_of(const ObjectParameters& object,
                                         double finger_radius) noexcept {
  return {object.size * 0.5, object.radius, finger_radius, object.shape == Shape::kSphere};
}

/// The point of a surface that a finger is against.
struct SurfacePoint {
  Vec3 normal_B{1.0, 0.0, 0.0};  ///< outward unit vector
  double depth = 0.0;            ///< of the finger below the surface; <= 0 is apart [m]
};

[[nodiscard]] inline bool is_inside(const Vec3& reach, const Vec3& p_B) noexcept {
  return std::fabs(p_B.x) < reach.x && std::fabs(p_B.y) < reach.y && std::fabs(p_B.z) < reach.z;
}

/// The surface of a box under a finger that came in through `face`. That face stays, however deep
/// the finger is pressed, until its centre has gone past the end of the face and below it: it has
/// rolled round the edge, and `face` becomes the neighbouring one. A finger with radius touches a
/// rounded edge or corner there, whose normal turns from one face to the next without a jump.
[[nodiscard]] inline SurfacePoint box_surface(const SpaceShape& box, std::int32_t& face,
                                              const Vec3& p_B) noexcept {
  const double radius = box.finger_radius;
  for (int turn = 0;; ++turn) {
    const int n = face >> 1, s = n == 2 ? 0 : n + 1, t = s == 2 ? 0 : s + 1;
    const double sign = (face & 1) ? -1.0 : 1.0;
    const double above = sign * p_B[n] - box.half[n];
    const double past_s = std::fabs(p_B[s]) - box.half[s];
    const double past_t = std::fabs(p_B[t]) - box.half[t];
    SurfacePoint at;
    at.normal_B = Vec3{0.0};
    if (past_s <= 0.0 && past_t <= 0.0) {
      at.normal_B[n] = sign;
      at.depth = radius - above;
      return at;
    }
    const double beyond_s = past_s > 0.0 ? past_s : 0.0, beyond_t = past_t > 0.0 ? past_t : 0.0;
    const double beyond2 = beyond_s * beyond_s + beyond_t * beyond_t;
    if (beyond2 >= radius * radius) {  // slid off the end
      at.normal_B[n] = sign;
      return at;
    }
    if (above > 0.0 || turn > 0) {
      const double distance = std::sqrt(above * above + beyond2);
      at.normal_B[n] = sign * above / distance;
      at.normal_B[s] = (p_B[s] < 0.0 ? -beyond_s : beyond_s) / distance;
      at.normal_B[t] = (p_B[t] < 0.0 ? -beyond_t : beyond_t) / distance;
      at.depth = radius - distance;
      return at;
    }
    const int next = beyond_s >= beyond_t ? s : t;
    face = 2 * next + (p_B[next] < 0.0 ? 1 : 0);
  }
}

/// The normal at the point where the straight way from `from` (outside) to `to` enters a sphere of
/// radius `reach`; false if it does not.
[[nodiscard]] inline bool entered_sphere(double reach, const Vec3& from, const Vec3& to,
                                         Vec3& normal) noexcept {
  const Vec3 way = to - from;
  const double a = inner(way, way), b = inner(from, way);
  const double c = inner(from, from) - reach * reach;
  if (!(b < 0.0) || c < 0.0) return false;  // moves away
  const double square = b * b - a * c;
  if (square < 0.0) return false;
  const double when = c / (std::sqrt(square) - b);
  if (when > 1.0) return false;
  normal = (from + way * when) * (1.0 / reach);
  return true;
}

/// The surface of a sphere under a finger. `normal` is the side that the finger is on: it follows
/// the finger round the sphere and stays when the finger jumps past the centre, so that it is
/// pushed back the way it came.
[[nodiscard]] inline SurfacePoint sphere_surface(const SpaceShape& sphere, Vec3& normal,
                                                 const Vec3& p_B) noexcept {
  const double reach = sphere.radius + sphere.finger_radius;
  const double height = inner(normal, p_B), distance2 = inner(p_B, p_B);
  if (height > 0.0) {
    const double distance = std::sqrt(distance2);
    normal = p_B * (1.0 / distance);
    return {normal, reach - distance};
  }
  if (distance2 - height * height >= reach * reach) return {normal, 0.0};  // slid past it
  return {normal, reach - height};
}

}  // namespace tandem::core
