#pragma once

#include <cstdint>

namespace tandem::net {

/// Next number of a SplitMix64 stream, never 0. Seeded from a random device, it makes session
/// numbers and nonces that a stranger does not hit by accident; it is no protection against an
/// attacker.
[[nodiscard]] inline std::uint64_t next_random(std::uint64_t& state) noexcept {
  for (;;) {
    state += 0x9E3779B97F4A7C15;
    std::uint64_t z = state;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EB;
    z ^= z >> 31;
    if (z != 0) return z;
  }
}

}  // namespace tandem::net
