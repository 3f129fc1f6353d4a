#pragma once

#include <array>
#include <cstdint>

#include "core/box_faces.h"
#include "core/contact_law.h"
#include "core/mean_contact.h"
#include "core/plane_state.h"

/// Who touches whom in the plane: fingers against the sides of a box (thesis 7.2.1), corners of a
/// box and fingers against walls. All use the one law of core/contact_law.h.
namespace tandem::core {

struct PlaneBox {
  Vec2 half{0.0};              ///< half edge lengths along the body's axes [m]
  double finger_radius = 0.0;  ///< of the fingers that touch it; 0 is a point [m]
};

/// A half plane that nothing may enter; `normal` is a unit vector to the free side.
struct PlaneWall {
  Vec2 point{0.0};
  Vec2 normal{0.0, 1.0};
  ContactGains gains;
};

/// One finger against one box, from tick to tick. Default: never seen.
struct FingerBoxContact {
  ContactMemory<double> memory;
  Vec2 before_B{0.0};     ///< finger in the body frame at the last tick [m]
  std::uint8_t side = 0;  ///< entered face while in contact: 0 +x, 1 -x, 2 +y, 3 -y
  bool seen = false;      ///< before_B is valid
};

struct ContactForces {
  Vec2 on_finger_W{0.0};  ///< [N]
  PlaneWrench on_body;    ///< equal and opposite, torque about the body's centre
};

/// A finger in the frame of a box: where, and how it moves relative to the box's own points.
struct FingerInBox {
  Vec2 arm_W{0.0};
  Vec2 p_B{0.0};
  Vec2 v_B{0.0};
};

[[nodiscard]] inline FingerInBox seen_from(const PlacedBody& body,
                                           const PlanePoint& finger) noexcept {
  const Vec2 arm = finger.p - body.p;
  const Vec2 relative = finger.v - body.v - cross(body.omega, arm);
  return {arm, body.to_body(arm), body.to_body(relative)};
}

/// A finger with radius whose centre has gone past the end of its face and below it has rolled
/// round the corner: it goes on against the neighbouring face, at zero stretch.
[[nodiscard]] inline int round_corner(FingerBoxContact& contact, const PlaneBox& box,
                                      const Vec2& p_B) noexcept {
  const int side = contact.side;
  const int n = side < 2 ? 0 : 1, t = 1 - n;
  const double above = ((side & 1) ? -p_B[n] : p_B[n]) - box.half[n];
  const double beyond = std::fabs(p_B[t]) - box.half[t];
  if (!(beyond > 0.0) || beyond >= box.finger_radius || above > 0.0) return side;
  contact.memory.anchor = p_B[n];
  contact.side = static_cast<std::uint8_t>(2 * t + (p_B[t] < 0.0 ? 1 : 0));
  return contact.side;
}

/// One tick of a finger against a box. The face is that through which the finger came; it stays
/// until the finger leaves through it or slides off its end, however deep it is pressed. The first
/// tick has no past: a finger found inside takes the nearest face.
///
/// A finger with radius touches a rounded corner with a normal that turns from one face to the
/// next. Forces act at the finger's centre, where its motion is measured: then the spring's energy
/// is a function of the finger's place in the box alone and rotation of the box is accounted
/// exactly (the finger is a pad that turns with the box: no rolling).
[[nodiscard, gnu::always_inline]] inline ContactForces touch(
    FingerBoxContact& contact, const ContactGains& gains, const PlaneBox& box,
    const PlacedBody& body, const PlanePoint& finger, double T) noexcept {
  const FingerInBox at = seen_from(body, finger);
  const Vec2 before = contact.before_B;
  const bool seen = contact.seen;
  contact.before_B = at.p_B;
  contact.seen = true;

  const double radius = box.finger_radius;
  const Vec2 reach{box.half.x + radius, box.half.y + radius};
  const bool inside = std::fabs(at.p_B.x) < reach.x && std::fabs(at.p_B.y) < reach.y;
  int side = contact.side;
  if (contact.memory.state == ContactState::kFree) {
    const bool was_inside = std::fabs(before.x) < reach.x && std::fabs(before.y) < reach.y;
    if (!seen || was_inside)
      side = inside ? nearest_face(reach, at.p_B) : -1;
    else
      side = entered_face(reach, before, at.p_B);
    if (side < 0) return {};
    contact.side = static_cast<std::uint8_t>(side);
  }
  if (radius > 0.0) side = round_corner(contact, box, at.p_B);

  // Side frame: outward n along one body axis, t along the other; a is the signed direction of n.
  const bool along_x = side < 2;
  const double a = (side & 1) ? -1.0 : 1.0;
  const double height = a * (along_x ? at.p_B.x : at.p_B.y);
  const double along = along_x ? at.p_B.y : at.p_B.x;
  const double half_n = along_x ? box.half.x : box.half.y;
  const double half_t = along_x ? box.half.y : box.half.x;
  const double rise = a * (along_x ? at.v_B.x : at.v_B.y);
  const double slip = along_x ? at.v_B.y : at.v_B.x;

  SurfaceMotion<double> motion{half_n + radius - height, rise, along, slip};
  double n_n = 1.0, n_t = 0.0;  // outward normal in the side frame
  const double beyond = std::fabs(along) - half_t;
  if (beyond > 0.0) {
    const double above = height - half_n;
    if (beyond >= radius) {
      motion.depth = 0.0;  // slid off the end
    } else if (above > 0.0) {
      const double distance = std::sqrt(above * above + beyond * beyond);
      n_n = above / distance;
      n_t = (along < 0.0 ? -beyond : beyond) / distance;
      motion.depth = radius - distance;
      motion.normal_velocity = n_n * rise + n_t * slip;
      motion.velocity = n_n * slip - n_t * rise;
    }
  }

  const SurfaceForce<double> f = press(contact.memory, gains, motion, T);
  if (contact.memory.state == ContactState::kFree) return {};
  const double f_n = a * (n_n * f.normal - n_t * f.tangential);
  const double f_t = n_t * f.normal + n_n * f.tangential;
  const Vec2 on_finger = body.to_world(along_x ? Vec2{f_n, f_t} : Vec2{f_t, f_n});
  return {on_finger, {-on_finger, -cross(at.arm_W, on_finger)}};
}

/// A finger fixed to a box by a bilateral spring and damper at a point of the box: no contact test,
/// no cone, no pulses. Linearised grasps use it.
struct AttachedContact {
  Vec2 anchor_B{0.0};       ///< the fixed point, body frame [m]
  Vec2 normal_B{1.0, 0.0};  ///< unit vector, direction of the normal gain
};

/// Attaches a finger where it is now, at zero stretch, normal to the nearest face.
[[nodiscard]] inline AttachedContact attach(const PlaneBox& box, const PlacedBody& body,
                                            const PlanePoint& finger) noexcept {
  const Vec2 p_B = body.to_body(finger.p - body.p);
  const int side = nearest_face(box.half, p_B);
  const double sign = (side & 1) ? -1.0 : 1.0;
  return {p_B, side < 2 ? Vec2{sign, 0.0} : Vec2{0.0, sign}};
}

/// One tick of an attached finger; in the frame of the box,
///   f = -K (p - anchor) - B v,  K and B diagonal along normal and tangent.
/// Acts at the finger, so that momentum and the spring's energy are exact.
[[nodiscard]] inline ContactForces hold(const AttachedContact& contact, const Gain& normal,
                                        const Gain& tangential, const PlacedBody& body,
                                        const PlanePoint& finger) noexcept {
  const FingerInBox at = seen_from(body, finger);
  const Vec2 n = contact.normal_B, t{-n.y, n.x};
  const Vec2 stretch = at.p_B - contact.anchor_B;
  const double f_n = -normal.stiffness * inner(n, stretch) - normal.damping * inner(n, at.v_B);
  const double f_t =
      -tangential.stiffness * inner(t, stretch) - tangential.damping * inner(t, at.v_B);
  const Vec2 on_finger = body.to_world(Vec2{n.x * f_n + t.x * f_t, n.y * f_n + t.y * f_t});
  return {on_finger, {-on_finger, -cross(at.arm_W, on_finger)}};
}

/// The four corners of one box against one wall; corner i is at (+ +), (- +), (- -), (+ -).
struct WallContacts {
  std::array<ContactMemory<double>, 4> corner;
  bool any = false;  ///< a corner touched at the last tick
};

/// A point that moves against a standing wall.
[[nodiscard]] inline Vec2 against(ContactMemory<double>& memory, const PlaneWall& wall,
                                  double depth, const Vec2& p, const Vec2& v, double T) noexcept {
  const Vec2 n = wall.normal, t{-n.y, n.x};
  const SurfaceForce<double> f = press(
      memory, wall.gains, SurfaceMotion<double>{depth, inner(n, v), inner(t, p), inner(t, v)}, T);
  return {n.x * f.normal + t.x * f.tangential, n.y * f.normal + t.y * f.tangential};
}

/// One tick of a box against a wall: the same four states at each corner (thesis 7.2.2), the wall
/// takes the part of the surface and the corner that of the finger. Costs one projection while the
/// box is clear of the wall. Contact gains' mass is that of the box where pulses are wanted.
/// `within_tick`: the force is the tick's mean (core/mean_contact.h), otherwise that of its start.
[[nodiscard]] inline PlaneWrench hold_back(WallContacts& contacts, const PlaneWall& wall,
                                           const PlaneBox& box, const PlacedBody& body, double T,
                                           bool within_tick = false) noexcept {
  const Vec2& n = wall.normal;
  const Vec2 n_B = body.to_body(n);
  const double clearance = inner(n, body.p - wall.point);
  const double a = n_B.x * box.half.x, b = n_B.y * box.half.y;
  double soon = 0.0;  // how far a corner may get in this tick
  if (within_tick) {
    const double approach = std::fabs(body.omega) * (box.half.x + box.half.y) - inner(n, body.v);
    if (approach > 0.0) soon = approach * T;
  }
  if (clearance - soon >= std::fabs(a) + std::fabs(b)) {
    if (contacts.any) contacts = {};
    return {};
  }
  constexpr double kSignX[4] = {1.0, -1.0, -1.0, 1.0};
  constexpr double kSignY[4] = {1.0, 1.0, -1.0, -1.0};
  const Vec2 edge_x = body.to_world({box.half.x, 0.0}), edge_y = body.to_world({0.0, box.half.y});
  PlaneWrench wrench;
  for (int i = 0; i < 4; ++i) {
    double depth = -(clearance + kSignX[i] * a + kSignY[i] * b);
    if (!(depth + soon > 0.0)) {
      contacts.corner[i].state = ContactState::kFree;
      continue;
    }
    const Vec2 arm = edge_x * kSignX[i] + edge_y * kSignY[i];
    const Vec2 turning = cross(body.omega, arm);
    Vec2 v = body.v + turning, lever = arm;
    if (within_tick) {
      const double rise = inner(n, v);
      const MeanContact mean = mean_contact(depth, rise, T);
      depth = mean.depth;
      v += n * (mean.normal_velocity - rise);
      lever += turning * (0.5 * T);
    }
    const Vec2 f = against(contacts.corner[i], wall, depth, body.p + arm, v, T);
    wrench.force += f;
    wrench.torque += cross(lever, f);
  }
  contacts.any = true;
  return wrench;
}

/// One tick of a finger against a wall; force on the finger.
[[nodiscard]] inline Vec2 hold_back(ContactMemory<double>& memory, const PlaneWall& wall,
                                    const PlanePoint& finger, double radius, double T) noexcept {
  const double depth = radius - inner(wall.normal, finger.p - wall.point);
  if (!(depth > 0.0)) {
    memory.state = ContactState::kFree;
    return Vec2{0.0};
  }
  return against(memory, wall, depth, finger.p, finger.v, T);
}

}  // namespace tandem::core
