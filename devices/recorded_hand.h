#pragma once

#include <atomic>
#include <cmath>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>

#include "devices/haptic_device.h"
#include "devices/recorded_path.h"
#include "devices/simulated_hand.h"

namespace tandem::devices {

/// Kinematic recorded hand: where the recording says, whatever force is commanded. Its position at
/// a slot is home + path(slot T): the same in every run. A command is taken and has no effect.
class RecordedHandDevice final : public HapticDevice {
 public:
  RecordedHandDevice(double T, std::shared_ptr<const RecordedPath> path, const Vec3& home,
                     const core::DeviceParameters* device, std::string name)
      : T_(T), path_(std::move(path)), home_(home) {
    info_.name = "recorded hand " + std::move(name);
    info_.sample_rate_hz = path_->mean_rate_hz();
    if (device == nullptr) return;
    info_.max_force = device->max_force;
    info_.max_slew = device->max_slew;
    info_.resolution = device->encoder_step;
  }

  [[nodiscard]] const DeviceInfo& info() const noexcept override { return info_; }

  [[nodiscard]] DeviceStatus read(std::int64_t slot, DeviceSample& sample) noexcept override {
    const RecordedPath::Motion motion = path_->at(static_cast<double>(slot) * T_);
    sample = DeviceSample{};
    sample.position = home_ + motion.position;
    if (info_.resolution > 0.0) {
      sample.position = glm::floor(sample.position / info_.resolution + 0.5) * info_.resolution;
    } else {
      sample.velocity = motion.velocity;
      sample.has_velocity = true;
    }
    return DeviceStatus::kOk;
  }

  [[nodiscard]] DeviceStatus write(const DeviceCommand& command) noexcept override {
    if (stopped_.load(std::memory_order_relaxed)) return DeviceStatus::kStopped;
    const bool finite = std::isfinite(command.force.x) && std::isfinite(command.force.y) &&
                        std::isfinite(command.force.z);
    return finite ? DeviceStatus::kOk : DeviceStatus::kNotFinite;
  }

  void stop() noexcept override { stopped_.store(true, std::memory_order_relaxed); }

 private:
  double T_;
  std::shared_ptr<const RecordedPath> path_;
  Vec3 home_;
  DeviceInfo info_;
  std::atomic<bool> stopped_{false};
};

/// Driving recorded hand: a simulated hand whose spring and damper follow initial position +
/// path(slot T), so it yields to the commanded force as a person would. The finger's own intended
/// path is replaced, its intended force stays.
template <typename V>
class DrivenHandDevice final : public SimulatedHandDevice<V> {
 public:
  DrivenHandDevice(double T, double mass, const core::FingerParameters& finger,
                   const core::DeviceParameters* device, std::shared_ptr<const RecordedPath> path,
                   std::string name)
      : SimulatedHandDevice<V>(T, mass, without_path(finger), device),
        T_(T),
        stiffness_(finger.hand.stiffness),
        damping_(finger.hand.damping),
        path_(std::move(path)) {
    this->info_.name = "simulated hand driven by " + std::move(name);
  }

 private:
  /// The law's spring pulls to the initial position; to pull to the recording instead, add
  ///   K r + B r'    with r, r' its displacement and velocity.
  void before_step(core::SimulatedHand<V>& hand, std::int64_t slot) noexcept override {
    const RecordedPath::Motion motion = path_->at(static_cast<double>(slot) * T_);
    hand.set_external_force(core::from_vec3<V>(motion.position) * stiffness_ +
                            core::from_vec3<V>(motion.velocity) * damping_);
  }

  static core::FingerParameters without_path(core::FingerParameters finger) {
    finger.intent.path.clear();
    finger.intent.path_sines.clear();
    return finger;
  }

  double T_, stiffness_, damping_;
  std::shared_ptr<const RecordedPath> path_;
};

}  // namespace tandem::devices
