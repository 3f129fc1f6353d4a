#pragma once

#include <array>
#include <cstdint>

namespace tandem::test {

/// A payload larger than any atomic store, whose every word follows from its number: a value mixed
/// from two publishes cannot pass `intact`.
struct ChecksummedPayload {
  std::uint64_t number = 0;
  std::array<std::uint64_t, 40> words{};
  std::uint64_t checksum = 0;
};

/// splitmix64 (Steele, Lea, Flood 2014), a bijection: different numbers give different words.
inline std::uint64_t mixed(std::uint64_t z) {
  z += 0x9e3779b97f4a7c15u;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return z ^ (z >> 31);
}

inline ChecksummedPayload payload(std::uint64_t number) {
  ChecksummedPayload p{.number = number};
  for (std::size_t i = 0; i < p.words.size(); ++i) {
    p.words[i] = mixed(number * 64 + i);
    p.checksum = mixed(p.checksum ^ p.words[i]);
  }
  return p;
}

inline bool intact(const ChecksummedPayload& p) {
  std::uint64_t checksum = 0;
  for (const std::uint64_t word : p.words) checksum = mixed(checksum ^ word);
  return checksum == p.checksum && p.words[0] == mixed(p.number * 64);
}

}  // namespace tandem::test
