#pragma once

#include <cstdint>

namespace tandem::core {

/// What went wrong in one tick. Several can be set at once. The loop goes on with a safe value;
/// another thread counts and reports.
enum class Fault : std::uint32_t {
  kNone = 0,
  kOverrun = 1u << 0,         ///< the tick ended after its deadline
  kDeviceRead = 1u << 1,      ///< device read failed; last sample held
  kStalePeer = 1u << 2,       ///< no packet for too long; its force fades
  kNotFinite = 1u << 3,       ///< NaN or infinity met; taken as zero
  kForceSaturated = 1u << 4,  ///< command cut to the device limit
  kForceSlewed = 1u << 5,     ///< command held back by the slew limit
  kDeviceWrite = 1u << 6,     ///< device write failed
};

[[nodiscard]] constexpr Fault operator|(Fault a, Fault b) noexcept {
  return static_cast<Fault>(static_cast<std::uint32_t>(a) | static_cast<std::uint32_t>(b));
}
constexpr Fault& operator|=(Fault& a, Fault b) noexcept { return a = a | b; }
[[nodiscard]] constexpr bool has(Fault faults, Fault one) noexcept {
  return (static_cast<std::uint32_t>(faults) & static_cast<std::uint32_t>(one)) != 0;
}

}  // namespace tandem::core
