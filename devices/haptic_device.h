#pragma once

#include <cstdint>
#include <string>

#include "core/vec.h"

namespace tandem::devices {

using core::Quat;
using core::Vec3;

/// Who decides when the next sample is.
enum class Clocking : std::uint8_t {
  kCaller,  ///< read and write talk to the hardware there and then
  kDevice,  ///< the vendor's thread, or a message stream, owns the servo loop; read and write
            ///< exchange the newest values with it (core::LatestValue) and never wait
};

/// What a device is and can do. Constant after it was opened. 0 means "not known" or "no limit".
struct DeviceInfo {
  std::string name;
  int position_dof = 3;         ///< 1, 2 or 3 translations, 6 with orientation
  int force_dof = 3;            ///< 6: torques too
  double max_force = 0.0;       ///< what the motors may be asked for [N]
  double max_torque = 0.0;      ///< [N m]
  double max_slew = 0.0;        ///< change of force [N/s]
  Vec3 workspace_min{0.0};      ///< corners of the usable box, device frame [m]
  Vec3 workspace_max{0.0};      ///< equal to workspace_min: not known
  double resolution = 0.0;      ///< of position [m]
  double sample_rate_hz = 0.0;  ///< of new samples; 0: as often as read is called
  Clocking clocking = Clocking::kCaller;
  double watchdog = 0.0;  ///< device drops the force itself after this silence [s]; 0: it holds the
                          ///< last force for ever, and the node's own watchdog must stop it
};

/// One sample of the end of the device, in the device's frame. Trivially copyable.
struct DeviceSample {
  Vec3 position{0.0};                    ///< [m]
  Vec3 velocity{0.0};                    ///< [m/s]; meaningless unless has_velocity
  Quat orientation{1.0, 0.0, 0.0, 0.0};  ///< of the handle; identity without orientation
  std::uint32_t buttons = 0;             ///< bit i: button i is pressed
  bool has_velocity = false;             ///< false: the caller estimates it from positions
  double age =
      0.0;  ///< how long ago it was measured [s]; message-based devices are milliseconds old
};

/// What the motors shall do until the next command, device frame. Joint-level devices turn it into
/// joint torques (tau = J^T f) in their adapter.
struct DeviceCommand {
  Vec3 force{0.0};   ///< on the hand [N]
  Vec3 torque{0.0};  ///< on the hand [N m]; ignored by devices with force_dof 3
};

enum class DeviceStatus : std::uint8_t {
  kOk,
  kNoNewSample,   ///< sample is the previous one, older by now: see its age
  kNotFinite,     ///< refused: the device said, or was asked for, NaN or infinity
  kStopped,       ///< stop() was called; nothing is sent
  kDisconnected,  ///< unplugged, or its service is gone
  kFault,         ///< the device reports an error of its own
};

[[nodiscard]] const char* to_string(DeviceStatus status) noexcept;

/// An impedance-type device: motion in, force out. Four calls, no more; frames, filters and limits
/// are applied by the caller, once, for all devices.
///
/// `read` and `write` run on the force thread, once a tick, in this order: no lock, no allocation,
/// no throw. `read` leaves `sample` as it was when its status is not kOk or kNoNewSample. Before
/// the first write the force is zero. `stop` may be called from any thread at any time, more than
/// once; the destructor calls it.
class HapticDevice {
 public:
  HapticDevice() = default;
  HapticDevice(const HapticDevice&) = delete;
  HapticDevice& operator=(const HapticDevice&) = delete;
  virtual ~HapticDevice() = default;

  [[nodiscard]] virtual const DeviceInfo& info() const noexcept = 0;
  /// `slot` is the tick's slot number, from which simulated and recorded hands know the time.
  [[nodiscard]] virtual DeviceStatus read(std::int64_t slot, DeviceSample& sample) noexcept = 0;
  [[nodiscard]] virtual DeviceStatus write(const DeviceCommand& command) noexcept = 0;
  virtual void stop() noexcept = 0;  ///< zero force, and zero from now on
};

}  // namespace tandem::devices
