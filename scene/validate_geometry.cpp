#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>

#include <glm/geometric.hpp>

#include "scene/scene_fields.h"
#include "scene/validate_scene.h"

namespace tandem::scene {
namespace {

using core::Shape;
using core::Space;
using core::Vec3;

/// Rounding of metres; things may touch at the start.
constexpr double kTouch = 1e-9;
/// Normals and orientations in this range of length are meant; shorter or longer is a slip.
constexpr double kShortest = 1e-3, kLongest = 1e3;
/// Closer to unit length than this, bits are kept.
constexpr double kUnit = 1e-12;

/// To the micrometre: what a person moves it by.
std::string metres(double distance) { return number_text(std::round(distance * 1e6) / 1e6); }

int dimensions(Space space) { return space == Space::kAxis ? 1 : space == Space::kPlane ? 2 : 3; }

/// Length 0 stays 0.
core::Quat orientation_of(const core::ObjectParameters& o, Space space) {
  if (space == Space::kAxis) return {1.0, 0.0, 0.0, 0.0};
  if (space == Space::kPlane) return {std::cos(o.angle / 2.0), 0.0, 0.0, std::sin(o.angle / 2.0)};
  const double length = glm::length(o.orientation);
  return length > 0.0 ? o.orientation / length : core::Quat{1.0, 0.0, 0.0, 0.0};
}

/// Half edges; a dimension that the space lacks is 0.
Vec3 half_edges(const core::ObjectParameters& o, Space space) {
  Vec3 half{0.0};
  if (o.shape == Shape::kBox)
    for (int i = 0; i < dimensions(space); ++i) half[i] = 0.5 * o.size[i];
  return half;
}

/// Distance of a point from the surface, negative inside [m].
double distance_from(const core::ObjectParameters& o, const Vec3& point, Space space) {
  const Vec3 offset = point - o.position;
  if (o.shape == Shape::kSphere) return glm::length(offset) - o.radius;
  const Vec3 local = glm::conjugate(orientation_of(o, space)) * offset;
  const Vec3 half = half_edges(o, space);
  Vec3 outside{0.0};
  double inside = -1e300;
  for (int i = 0; i < dimensions(space); ++i) {
    const double beyond = std::abs(local[i]) - half[i];
    outside[i] = std::max(beyond, 0.0);
    inside = std::max(inside, beyond);
  }
  return inside > 0.0 ? glm::length(outside) : inside;
}

/// How far the object reaches towards `direction` from its centre [m].
double reach(const core::ObjectParameters& o, const Vec3& direction, Space space) {
  if (o.shape == Shape::kSphere) return o.radius;
  const Vec3 local = glm::conjugate(orientation_of(o, space)) * direction;
  const Vec3 half = half_edges(o, space);
  return std::abs(local.x) * half.x + std::abs(local.y) * half.y + std::abs(local.z) * half.z;
}

class Geometry {
 public:
  Geometry(const core::Scene& scene, std::vector<Problem>& problems)
      : scene_(scene), space_(scene.space), problems_(problems) {}

  void check() {
    for (std::size_t i = 0; i < scene_.objects.size(); ++i) {
      const std::string path = "object." + entry_key(scene_.objects[i], i);
      check_shape(scene_.objects[i], path);
      check_inertia(scene_.objects[i], path);
    }
    for (std::size_t i = 0; i < scene_.walls.size(); ++i)
      check_wall(scene_.walls[i], "wall." + entry_key(scene_.walls[i], i));
    if (!scene_.contact.attached) check_fingers_outside_objects();
  }

 private:
  void report(const std::string& path, const std::string& text) {
    problems_.push_back({path, path + text, {}});
  }

  void check_shape(const core::ObjectParameters& o, const std::string& path) {
    const bool right = space_ == Space::kAxis    ? o.shape == Shape::kPoint
                       : space_ == Space::kPlane ? o.shape == Shape::kBox
                                                 : o.shape != Shape::kPoint;
    if (!right)
      report(path + ".shape", std::string(": ") + std::string(words(space_)) + " has objects of " +
                                  (space_ == Space::kAxis    ? "shape POINT"
                                   : space_ == Space::kPlane ? "shape BOX"
                                                             : "shape BOX or SPHERE"));
    if (space_ == Space::kAxis) return;
    for (int i = 0; i < dimensions(space_); ++i) {
      const std::string edge = path + ".size." + "xyz"[i];
      if (o.shape == Shape::kBox && !(o.size[i] > 0.0))
        report(edge, " = " + number_text(o.size[i]) + " m: a BOX needs an edge above 0");
      if (o.shape == Shape::kSphere && o.size[i] != 0.0)
        report(edge, " = " + number_text(o.size[i]) + " m: a SPHERE has a radius, no size");
    }
    if (o.shape == Shape::kSphere && !(o.radius > 0.0))
      report(path + ".radius", " = " + number_text(o.radius) + " m: a SPHERE needs one above 0");
    if (o.shape != Shape::kSphere && o.radius != 0.0)
      report(path + ".radius", " = " + number_text(o.radius) + " m: only a SPHERE has a radius");
    const double length = glm::length(o.orientation);
    if (space_ == Space::kSpace && !(length >= kShortest && length <= kLongest))
      report(path + ".orientation", ": has length " + number_text(length) +
                                        "; a quaternion of length 1 is needed, {w: 1} for none");
  }

  void check_inertia(const core::ObjectParameters& o, const std::string& path) {
    if (space_ != Space::kSpace) return;
    const Vec3& j = o.inertia;
    if (j.x == 0.0 && j.y == 0.0 && j.z == 0.0) return;
    const double sum = j.x + j.y + j.z;
    for (int i = 0; i < 3; ++i) {
      const std::string moment = path + ".inertia." + "xyz"[i];
      if (!(j[i] > 0.0))
        report(moment, " = " + number_text(j[i]) +
                           " kg m^2: must be above 0 as another is; leave all out for uniform "
                           "density");
      else if (j[i] > (sum - j[i]) * (1.0 + 1e-9))
        report(moment, " = " + number_text(j[i]) +
                           " kg m^2: no body has one larger than the sum of the other two, " +
                           number_text(sum - j[i]));
    }
  }

  void check_wall(const core::WallParameters& w, const std::string& path) {
    const double length = glm::length(w.normal);
    if (!(length >= kShortest && length <= kLongest)) {
      report(path + ".normal", ": has length " + number_text(length) +
                                   "; must point to the free side, length 1 is best");
      return;
    }
    if (w.attached) return;  // no contact test, nothing is behind it
    const Vec3 normal = w.normal / length;
    if (w.touches_objects)
      for (std::size_t i = 0; i < scene_.objects.size(); ++i) {
        const auto& o = scene_.objects[i];
        const double gap = glm::dot(normal, o.position - w.point) - reach(o, normal, space_);
        if (gap < -kTouch)
          report("object." + entry_key(o, i) + ".position",
                 ": starts " + metres(-gap) + " m behind wall '" + w.name +
                     "'; move the object, or the wall's point, or turn the normal round");
      }
    if (w.touches_fingers)
      for_each_finger([&](const core::FingerParameters& f, const std::string& finger) {
        const double gap = glm::dot(normal, f.position - w.point) - f.radius;
        if (gap < -kTouch)
          report(finger + ".position", ": starts " + metres(-gap) + " m behind wall '" + w.name +
                                           "'; move the finger or the wall");
      });
  }

  void check_fingers_outside_objects() {
    if (space_ == Space::kAxis) return;  // points have no inside
    for_each_finger([&](const core::FingerParameters& f, const std::string& finger) {
      for (std::size_t i = 0; i < scene_.objects.size(); ++i) {
        const auto& o = scene_.objects[i];
        const double gap = distance_from(o, f.position, space_) - f.radius;
        if (gap < -kTouch)
          report(finger + ".position", ": starts " + metres(-gap) + " m inside object '" + o.name +
                                           "'; start outside, or declare the grasp with "
                                           "contact.attached = true");
      }
    });
  }

  template <typename Fn>
  void for_each_finger(Fn&& fn) {
    for (std::size_t u = 0; u < scene_.users.size(); ++u)
      for (std::size_t f = 0; f < scene_.users[u].fingers.size(); ++f)
        fn(scene_.users[u].fingers[f], "user." + entry_key(scene_.users[u], u) + ".finger." +
                                           entry_key(scene_.users[u].fingers[f], f));
  }

  const core::Scene& scene_;
  const Space space_;
  std::vector<Problem>& problems_;
};

}  // namespace

void validate_geometry(const core::Scene& scene, std::vector<Problem>& problems) {
  Geometry(scene, problems).check();
}

void normalise(core::Scene& scene) {
  for (core::WallParameters& wall : scene.walls) {
    const double length = glm::length(wall.normal);
    if (std::abs(length - 1.0) > kUnit) wall.normal /= length;
  }
  for (core::ObjectParameters& object : scene.objects) {
    const double length = glm::length(object.orientation);
    if (std::abs(length - 1.0) > kUnit) object.orientation /= length;
  }
}

}  // namespace tandem::scene
