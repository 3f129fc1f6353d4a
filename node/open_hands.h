#pragma once

#include <memory>
#include <vector>

#include "core/scene.h"
#include "devices/haptic_device.h"
#include "node/node_options.h"

namespace tandem::node {

using OpenedDevices = std::vector<std::unique_ptr<devices::HapticDevice>>;

/// Opens the device of each finger of a user, in order. The limits of each in `scene` become the
/// smaller of the scene's and the device's own, so that the law guards with them.
/// @throws std::runtime_error  no such device, cannot be opened, a force that nothing limits
[[nodiscard]] OpenedDevices open_hands(core::Scene& scene, int user, const HandOptions& hands);

}  // namespace tandem::node
