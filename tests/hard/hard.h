#pragma once

#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <initializer_list>
#include <map>
#include <string>

#include <gtest/gtest.h>

/// What the hard cases share: their length, and the check that every build gives the same bits.
namespace tandem::hard {

/// Ticks, cycles or trials of a long case: all of them in optimised builds, a hundredth with
/// sanitizers (TANDEM_HARD_PERCENT, set by the build).
[[nodiscard]] constexpr std::int64_t length(std::int64_t full) {
  return full * TANDEM_HARD_PERCENT / 100;
}
/// The point that every build reaches.
[[nodiscard]] constexpr std::int64_t checkpoint(std::int64_t full) { return full / 100; }

/// FNV-1a over the bytes of the values.
[[nodiscard]] inline std::uint64_t bits_of(std::initializer_list<double> values) {
  std::uint64_t hash = 0xcbf29ce484222325u;
  for (const double value : values) {
    std::uint64_t word = 0;
    std::memcpy(&word, &value, sizeof word);
    for (int i = 0; i < 64; i += 8) hash = (hash ^ (word >> i & 0xff)) * 0x100000001b3u;
  }
  return hash;
}

/// Compares with tests/hard/bits.txt, which all builds share. With TANDEM_ACCEPT_BITS=1 in the
/// environment the file is changed instead, as a change of dynamics wants (CONTRIBUTING.md).
inline void expect_same_bits(const std::string& name, std::initializer_list<double> values) {
  const std::string file = TANDEM_SOURCE_DIR "/tests/hard/bits.txt";
  std::map<std::string, std::uint64_t> known;
  {
    std::ifstream in(file);
    std::string key;
    std::uint64_t hash = 0;
    while (in >> key >> std::hex >> hash) known[key] = hash;
  }
  const std::uint64_t hash = bits_of(values);
  if (const char* accept = std::getenv("TANDEM_ACCEPT_BITS"); accept != nullptr && *accept == '1') {
    known[name] = hash;
    std::ofstream out(file);
    for (const auto& [key, value] : known) out << key << ' ' << std::hex << value << '\n';
    return;
  }
  ASSERT_TRUE(known.contains(name)) << name << " is not in " << file;
  EXPECT_EQ(known.at(name), hash) << name << ": other bits than in " << file;
}

}  // namespace tandem::hard
