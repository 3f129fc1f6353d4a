#pragma once

#include <array>

#include "core/latest_value.h"
#include "core/scene.h"

namespace tandem::devices {

/// Where a pointer (mouse, keyboard, pinch) wants a user's fingers to be.
struct PointerTargets {
  std::array<core::Vec3, core::kMaxFingers> fingers{};  ///< [m], in W
};

/// From the window's thread to whoever steps the hands: one reader a finger, each on any thread.
class PointerFeed {
 public:
  /// Window's thread.
  void publish(const PointerTargets& targets) noexcept {
    for (auto& box : boxes_) box.publish(targets);
  }
  /// That finger's reader; false, and `target` untouched, if the pointer has not moved since.
  [[nodiscard]] bool fetch(int finger, core::Vec3& target) noexcept {
    PointerTargets targets;
    if (!boxes_[static_cast<std::size_t>(finger)].fetch(targets)) return false;
    target = targets.fingers[static_cast<std::size_t>(finger)];
    return true;
  }

 private:
  std::array<core::LatestValue<PointerTargets>, core::kMaxFingers> boxes_;
};

/// A pointer moves in steps, sixty a second or fewer; a hand does not. Critically damped follower
///   x'' = w^2 (u - x) - 2 w x',   w = 60 rad/s: 33 ms behind a steady motion
/// stepped by semi-implicit Euler (w T = 0.06: damped at 1 kHz and down to 60 Hz).
/// Starts at rest at the given place; until the pointer speaks it stays there.
class PointerFollower {
 public:
  PointerFollower() noexcept = default;
  explicit PointerFollower(const core::Vec3& start) noexcept : x_(start), u_(start) {}

  void aim(const core::Vec3& target) noexcept { u_ = target; }
  void step(double T) noexcept {
    constexpr double w = 60.0;  // [rad/s]
    v_ += ((u_ - x_) * (w * w) - v_ * (2.0 * w)) * T;
    x_ += v_ * T;
  }
  [[nodiscard]] const core::Vec3& position() const noexcept { return x_; }
  [[nodiscard]] const core::Vec3& velocity() const noexcept { return v_; }

 private:
  core::Vec3 x_{0.0}, v_{0.0}, u_{0.0};
};

}  // namespace tandem::devices
