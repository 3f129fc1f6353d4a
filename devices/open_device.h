#pragma once

#include <memory>

#include "core/scene.h"
#include "devices/haptic_device.h"

namespace tandem::devices {

/// Opens the device of a user's finger as the scene describes it. A finger without a device gets an
/// ideal simulated hand. Before the session only; throws std::runtime_error with the device's name,
/// the field and what is allowed.
[[nodiscard]] std::unique_ptr<HapticDevice> open_device(const core::Scene& scene, int user,
                                                        int finger);

}  // namespace tandem::devices
