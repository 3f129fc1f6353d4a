#pragma once

/// Laws and loops show their states to a visitor with these members, in a fixed order:
///   position(V&), velocity(V&), force(V&)   V = double, Vec2 or Vec3, in the world frame
///   angle(double&), angular_velocity(double&)                       plane
///   orientation(Quat&), angular_velocity(Vec3&)                     space
/// The kind tells what a common translation or rotation does to the state; force is what is held or
/// in flight on its way to a hand.
namespace tandem::core {}
