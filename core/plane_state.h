#pragma once

#include "core/trigonometry.h"
#include "core/vec.h"

namespace tandem::core {

/// Motion of a point in the plane, in the world frame W.
struct PlanePoint {
  Vec2 p{0.0};  ///< position [m]
  Vec2 v{0.0};  ///< velocity [m/s]
};

/// Motion of a rigid body in the plane; p and v are those of its centre of mass.
struct PlaneBody {
  Vec2 p{0.0};         ///< position [m]
  double angle = 0.0;  ///< counter-clockwise, not wrapped [rad]
  Vec2 v{0.0};         ///< velocity [m/s]
  double omega = 0.0;  ///< angular velocity [rad/s]
};

/// Force on a body and torque about its centre, in W.
struct PlaneWrench {
  Vec2 force{0.0};      ///< [N]
  double torque = 0.0;  ///< [N m]

  PlaneWrench& operator+=(const PlaneWrench& other) noexcept {
    force += other.force;
    torque += other.torque;
    return *this;
  }
};

[[nodiscard]] inline PlaneWrench operator+(PlaneWrench a, const PlaneWrench& b) noexcept {
  return a += b;
}

/// Plane cross product a x b, along z.
[[nodiscard]] inline double cross(const Vec2& a, const Vec2& b) noexcept {
  return a.x * b.y - a.y * b.x;
}

/// Plane cross product omega z x r: velocity of the arm r of a body that turns at omega.
[[nodiscard]] inline Vec2 cross(double omega, const Vec2& r) noexcept {
  return {-omega * r.y, omega * r.x};
}

/// A body with the sine and cosine of its angle, taken once a tick and used by all its contacts.
struct PlacedBody : PlaneBody {
  SinCos turn;

  PlacedBody(const PlaneBody& body) noexcept  // implicit: a body can be given where it is placed
      : PlaneBody(body), turn(sin_cos(body.angle)) {}

  /// A vector of the body frame B in W, and back.
  [[nodiscard]] Vec2 to_world(const Vec2& a_B) const noexcept {
    return {turn.cos * a_B.x - turn.sin * a_B.y, turn.sin * a_B.x + turn.cos * a_B.y};
  }
  [[nodiscard]] Vec2 to_body(const Vec2& a_W) const noexcept {
    return {turn.cos * a_W.x + turn.sin * a_W.y, -turn.sin * a_W.x + turn.cos * a_W.y};
  }
};

}  // namespace tandem::core
