#pragma once

#include "core/components.h"
#include "core/space_rotation.h"
#include "core/vec.h"

namespace tandem::core {

/// Motion of a point in the world frame W.
struct SpacePoint {
  Vec3 p{0.0};  ///< position [m]
  Vec3 v{0.0};  ///< velocity [m/s]
};

/// Motion of a rigid body; p and v are those of its centre of mass, the axes of its frame B are its
/// principal axes and, of a box, its edges.
struct SpaceBody {
  Vec3 p{0.0};                 ///< position [m]
  Quat q{1.0, 0.0, 0.0, 0.0};  ///< B to W, unit length
  Vec3 v{0.0};                 ///< velocity [m/s]
  Vec3 omega{0.0};             ///< angular velocity, in W [rad/s]
};

/// Force on a body and torque about its centre, in W.
struct SpaceWrench {
  Vec3 force{0.0};   ///< [N]
  Vec3 torque{0.0};  ///< [N m]

  SpaceWrench& operator+=(const SpaceWrench& other) noexcept {
    force += other.force;
    torque += other.torque;
    return *this;
  }
};

[[nodiscard]] inline SpaceWrench operator+(SpaceWrench a, const SpaceWrench& b) noexcept {
  return a += b;
}

/// A body with its axes, taken once a tick and used by all its contacts.
struct PlacedSpaceBody : SpaceBody {
  Axes axes;

  PlacedSpaceBody(
      const SpaceBody& body) noexcept  // implicit: a body can be given where it is placed
      : SpaceBody(body), axes(axes_of(body.q)) {}

  [[nodiscard]] Vec3 to_world(const Vec3& a_B) const noexcept { return axes.to_world(a_B); }
  [[nodiscard]] Vec3 to_body(const Vec3& a_W) const noexcept { return axes.to_body(a_W); }
};

}  // namespace tandem::core
