#pragma once

#include <memory>
#include <utility>

#include "core/rigid.h"
#include "devices/haptic_device.h"

namespace tandem::devices {

/// A device seen from the scene: what it measures in its own frame D comes out in the scene's frame
/// W, what is asked of it in W goes to its motors in D (juggling paper, section 6.3).
///   p_W = t + q p_D,  v_W = q v_D,  f_D = q^-1 f_W
/// so force times velocity is the same in both.
class FramedDevice final : public HapticDevice {
 public:
  FramedDevice(std::unique_ptr<HapticDevice> device, const core::Rigid& scene_from_device)
      : device_(std::move(device)),
        scene_from_device_(scene_from_device),
        back_(glm::conjugate(scene_from_device.q)),
        info_(device_->info()) {
    const Vec3 low = info_.workspace_min, high = info_.workspace_max;
    if (low == high) return;
    // The box around the turned box.
    for (int corner = 0; corner < 8; ++corner) {
      const Vec3 p = scene_from_device_(Vec3{(corner & 1) != 0 ? high.x : low.x,
                                             (corner & 2) != 0 ? high.y : low.y,
                                             (corner & 4) != 0 ? high.z : low.z});
      info_.workspace_min = corner == 0 ? p : glm::min(info_.workspace_min, p);
      info_.workspace_max = corner == 0 ? p : glm::max(info_.workspace_max, p);
    }
  }

  /// Of the device, but its workspace in W.
  [[nodiscard]] const DeviceInfo& info() const noexcept override { return info_; }

  [[nodiscard]] DeviceStatus read(std::int64_t slot, DeviceSample& sample) noexcept override {
    DeviceSample own;
    const DeviceStatus status = device_->read(slot, own);
    if (status != DeviceStatus::kOk && status != DeviceStatus::kNoNewSample) return status;
    sample = own;
    sample.position = scene_from_device_(own.position);
    sample.velocity = scene_from_device_.q * own.velocity;
    sample.orientation = scene_from_device_.q * own.orientation;
    return status;
  }

  [[nodiscard]] DeviceStatus write(const DeviceCommand& command) noexcept override {
    return device_->write({.force = back_ * command.force, .torque = back_ * command.torque});
  }

  void stop() noexcept override { device_->stop(); }

 private:
  std::unique_ptr<HapticDevice> device_;
  core::Rigid scene_from_device_;
  Quat back_;
  DeviceInfo info_;
};

}  // namespace tandem::devices
