#include "devices/open_device.h"

#include <stdexcept>
#include <string>

#include "devices/load_recorded_path.h"
#include "devices/recorded_hand.h"
#include "devices/simulated_hand.h"

namespace tandem::devices {
namespace {

template <typename V>
std::unique_ptr<HapticDevice> open_in(const core::Scene& scene, const core::UserParameters& user,
                                      const core::FingerParameters& finger,
                                      const core::DeviceParameters* device) {
  const double T = scene.tick();
  if (device == nullptr || device->kind == core::DeviceKind::kSimulated) {
    return std::make_unique<SimulatedHandDevice<V>>(T, user.mass, finger, device);
  }
  const std::string where = "device \"" + device->name + "\": ";
  if (device->kind != core::DeviceKind::kRecorded) {
    throw std::runtime_error(
        where +
        "kind pointer needs a window, which a node opens (--hands pointer); allowed "
        "here is simulated or recorded");
  }
  if (device->file.empty()) {
    throw std::runtime_error(where +
                             "file is empty; a recorded hand needs FILE or FILE?MAPPING, for "
                             "example hand.csv?time=t_s,x=x_mm:mm");
  }
  try {
    const RecordedSource source = parse_recorded_source(device->file);
    const bool spring = finger.hand.stiffness > 0.0;
    const bool driving = source.mapping.mode == RecordedMode::kDriving ||
                         (source.mapping.mode == RecordedMode::kAutomatic && spring);
    if (driving && !spring) {
      throw std::runtime_error("mode=driving needs a hand spring, and hand.stiffness of finger \"" +
                               finger.name + "\" is 0; set it, or say mode=kinematic");
    }
    auto path =
        std::make_shared<const RecordedPath>(load_recorded_path(source.file, source.mapping));
    if (driving) {
      return std::make_unique<DrivenHandDevice<V>>(T, user.mass, finger, device, std::move(path),
                                                   source.file);
    }
    return std::make_unique<RecordedHandDevice>(T, std::move(path), finger.position, device,
                                                source.file);
  } catch (const std::exception& error) {
    throw std::runtime_error(where + error.what());
  }
}

}  // namespace

std::unique_ptr<HapticDevice> open_device(const core::Scene& scene, int user, int finger) {
  const core::UserParameters& u = scene.users.at(static_cast<std::size_t>(user));
  const core::FingerParameters& f = u.fingers.at(static_cast<std::size_t>(finger));
  const int index = core::index_of(scene.devices, f.device);
  const core::DeviceParameters* device =
      index < 0 ? nullptr : &scene.devices[static_cast<std::size_t>(index)];
  switch (scene.space) {
    case core::Space::kAxis:
      return open_in<double>(scene, u, f, device);
    case core::Space::kPlane:
      return open_in<core::Vec2>(scene, u, f, device);
    case core::Space::kSpace:
      return open_in<core::Vec3>(scene, u, f, device);
  }
  throw std::runtime_error("open_device: unknown space");
}

}  // namespace tandem::devices
