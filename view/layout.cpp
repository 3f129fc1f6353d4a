#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

#include "view/drawing.h"

namespace tandem::view {
namespace {

void include(Layout& l, const Vec3& p, double margin) {
  l.low = glm::min(l.low, p - Vec3{margin});
  l.high = glm::max(l.high, p + Vec3{margin});
}

/// Where a finger means to go, by its script.
void include_path(Layout& l, const core::FingerParameters& finger, int user) {
  include(l, l.place(finger.position, user), 0.1 * l.unit);
  for (const core::Keyframe& k : finger.intent.path)
    include(l, l.place(finger.position + k.position, user), 0.1 * l.unit);
  for (const core::SinePart& s : finger.intent.path_sines)
    for (const double sign : {-1.0, 1.0})
      include(l, l.place(finger.position + s.direction * (sign * s.amplitude), user), 0.1 * l.unit);
}

}  // namespace

Layout::Layout(const core::Scene& given) : scene(given) {
  // A typical size: the largest edge there is; on an axis, how far the hands mean to go.
  double size = 0.0;
  for (const core::ObjectParameters& o : scene.objects)
    size = std::max({size, o.size.x, o.size.y, o.size.z, 2.0 * o.radius});
  if (scene.space == core::Space::kAxis) {
    size = 0.0;
    for (const core::UserParameters& u : scene.users)
      for (const core::FingerParameters& f : u.fingers) {
        for (const core::Keyframe& k : f.intent.path) size = std::max(size, std::abs(k.position.x));
        for (const core::SinePart& s : f.intent.path_sines) size = std::max(size, s.amplitude);
        size = std::max(size, std::abs(f.position.x));
      }
    size *= 0.8;
  }
  unit = size > 0.0 ? std::clamp(size, 0.008, 2.0) : 0.05;

  double max_force = 10.0;
  for (const core::DeviceParameters& d : scene.devices)
    if (d.max_force > 0.0) max_force = d.max_force;
  metres_per_newton = 1.3 * unit / max_force;
  if (scene.space == core::Space::kSpace)
    for (const core::WallParameters& w : scene.walls)
      if (w.normal.z > 0.9) ground = w.point.z;

  low = Vec3{1e9};
  high = Vec3{-1e9};
  for (std::size_t u = 0; u < scene.users.size(); ++u)
    for (const core::FingerParameters& f : scene.users[u].fingers)
      include_path(*this, f, static_cast<int>(u));
  for (std::size_t o = 0; o < scene.objects.size(); ++o)
    include(*this, place(scene.objects[o].position, -1),
            0.5 * glm::length(object_size(static_cast<int>(o))));
  const Vec3 middle = 0.5 * (low + high);
  for (const core::WallParameters& w : scene.walls) {
    if (scene.space == core::Space::kSpace && w.normal.z > 0.9) continue;
    const Vec3 n = glm::normalize(w.normal);
    const Vec3 foot = middle - n * glm::dot(middle - w.point, n);
    include(*this, {foot.x, foot.y, middle.z}, 0.05 * unit);
  }
  low.z = std::min(low.z, ground);
}

Vec3 Layout::place(const Vec3& p, int user) const {
  switch (scene.space) {
    case core::Space::kAxis: {
      // Hand and object share the line: each hand has a lane beside it.
      const int users = static_cast<int>(scene.users.size());
      const double lane =
          user < 0 || scene.objects.empty() ? 0.0 : (user - 0.5 * (users - 1)) * 1.6 * unit;
      const double single = users == 1 && user >= 0 && !scene.objects.empty() ? -unit : 0.0;
      return {p.x, lane + single, 0.5 * unit};
    }
    case core::Space::kPlane:
      return {p.x, p.y, 0.25 * unit};
    case core::Space::kSpace:
      return p;
  }
  return p;
}

Vec3 Layout::object_size(int o) const {
  const core::ObjectParameters& object = scene.objects[static_cast<std::size_t>(o)];
  if (scene.space == core::Space::kAxis) return Vec3{0.7 * unit};
  if (object.shape == core::Shape::kSphere) return Vec3{2.0 * object.radius};
  if (scene.space == core::Space::kPlane) return {object.size.x, object.size.y, 0.5 * unit};
  return object.size;
}

double Layout::finger_radius(int user, int f) const {
  const double r =
      scene.users[static_cast<std::size_t>(user)].fingers[static_cast<std::size_t>(f)].radius;
  return r > 0.0 ? r : 0.10 * unit;
}

Camera Layout::camera(double aspect) const {
  Camera c;
  c.target = 0.5 * (low + high);
  // The sphere around everything, in the narrower of the two angles.
  const double radius = 0.5 * glm::length(high - low) + 0.3 * unit;
  const double half = std::min(0.5 * c.fov_y, std::atan(std::tan(0.5 * c.fov_y) * aspect));
  c.distance = 0.92 * radius / std::sin(half);
  if (scene.space == core::Space::kAxis) {
    c.azimuth = -1.45;
    c.elevation = 0.55;
  }
  if (scene.space == core::Space::kSpace) {
    c.azimuth = -0.75;
    c.elevation = 0.42;
  }
  return c;
}

namespace {

/// Sets proxy and normal when the finger, seen from the object, has sunk into it.
void rest_on(const Layout& l, const core::ObjectParameters& object, const Body& body,
             const Finger& finger, double radius, DrawnFinger& out) {
  const Vec3 p_B = glm::conjugate(body.q) * (finger.p - body.p);
  Vec3 n_B{0.0}, on_B = p_B;
  if (object.shape == core::Shape::kSphere) {
    const double length = glm::length(p_B);
    if (length <= 0.0) return;
    n_B = p_B / length;
    on_B = n_B * (object.radius + radius);
  } else {
    const bool plane = l.scene.space == core::Space::kPlane;
    const int axis = plane ? finger.side / 2 : std::min(finger.side, 2);
    const double sign =
        plane ? (finger.side % 2 == 0 ? 1.0 : -1.0) : (p_B[axis] < 0.0 ? -1.0 : 1.0);
    const double face = 0.5 * object.size[axis] + radius;
    n_B[axis] = sign;
    on_B[axis] = sign * face;
  }
  out.normal = body.q * n_B;
  out.proxy = body.p + body.q * on_B;
}

}  // namespace

DrawnFinger drawn_finger(const Layout& l, const Snapshot& seen, int user, int f) {
  const core::Scene& scene = l.scene;
  const Finger& finger =
      seen.sites[static_cast<std::size_t>(user)].fingers[static_cast<std::size_t>(f)];
  const double radius =
      scene.users[static_cast<std::size_t>(user)].fingers[static_cast<std::size_t>(f)].radius;
  DrawnFinger out;
  out.proxy = finger.p;

  // What this user touches: its own copy, or the one everybody has.
  const Site& own = seen.sites[static_cast<std::size_t>(user)];
  const Site& copy = own.has_objects ? own : seen.sites[static_cast<std::size_t>(seen.own)];
  if (finger.contact != core::ContactState::kFree && copy.has_objects && !scene.contact.attached &&
      scene.space != core::Space::kAxis) {
    std::size_t nearest = 0;
    double least = 1e9;
    for (std::size_t o = 0; o < scene.objects.size(); ++o) {
      const double d = glm::length(copy.objects[o].p - finger.p);
      if (d < least) least = d, nearest = o;
    }
    rest_on(l, scene.objects[nearest], copy.objects[nearest], finger, radius, out);
  }
  for (const core::WallParameters& w : scene.walls) {
    if (!w.touches_fingers) continue;
    const Vec3 n = glm::normalize(w.normal);
    const double depth = radius - glm::dot(n, out.proxy - w.point);
    if (depth <= 0.0) continue;
    out.proxy += n * depth;
    out.normal = n;
  }
  out.hip = l.place(finger.p, user);
  out.proxy = l.place(out.proxy, user);
  // A point finger is drawn as a ball that lies on the surface.
  if (radius <= 0.0 && glm::length(out.normal) > 0.0)
    out.proxy += out.normal * l.finger_radius(user, f);
  return out;
}

}  // namespace tandem::view
