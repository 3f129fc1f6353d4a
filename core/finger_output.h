#pragma once

#include <array>

#include "core/delay_line.h"
#include "core/fault.h"
#include "core/finger_sample.h"
#include "core/force_guard.h"
#include "core/scene.h"
#include "core/site_state.h"
#include "core/velocity_estimate.h"

namespace tandem::core {

/// What a law hands to the devices: one force a finger, already guarded, and what went wrong.
template <typename V>
struct FingerOutput {
  std::array<V, kMaxFingers> forces{};
  Fault faults = Fault::kNone;
};

/// The first and the last stage of every hand's tick, each there only where the scene declares it:
/// velocity from quantised positions on the way in, limits on the way out.
template <typename V>
class FingerStages {
 public:
  FingerStages() noexcept = default;
  FingerStages(const Scene& scene, int user) noexcept {
    const UserParameters& u = scene.users[user];
    for (std::size_t f = 0; f < u.fingers.size(); ++f) {
      const int d = index_of(scene.devices, u.fingers[f].device);
      if (d < 0) continue;
      const DeviceParameters& device = scene.devices[d];
      // Quantised positions come without a velocity of their own.
      if (device.velocity_cutoff_hz > 0.0 || device.encoder_step > 0.0) {
        estimates_[f] = VelocityEstimate<V>(device.velocity_cutoff_hz, scene.tick());
        estimated_[f] = true;
      }
      guards_[f] = ForceGuard<V>(device.max_force, device.max_slew, scene.tick());
      guarded_[f] = device.max_force > 0.0 || device.max_slew > 0.0;
    }
  }

  void observe(const HandSample<V>& raw, int fingers, HandSample<V>& out) noexcept {
    for (int f = 0; f < fingers; ++f) {
      out[f] = raw[f];
      if (estimated_[f]) out[f].v = estimates_[f].update(raw[f].p);
    }
  }

  void guard(FingerOutput<V>& output, int fingers) noexcept {
    for (int f = 0; f < fingers; ++f)
      if (guarded_[f]) output.forces[f] = guards_[f].pass(output.forces[f], output.faults);
  }

  /// Visits the velocity estimates; what the guard remembers matters only beyond its limits.
  template <typename Visitor>
  void visit_state(int fingers, Visitor&& visitor) {
    for (int f = 0; f < fingers; ++f)
      if (estimated_[f]) estimates_[f].visit_state(visitor);
  }

 private:
  std::array<VelocityEstimate<V>, kMaxFingers> estimates_{};
  std::array<ForceGuard<V>, kMaxFingers> guards_{};
  std::array<bool, kMaxFingers> estimated_{}, guarded_{};
};

/// Computation delay z^-1 of Fig 3.1: forces of couplers act `ticks` later, on hand and object
/// alike. Zero ticks: nothing is stored.
template <typename V, typename Wrench>
class Latency {
 public:
  Latency() noexcept = default;
  explicit Latency(int ticks) noexcept {
    if (ticks == 0) return;
    active_ = true;
    forces_.fill(DelayLine<V, kMaxLatencyTicks>(ticks, V{0.0}));
    wrenches_.fill(DelayLine<Wrench, kMaxLatencyTicks>(ticks, Wrench{}));
  }

  [[nodiscard]] Wrench delayed(int object, const Wrench& wrench) noexcept {
    return active_ ? wrenches_[object].push(wrench) : wrench;
  }
  void delay(FingerOutput<V>& output, int fingers) noexcept {
    if (!active_) return;
    for (int f = 0; f < fingers; ++f) output.forces[f] = forces_[f].push(output.forces[f]);
  }

  template <typename Visitor>
  void visit_state(const SiteCounts& counts, Visitor&& visitor) {
    if (!active_) return;
    for (int f = 0; f < counts.fingers; ++f)
      forces_[f].visit_state([&](V& force) { visitor.force(force); });
    for (int o = 0; o < counts.objects; ++o)
      wrenches_[o].visit_state([&](Wrench& w) { visitor.wrench(w); });
  }

 private:
  bool active_ = false;
  std::array<DelayLine<V, kMaxLatencyTicks>, kMaxFingers> forces_{};
  std::array<DelayLine<Wrench, kMaxLatencyTicks>, kMaxObjects> wrenches_{};
};

}  // namespace tandem::core
