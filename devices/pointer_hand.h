#pragma once

#include <string>

#include "devices/pointer_feed.h"
#include "devices/simulated_hand.h"

namespace tandem::devices {

/// A finger that a pointer leads. A mouse cannot push back, so the hand between it and the scene is
/// simulated: the finger's spring and damper pull it to where the pointer is, and it yields to the
/// force as a finger would; the window shows the force. The scene's own path is not used, nor is
/// its intended force.
template <typename V>
class PointerHandDevice final : public SimulatedHandDevice<V> {
 public:
  /// `index`: of the finger; `feed` must live longer.
  PointerHandDevice(double T, double mass, const core::FingerParameters& finger,
                    const core::DeviceParameters* device, PointerFeed& feed, int index)
      : SimulatedHandDevice<V>(T, mass, without_intent(finger), device),
        T_(T),
        stiffness_(finger.hand.stiffness),
        damping_(finger.hand.damping),
        home_(finger.position),
        follower_(finger.position),
        feed_(feed),
        index_(index) {
    this->info_.name = "pointer";
  }

 private:
  /// The law's spring pulls to the initial position; to pull to the pointer add K r + B r'.
  void before_step(core::SimulatedHand<V>& hand, std::int64_t) noexcept override {
    core::Vec3 target{0.0};
    if (feed_.fetch(index_, target)) follower_.aim(target);
    follower_.step(T_);
    hand.set_external_force(core::from_vec3<V>(follower_.position() - home_) * stiffness_ +
                            core::from_vec3<V>(follower_.velocity()) * damping_);
  }

  static core::FingerParameters without_intent(core::FingerParameters finger) {
    finger.intent = {};
    return finger;
  }

  double T_, stiffness_, damping_;
  core::Vec3 home_;
  PointerFollower follower_;
  PointerFeed& feed_;
  int index_;
};

}  // namespace tandem::devices
