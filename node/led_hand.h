#pragma once

#include <memory>
#include <string>
#include <utility>

#include "devices/recorded_path.h"
#include "devices/simulated_hand.h"

namespace tandem::node {

/// A simulated hand that does what the scene's script says and, from a given time on, also follows
/// a recorded motion: the script grasps and lets go, the recording carries. Its target is
///   script(t) + r(t - t0) - r(0),   the script alone before t0.
template <typename V>
class LedHandDevice final : public devices::SimulatedHandDevice<V> {
 public:
  LedHandDevice(double T, double mass, const core::FingerParameters& finger,
                const core::DeviceParameters* device,
                std::shared_ptr<const devices::RecordedPath> path, double t0,
                const std::string& name)
      : devices::SimulatedHandDevice<V>(T, mass, finger, device),
        T_(T),
        t0_(t0),
        stiffness_(finger.hand.stiffness),
        damping_(finger.hand.damping),
        path_(std::move(path)),
        first_(path_->at(0.0).position) {
    this->info_.name = "simulated hand led by " + name;
  }

 private:
  /// The hand's spring pulls to the script; to pull to both, add K r + B r'.
  void before_step(core::SimulatedHand<V>& hand, std::int64_t slot) noexcept override {
    const double t = static_cast<double>(slot) * T_ - t0_;
    if (t < 0.0) return;
    const devices::RecordedPath::Motion motion = path_->at(t);
    hand.set_external_force(core::from_vec3<V>(motion.position - first_) * stiffness_ +
                            core::from_vec3<V>(motion.velocity) * damping_);
  }

  double T_, t0_, stiffness_, damping_;
  std::shared_ptr<const devices::RecordedPath> path_;
  core::Vec3 first_;
};

}  // namespace tandem::node
