#pragma once

#include <cmath>
#include <cstdint>

#include "core/contact_law.h"
#include "core/space_shape.h"
#include "core/space_state.h"

/// Fingers against boxes and spheres in space, with the one law of core/contact_law.h.
///
/// How tangential stretch is measured. The contact point a is kept in the frame B of the body, at
/// the height of the finger's centre, and the stretch is what the tangent plane at the finger sees
/// of the way from it,
///   s = P (p_B - a_B),   P = 1 - n n^T
/// On a face of a box n stands still and s is the difference of face coordinates. On a sphere, an
/// edge or a corner n turns with the finger and nothing is accumulated from tick to tick: s depends
/// on where the finger is in B and on a alone, so a finger that comes back finds the same force and
/// rounding does not drift. |s| = |p| sin(angle) on a sphere: the chord instead of the arc, 2 %
/// less at 20 degrees; friction has let go long before (5 N, mu 0.6 and 1200 N/m: 2.5 mm). The
/// tangential force is a vector in that plane, so its limit is a round cone in every direction.
namespace tandem::core {

/// Number of the only face of a sphere, after the six of a box.
inline constexpr std::int32_t kSphereFace = 6;

/// One finger against one body, from tick to tick. Default: never seen.
struct FingerSpaceContact {
  ContactMemory<Vec3> memory;    ///< anchor in B
  Vec3 before_B{0.0};            ///< finger in B at the last tick [m]
  Vec3 normal_B{0.0, 0.0, 1.0};  ///< sphere: side the finger is on, while in contact
  std::int32_t face = 0;         ///< entered face while in contact, see nearest_face
  bool seen = false;             ///< before_B is valid
};

struct SpaceContactForces {
  Vec3 on_finger_W{0.0};  ///< [N]
  SpaceWrench on_body;    ///< equal and opposite, torque about the body's centre
};

/// A finger in the frame of a body: where, and how it moves relative to the body's own points.
struct FingerInBody {
  Vec3 arm_W{0.0};
  Vec3 p_B{0.0};
  Vec3 v_B{0.0};
};

[[nodiscard]] inline FingerInBody seen_from(const PlacedSpaceBody& body,
                                            const SpacePoint& finger) noexcept {
  const Vec3 arm = finger.p - body.p;
  const Vec3 relative = finger.v - body.v - cross(body.omega, arm);
  return {arm, body.to_body(arm), body.to_body(relative)};
}

[[nodiscard]] inline SpaceContactForces equal_and_opposite(const Vec3& arm_W,
                                                           const Vec3& on_finger_W) noexcept {
  return {on_finger_W, {-on_finger_W, cross(on_finger_W, arm_W)}};
}

/// One tick of a point at `p` that moves at `v` relative to the surface at `at`; all in the frame
/// that keeps the contact point. Returns the force on the point.
[[nodiscard]] inline Vec3 press_at(ContactMemory<Vec3>& memory, const ContactGains& gains,
                                   const SurfacePoint& at, const Vec3& p, const Vec3& v,
                                   double T) noexcept {
  const Vec3& n = at.normal_B;
  if (memory.state == ContactState::kFree) memory.anchor = p;
  const Vec3 way = p - memory.anchor;
  const double rise = inner(n, v);
  SurfaceMotion<Vec3> motion{at.depth, rise, way - n * inner(n, way), v - n * rise};
  ContactMemory<Vec3> seen{Vec3{0.0}, memory.pulses_left, memory.state};
  const SurfaceForce<Vec3> f = press(seen, gains, motion, T);
  memory.pulses_left = seen.pulses_left;
  memory.state = seen.state;
  if (seen.state == ContactState::kFree) return Vec3{0.0};
  const Vec3& dragged = seen.anchor;
  if (dragged.x != 0.0 || dragged.y != 0.0 || dragged.z != 0.0)
    memory.anchor = p - (motion.position - dragged);
  return n * f.normal + f.tangential;
}

/// Ends a contact and forgets where the finger was: after a jump of the finger or the body (rejoin,
/// reset). The next tick may find the finger inside and takes the nearest face.
inline void release(FingerSpaceContact& contact) noexcept { contact = {}; }

/// Whether a finger that touched nothing has come in since the last tick; sets the face or side.
/// The first tick has no past: a finger found inside takes the nearest face.
[[nodiscard]] inline bool comes_in(FingerSpaceContact& contact, const SpaceShape& shape,
                                   const Vec3& p_B, bool seen, const Vec3& before_B) noexcept {
  if (shape.is_sphere) {
    contact.face = kSphereFace;
    const double reach = shape.radius + shape.finger_radius;
    if (seen && inner(before_B, before_B) >= reach * reach)
      return entered_sphere(reach, before_B, p_B, contact.normal_B);
    const double distance2 = inner(p_B, p_B);
    contact.normal_B = distance2 > 0.0 ? p_B * (1.0 / std::sqrt(distance2)) : Vec3{0.0, 0.0, 1.0};
    return distance2 < reach * reach;
  }
  const Vec3 reach = shape.half + Vec3{shape.finger_radius};
  if (seen && !is_inside(reach, before_B)) {
    contact.face = entered_face(reach, before_B, p_B);
    return contact.face >= 0;
  }
  contact.face = nearest_face(reach, p_B);
  return is_inside(reach, p_B);
}

/// One tick of a finger against a body. Forces act at the finger's centre, where its motion is
/// measured: momentum, and the work that finger and body exchange, are then accounted exactly (the
/// finger is a pad that turns with the body: no rolling).
[[nodiscard]] inline SpaceContactForces touch(FingerSpaceContact& contact,
                                              const ContactGains& gains, const SpaceShape& shape,
                                              const PlacedSpaceBody& body, const SpacePoint& finger,
                                              double T) noexcept {
  const FingerInBody at = seen_from(body, finger);
  const Vec3 before = contact.before_B;
  const bool seen = contact.seen;
  contact.before_B = at.p_B;
  contact.seen = true;
  if (contact.memory.state == ContactState::kFree &&
      !comes_in(contact, shape, at.p_B, seen, before))
    return {};
  const SurfacePoint surface = shape.is_sphere ? sphere_surface(shape, contact.normal_B, at.p_B)
                                               : box_surface(shape, contact.face, at.p_B);
  const Vec3 f_B = press_at(contact.memory, gains, surface, at.p_B, at.v_B, T);
  if (contact.memory.state == ContactState::kFree) return {};
  return equal_and_opposite(at.arm_W, body.to_world(f_B));
}

/// A finger fixed to a body by a bilateral spring and damper at a point of it: no contact test, no
/// cone, no pulses. Linearised grasps use it.
struct AttachedSpaceContact {
  Vec3 anchor_B{0.0};            ///< the fixed point [m]
  Vec3 normal_B{1.0, 0.0, 0.0};  ///< unit vector, direction of the normal gain
};

/// Attaches a finger where it is now, at zero stretch, normal to the nearest face, or along the
/// radius of a sphere.
[[nodiscard]] inline AttachedSpaceContact attach(const SpaceShape& shape,
                                                 const PlacedSpaceBody& body,
                                                 const SpacePoint& finger) noexcept {
  const Vec3 p_B = body.to_body(finger.p - body.p);
  AttachedSpaceContact contact{p_B, Vec3{0.0}};
  const double distance = std::sqrt(inner(p_B, p_B));
  if (shape.is_sphere) {
    contact.normal_B = distance > 0.0 ? p_B * (1.0 / distance) : Vec3{0.0, 0.0, 1.0};
  } else {
    const int face = nearest_face(shape.half, p_B);
    contact.normal_B[face >> 1] = (face & 1) ? -1.0 : 1.0;
  }
  return contact;
}

/// One tick of an attached finger; in the frame of the body,
///   f = -K (p - anchor) - B v,  K and B with the normal gain along the normal and the tangential
/// gain in both directions across. Acts at the finger, so that momentum and the spring's energy are
/// exact.
[[nodiscard]] inline SpaceContactForces hold(const AttachedSpaceContact& contact,
                                             const Gain& normal, const Gain& tangential,
                                             const PlacedSpaceBody& body,
                                             const SpacePoint& finger) noexcept {
  const FingerInBody at = seen_from(body, finger);
  const Vec3& n = contact.normal_B;
  const Vec3 stretch = at.p_B - contact.anchor_B;
  const double s_n = inner(n, stretch), v_n = inner(n, at.v_B);
  const Vec3 f_B = n * (-normal.stiffness * s_n - normal.damping * v_n) -
                   (stretch - n * s_n) * tangential.stiffness -
                   (at.v_B - n * v_n) * tangential.damping;
  return equal_and_opposite(at.arm_W, body.to_world(f_B));
}

}  // namespace tandem::core
