#include "node/open_hands.h"

#include <stdexcept>

#include "core/plane_world.h"
#include "core/simulated_hand.h"

namespace tandem::node {
namespace {
template <typename V>
class Simulated final : public devices::HapticDevice {
 public:
  Simulated(const core::Scene& s, const core::UserParameters& u, const core::FingerParameters& f,
            const core::DeviceParameters& d)
      : hand_(s.tick(), u.mass, f, &d) {
    info_.max_force = d.max_force;
    quant_ = d.encoder_step > 0;
  }
  const devices::DeviceInfo& info() const noexcept override { return info_; }
  devices::DeviceStatus read(std::int64_t slot, devices::DeviceSample& sample) noexcept override {
    for (; slot_ < slot; ++slot_) hand_.step(force_, slot_);
    const auto s = hand_.sample();
    sample.position = core::to_vec3(s.p);
    sample.velocity = core::to_vec3(s.v);
    sample.has_velocity = !quant_;
    return devices::DeviceStatus::kOk;
  }
  devices::DeviceStatus write(const devices::DeviceCommand& c) noexcept override {
    force_ = core::from_vec3<V>(c.force);
    return devices::DeviceStatus::kOk;
  }
  void stop() noexcept override { force_ = V{0.0}; }

 private:
  core::SimulatedHand<V> hand_;
  devices::DeviceInfo info_;
  V force_{0.0};
  bool quant_ = false;
  std::int64_t slot_ = 0;
};
}  // namespace

OpenedDevices open_hands(core::Scene& scene, int user, const HandOptions&) {
  OpenedDevices out;
  const auto& u = scene.users[user];
  for (const auto& f : u.fingers) {
    const auto& d = scene.devices.at(core::index_of(scene.devices, f.device));
    if (scene.space == core::Space::kAxis)
      out.push_back(std::make_unique<Simulated<double>>(scene, u, f, d));
    else
      out.push_back(std::make_unique<Simulated<core::Vec2>>(scene, u, f, d));
  }
  return out;
}

}  // namespace tandem::node
