#include "node/open_hands.h"

#include <stdexcept>

#include "devices/framed_device.h"
#include "devices/load_recorded_path.h"
#include "devices/open_device.h"
#include "devices/pointer_hand.h"
#include "node/led_hand.h"

namespace tandem::node {
namespace {

/// The smaller limit of two, where 0 is none.
[[nodiscard]] double smaller_limit(double a, double b) {
  if (a <= 0.0) return b;
  return b <= 0.0 || a < b ? a : b;
}

template <typename V>
std::unique_ptr<devices::HapticDevice> open_led(const core::Scene& scene,
                                                const core::UserParameters& user,
                                                const core::FingerParameters& finger,
                                                const HandOptions& hands) {
  if (finger.hand.stiffness <= 0.0)
    throw std::runtime_error("finger \"" + finger.name + "\" of user " + user.name +
                             ": hand.stiffness is 0; to follow a recording it needs a hand spring");
  const int d = core::index_of(scene.devices, finger.device);
  auto path = std::make_shared<const devices::RecordedPath>(
      devices::load_recorded_path(hands.file, devices::parse_column_mapping(hands.columns)));
  return std::make_unique<LedHandDevice<V>>(scene.tick(), user.mass, finger,
                                            d < 0 ? nullptr : &scene.devices[d], std::move(path),
                                            *hands.after, hands.file);
}

template <typename V>
std::unique_ptr<devices::HapticDevice> open_pointer(const core::Scene& scene,
                                                    const core::UserParameters& user, int f,
                                                    devices::PointerFeed& feed) {
  const core::FingerParameters& finger = user.fingers[f];
  if (finger.hand.stiffness <= 0.0)
    throw std::runtime_error("finger \"" + finger.name + "\" of user " + user.name +
                             ": hand.stiffness is 0; a pointer leads a hand by its spring: give it "
                             "one, for example 300 N/m");
  const int d = core::index_of(scene.devices, finger.device);
  return std::make_unique<devices::PointerHandDevice<V>>(
      scene.tick(), user.mass, finger, d < 0 ? nullptr : &scene.devices[d], feed, f);
}

std::unique_ptr<devices::HapticDevice> open_one(core::Scene& scene, int user, int f,
                                                const HandOptions& hands) {
  const core::UserParameters& u = scene.users[user];
  const core::FingerParameters& finger = u.fingers[f];
  const int d = core::index_of(scene.devices, finger.device);
  const bool is_pointer = d >= 0 && scene.devices[d].kind == core::DeviceKind::kPointer;
  if (hands.pointer != nullptr && (is_pointer || !hands.recorded)) {
    switch (scene.space) {
      case core::Space::kAxis:
        return open_pointer<double>(scene, u, f, *hands.pointer);
      case core::Space::kPlane:
        return open_pointer<core::Vec2>(scene, u, f, *hands.pointer);
      case core::Space::kSpace:
        return open_pointer<core::Vec3>(scene, u, f, *hands.pointer);
    }
  }
  if (is_pointer)
    throw std::runtime_error(
        "device \"" + scene.devices[d].name +
        "\": kind POINTER needs a window: start this node with --hands pointer");
  if (!hands.recorded) return devices::open_device(scene, user, f);
  if (hands.after) {
    switch (scene.space) {
      case core::Space::kAxis:
        return open_led<double>(scene, u, finger, hands);
      case core::Space::kPlane:
        return open_led<core::Vec2>(scene, u, finger, hands);
      case core::Space::kSpace:
        return open_led<core::Vec3>(scene, u, finger, hands);
    }
  }
  if (d < 0)
    throw std::runtime_error("finger \"" + finger.name + "\" of user " + u.name +
                             " names no device; --hands recorded needs one, for its force limit");
  scene.devices[d].kind = core::DeviceKind::kRecorded;
  scene.devices[d].file = hands.file + (hands.columns.empty() ? "" : "?" + hands.columns);
  return devices::open_device(scene, user, f);
}

/// A frame for a device that nobody has is a misspelt one.
void check_frames(const core::Scene& scene, const HandOptions& hands) {
  for (const auto& [name, frame] : hands.frames) {
    if (core::index_of(scene.devices, name) >= 0) continue;
    std::string known;
    for (const core::DeviceParameters& d : scene.devices)
      known += (known.empty() ? "" : ", ") + d.name;
    throw std::runtime_error("common_from_device: scene " + scene.name + " has no device \"" +
                             name + "\"; it has " + (known.empty() ? "none" : known));
  }
}

}  // namespace

OpenedDevices open_hands(core::Scene& scene, int user, const HandOptions& hands) {
  check_frames(scene, hands);
  OpenedDevices opened;
  const core::UserParameters& u = scene.users[user];
  for (std::size_t f = 0; f < u.fingers.size(); ++f) {
    const core::FingerParameters& finger = u.fingers[f];
    const int d = core::index_of(scene.devices, finger.device);
    auto device = open_one(scene, user, static_cast<int>(f), hands);
    const auto frame = hands.frames.find(finger.device);
    if (frame != hands.frames.end() && d >= 0 &&
        scene.devices[d].kind == core::DeviceKind::kRecorded)
      device = std::make_unique<devices::FramedDevice>(std::move(device), frame->second);
    const devices::DeviceInfo& info = device->info();
    const double max_force =
        smaller_limit(d < 0 ? 0.0 : scene.devices[d].max_force, info.max_force);
    if (max_force <= 0.0)
      throw std::runtime_error(
          "finger \"" + finger.name + "\" of user " + u.name + ": nothing limits the force of " +
          (d < 0 ? std::string("its device, which the scene does not name")
                 : "device \"" + finger.device + "\"") +
          "; a node needs max_force > 0 [N] there. In a copy of the scene: device { name: "
          "\"d\"  kind: SIMULATED  max_force: 10 }, and in the finger device: "
          "\"d\"");
    if (d < 0)
      throw std::runtime_error("finger \"" + finger.name + "\" of user " + u.name +
                               " names no device, and the law guards with the limits of the one "
                               "that is named: give it one");
    scene.devices[d].max_force = max_force;
    scene.devices[d].max_slew = smaller_limit(scene.devices[d].max_slew, info.max_slew);
    opened.push_back(std::move(device));
  }
  return opened;
}

}  // namespace tandem::node
