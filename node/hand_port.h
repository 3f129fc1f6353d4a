#pragma once

#include <array>
#include <memory>
#include <utility>
#include <vector>

#include "core/components.h"
#include "core/fault.h"
#include "core/finger_output.h"
#include "core/finite_guard.h"
#include "core/records.h"
#include "core/scene.h"
#include "devices/haptic_device.h"

namespace tandem::node {

/// The devices of one user, one a finger, as the force loop sees them: a hand sample in, forces
/// out. A device without a velocity gets the mean one between its last two samples, 0 at first; a
/// law whose scene declares a cut-off estimates its own. A finger whose device does not answer
/// keeps its last sample, at rest, and says so in the faults.
template <typename V>
class HandPort {
 public:
  HandPort() = default;
  /// Takes the opened devices in the order of the user's fingers; until a device has answered its
  /// finger stays at its initial position.
  HandPort(const core::Scene& scene, int user,
           std::vector<std::unique_ptr<devices::HapticDevice>> opened)
      : devices_(std::move(opened)), T_(scene.tick()) {
    for (std::size_t f = 0; f < devices_.size(); ++f)
      last_[f].p = core::from_vec3<V>(scene.users[user].fingers[f].position);
  }

  [[nodiscard]] const core::HandSample<V>& read(std::int64_t slot, core::Fault& faults) noexcept {
    for (std::size_t f = 0; f < devices_.size(); ++f) {
      devices::DeviceSample sample;
      const devices::DeviceStatus status = devices_[f]->read(slot, sample);
      const bool answered =
          status == devices::DeviceStatus::kOk || status == devices::DeviceStatus::kNoNewSample;
      const V p = core::from_vec3<V>(sample.position);
      V v = core::from_vec3<V>(sample.velocity);
      if (answered && !sample.has_velocity && core::is_finite(p))
        v = status == devices::DeviceStatus::kOk ? difference(f, p, slot) : last_[f].v;
      if (!answered || !core::is_finite(p) || !core::is_finite(v)) {
        faults |= core::Fault::kDeviceRead;
        last_[f].v = V{0.0};
        continue;
      }
      last_[f] = {p, v};
    }
    return last_;
  }

  void write(const core::FingerOutput<V>& output, core::Fault& faults) noexcept {
    for (std::size_t f = 0; f < devices_.size(); ++f) {
      const devices::DeviceCommand command{.force = core::to_vec3(output.forces[f])};
      if (devices_[f]->write(command) != devices::DeviceStatus::kOk)
        faults |= core::Fault::kDeviceWrite;
    }
  }

  void stop() noexcept {
    for (auto& device : devices_) device->stop();
  }

  /// What was read and what was commanded in this tick, for the record.
  void note(const core::FingerOutput<V>& output, core::TickRecord& record) const noexcept {
    for (std::size_t f = 0; f < devices_.size(); ++f) {
      record.hands[f] = {core::to_vec3(last_[f].p), core::to_vec3(last_[f].v)};
      record.command[f] = core::to_vec3(output.forces[f]);
    }
  }

  void append_devices(std::vector<devices::HapticDevice*>& all) const {
    for (const auto& device : devices_) all.push_back(device.get());
  }

 private:
  /// Mean velocity since the sample before, however many ticks ago that was.
  [[nodiscard]] V difference(std::size_t f, const V& p, std::int64_t slot) noexcept {
    const Sampled before = std::exchange(sampled_[f], {p, slot});
    if (before.slot < 0 || slot <= before.slot) return V{0.0};
    return (p - before.p) * (1.0 / (T_ * static_cast<double>(slot - before.slot)));
  }

  std::vector<std::unique_ptr<devices::HapticDevice>> devices_;
  core::HandSample<V> last_{};
  double T_ = 0.0;
  struct Sampled {
    V p{0.0};
    std::int64_t slot = -1;  ///< before the first
  };
  std::array<Sampled, core::kMaxFingers> sampled_{};
};

}  // namespace tandem::node
