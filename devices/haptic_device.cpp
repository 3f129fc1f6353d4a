#include "devices/haptic_device.h"

namespace tandem::devices {

const char* to_string(DeviceStatus status) noexcept {
  switch (status) {
    case DeviceStatus::kOk:
      return "ok";
    case DeviceStatus::kNoNewSample:
      return "no new sample";
    case DeviceStatus::kNotFinite:
      return "not finite";
    case DeviceStatus::kStopped:
      return "stopped";
    case DeviceStatus::kDisconnected:
      return "disconnected";
    case DeviceStatus::kFault:
      return "device fault";
  }
  return "unknown";
}

}  // namespace tandem::devices
