#pragma once

#include <array>
#include <cstdint>

#include "core/packet.h"
#include "core/scene.h"
#include "core/vec.h"

namespace tandem::core {

/// Values of one object's state in the widest space: position 3, orientation 4, velocity 3,
/// angular velocity 3. An axis scene uses the first 2 (x, v), a planar one the first 6.
inline constexpr int kMaxObjectValues = 13;

struct HandRecord {
  Vec3 position{0.0};  ///< [m]
  Vec3 velocity{0.0};  ///< [m/s]
};

/// What one tick of a node saw and did: its whole input besides the packets, and its output.
/// Written by the force thread into a ring, stored by recording/. Trivially copyable.
struct TickRecord {
  std::int64_t slot = 0;
  std::int64_t due_ns = 0;   ///< sender's monotonic clock
  std::int64_t woke_ns = 0;  ///< same clock
  std::uint32_t faults = 0;  ///< core::Fault bits
  std::uint32_t fresh = 0;   ///< bit u: a new sample of user u was used in this tick
  std::array<std::uint32_t, kMaxObjects> contact_bits{};  ///< as in StatePacket
  std::array<HandRecord, kMaxFingers> hands{};            ///< own fingers
  std::array<Vec3, kMaxFingers> command{};                ///< force sent to the devices [N]
  std::array<double, kMaxUsers> ages{};                   ///< of each user's newest sample [s]
  std::array<std::array<double, kMaxObjectValues>, kMaxObjects> objects{};
};

/// A packet as the force loop took it over, in the tick `slot` of the receiver.
struct PacketRecord {
  std::int64_t slot = 0;
  std::uint32_t peer = 0;  ///< index of the sender at the receiver
  StatePacket packet;
};

}  // namespace tandem::core
