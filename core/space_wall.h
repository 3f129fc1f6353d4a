#pragma once

#include <array>
#include <cmath>

#include "core/mean_contact.h"
#include "core/space_contact.h"

/// Plane walls in space against the corners of boxes, spheres and fingers. The wall takes the part
/// of the surface and stands still in W; what touches it takes the part of the finger.
namespace tandem::core {

/// Nothing may enter the side that `normal`, a unit vector, points away from.
struct SpaceWall {
  Vec3 point{0.0};
  Vec3 normal{0.0, 0.0, 1.0};
  ContactGains gains;
};

/// One body against one wall. Corner i of a box is at the signs of its bits: 1 -x, 2 -y, 4 -z. A
/// sphere uses corner[0], whose anchor is then its stretch.
struct SpaceWallContacts {
  std::array<ContactMemory<Vec3>, 8> corner;
  Vec3 before_p{0.0};  ///< sphere: where it was at the last tick [m]
  Quat before_q{1.0, 0.0, 0.0, 0.0};
  bool any = false;  ///< something touched at the last tick
};

/// One tick of the corners of a box. Costs one projection while the box is clear of the wall.
/// `within_tick`: as in the plane (core/plane_contact.h), here and below.
[[nodiscard]] inline SpaceWrench hold_back_box(SpaceWallContacts& contacts, const SpaceWall& wall,
                                               const SpaceShape& box, const PlacedSpaceBody& body,
                                               double T, bool within_tick = false) noexcept {
  const Vec3& n = wall.normal;
  const Vec3 reach = body.to_body(n) * box.half;
  const double clearance = inner(n, body.p - wall.point);
  double soon = 0.0;  // how far a corner may get in this tick
  if (within_tick) {
    const double turning = std::sqrt(inner(body.omega, body.omega) * inner(box.half, box.half));
    const double approach = turning - inner(n, body.v);
    if (approach > 0.0) soon = approach * T;
  }
  if (clearance - soon >= std::fabs(reach.x) + std::fabs(reach.y) + std::fabs(reach.z)) {
    if (contacts.any) contacts = {};
    return {};
  }
  const Vec3 edge_x = body.axes.x * box.half.x, edge_y = body.axes.y * box.half.y,
             edge_z = body.axes.z * box.half.z;
  SpaceWrench wrench;
  for (int i = 0; i < 8; ++i) {
    const double sx = (i & 1) ? -1.0 : 1.0, sy = (i & 2) ? -1.0 : 1.0, sz = (i & 4) ? -1.0 : 1.0;
    double depth = -(clearance + sx * reach.x + sy * reach.y + sz * reach.z);
    ContactMemory<Vec3>& memory = contacts.corner[i];
    if (!(depth + soon > 0.0)) {
      memory.state = ContactState::kFree;
      continue;
    }
    const Vec3 arm = edge_x * sx + edge_y * sy + edge_z * sz;
    const Vec3 turning = cross(body.omega, arm);
    Vec3 v = body.v + turning, lever = arm;
    if (within_tick) {
      const double rise = inner(n, v);
      const MeanContact mean = mean_contact(depth, rise, T);
      depth = mean.depth;
      v += n * (mean.normal_velocity - rise);
      lever += turning * (0.5 * T);
    }
    const Vec3 f = press_at(memory, wall.gains, {n, depth}, body.p + arm, v, T);
    wrench.force += f;
    wrench.torque += cross(lever, f);
  }
  contacts.any = true;
  return wrench;
}

/// One tick of a sphere. Other points of it touch at every tick as it rolls, so no point of it can
/// be the anchor. Its stretch is the sum of what the touching point really slipped along the wall,
///   s += P (p - p_before + r x arm),   r the rotation vector since the last tick, arm = -R n
/// from poses, so that it is right for every integrator; the wall's tangent plane stands still, so
/// the sum needs no turning. A sphere that rolls adds nothing.
[[nodiscard]] inline SpaceWrench hold_back_sphere(SpaceWallContacts& contacts,
                                                  const SpaceWall& wall, const SpaceShape& sphere,
                                                  const PlacedSpaceBody& body, double T,
                                                  bool within_tick) noexcept {
  double depth = sphere.radius - inner(wall.normal, body.p - wall.point);
  MeanContact mean;
  if (within_tick) {
    mean = mean_contact(depth, inner(wall.normal, body.v), T);
    depth = mean.depth;
  }
  if (!(depth > 0.0)) {
    if (contacts.any) contacts = {};
    return {};
  }
  const Vec3& n = wall.normal;
  const Vec3 arm = n * -sphere.radius;
  ContactMemory<Vec3>& memory = contacts.corner[0];
  Vec3 stretch{0.0};
  if (memory.state != ContactState::kFree) {
    const Vec3 turned = rotation_between(contacts.before_q, body.q);
    stretch = memory.anchor + (body.p - contacts.before_p) + cross(turned, arm);
    stretch -= n * inner(n, stretch);
  }
  contacts.before_p = body.p;
  contacts.before_q = body.q;
  contacts.any = true;

  const Vec3 v = body.v + cross(body.omega, arm);
  const double rise = inner(n, v);
  memory.anchor = Vec3{0.0};
  const SurfaceMotion<Vec3> motion{depth, within_tick ? mean.normal_velocity : rise, stretch,
                                   v - n * rise};
  const SurfaceForce<Vec3> f = press(memory, wall.gains, motion, T);
  memory.anchor = stretch - memory.anchor;
  const Vec3 force = n * f.normal + f.tangential;
  return {force, cross(arm, force)};
}

[[nodiscard]] inline SpaceWrench hold_back(SpaceWallContacts& contacts, const SpaceWall& wall,
                                           const SpaceShape& shape, const PlacedSpaceBody& body,
                                           double T, bool within_tick = false) noexcept {
  return shape.is_sphere ? hold_back_sphere(contacts, wall, shape, body, T, within_tick)
                         : hold_back_box(contacts, wall, shape, body, T, within_tick);
}

/// One tick of a finger against a wall; force on the finger.
[[nodiscard]] inline Vec3 hold_back(ContactMemory<Vec3>& memory, const SpaceWall& wall,
                                    const SpacePoint& finger, double radius, double T) noexcept {
  const double depth = radius - inner(wall.normal, finger.p - wall.point);
  if (!(depth > 0.0)) {
    memory.state = ContactState::kFree;
    return Vec3{0.0};
  }
  return press_at(memory, wall.gains, {wall.normal, depth}, finger.p, finger.v, T);
}

}  // namespace tandem::core
