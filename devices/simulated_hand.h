#pragma once

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <string>

#include "core/components.h"
#include "core/scene.h"
#include "core/simulated_hand.h"
#include "devices/haptic_device.h"

namespace tandem::devices {

/// A device that is not there: core's simulated hand, moved by the commanded force in real time.
/// The command is held over skipped slots too, as real motors would hold it. V is double, Vec2 or
/// Vec3; coordinates a space lacks are 0. The hand starts in the slot of the first read.
template <typename V>
class SimulatedHandDevice : public HapticDevice {
 public:
  /// `device` may be null: no limits, exact position.
  SimulatedHandDevice(double T, double mass, const core::FingerParameters& finger,
                      const core::DeviceParameters* device)
      : law_(T, mass, finger, device), exact_(device == nullptr || device->encoder_step <= 0.0) {
    info_.name = "simulated hand";
    info_.position_dof = info_.force_dof = core::kComponents<V>;
    info_.sample_rate_hz = 1.0 / T;
    if (device == nullptr) return;
    info_.max_force = device->max_force;
    info_.max_slew = device->max_slew;
    info_.resolution = device->encoder_step;
  }

  [[nodiscard]] const DeviceInfo& info() const noexcept override { return info_; }

  [[nodiscard]] DeviceStatus read(std::int64_t slot, DeviceSample& sample) noexcept override {
    if (!started_) {
      started_ = true;
      slot_ = slot;
    }
    if (stopped_.load(std::memory_order_relaxed)) force_ = V{0.0};
    // After a long silence (a suspended computer) the hand does not live through all of it.
    slot_ = std::max(slot_, slot - kMaxCatchUp);
    for (; slot_ < slot; ++slot_) {
      before_step(law_, slot_);
      law_.step(force_, slot_);
    }
    const auto hand = law_.sample();
    sample = DeviceSample{};
    sample.position = core::to_vec3(hand.p);
    sample.velocity = core::to_vec3(hand.v);
    sample.has_velocity = exact_;
    return DeviceStatus::kOk;
  }

  [[nodiscard]] DeviceStatus write(const DeviceCommand& command) noexcept override {
    if (stopped_.load(std::memory_order_relaxed)) return DeviceStatus::kStopped;
    const V force = core::from_vec3<V>(command.force);
    for (int i = 0; i < core::kComponents<V>; ++i) {
      if (!std::isfinite(core::component(force, i))) {
        force_ = V{0.0};
        return DeviceStatus::kNotFinite;
      }
    }
    force_ = force;
    return DeviceStatus::kOk;
  }

  void stop() noexcept override { stopped_.store(true, std::memory_order_relaxed); }

 protected:
  /// Called before each step of the hand, on the force thread.
  virtual void before_step(core::SimulatedHand<V>& /*hand*/, std::int64_t /*slot*/) noexcept {}
  DeviceInfo info_;

 private:
  static constexpr std::int64_t kMaxCatchUp = 4096;  // slots; about 0.2 ms of work

  core::SimulatedHand<V> law_;
  V force_{0.0};
  std::int64_t slot_ = 0;
  bool started_ = false;
  bool exact_;
  std::atomic<bool> stopped_{false};
};

}  // namespace tandem::devices
