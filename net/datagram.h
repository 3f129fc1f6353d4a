#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

/// The 8 bytes in front of every datagram; see WIRE_FORMAT.md.
namespace tandem::net {

/// Raised by every change of the wire that an older program would misread.
inline constexpr std::uint8_t kProtocolVersion = 1;

inline constexpr std::size_t kMaxDatagram = 1200;  ///< [bytes] fits any path without fragments
inline constexpr std::size_t kPrefixBytes = 8;
inline constexpr std::array<std::uint8_t, 4> kMagic{'T', 'N', 'D', 'M'};

enum class Kind : std::uint8_t {
  kState = 1,
  kControl = 2,
  kProbe = 3,
  kProbeEcho = 4,
  kSnapshot = 5
};

struct Prefix {
  std::uint8_t version = 0;
  Kind kind = Kind::kState;
};

enum class PrefixFault { kNone, kWrongMagic, kMalformed };

/// Writes magic, version, kind and the message's length, little-endian. `out` holds 8 bytes.
inline void write_prefix(std::span<std::uint8_t> out, Kind kind, std::size_t message_bytes,
                         std::uint8_t version = kProtocolVersion) noexcept {
  for (std::size_t i = 0; i < kMagic.size(); ++i) out[i] = kMagic[i];
  out[4] = version;
  out[5] = static_cast<std::uint8_t>(kind);
  out[6] = static_cast<std::uint8_t>(message_bytes & 0xFF);
  out[7] = static_cast<std::uint8_t>(message_bytes >> 8);
}

/// Reads the prefix. A length that is not what follows is malformed: a protobuf message cut between
/// two fields would parse. The version is left to the caller, who may have to answer it.
[[nodiscard]] inline PrefixFault read_prefix(std::span<const std::uint8_t> datagram,
                                             Prefix& out) noexcept {
  for (std::size_t i = 0; i < kMagic.size(); ++i)
    if (i >= datagram.size() || datagram[i] != kMagic[i])
      return datagram.size() < kMagic.size() ? PrefixFault::kMalformed : PrefixFault::kWrongMagic;
  if (datagram.size() < kPrefixBytes || datagram.size() > kMaxDatagram)
    return PrefixFault::kMalformed;
  const std::size_t length =
      static_cast<std::size_t>(datagram[6]) | static_cast<std::size_t>(datagram[7]) << 8;
  if (length != datagram.size() - kPrefixBytes) return PrefixFault::kMalformed;
  out.version = datagram[4];
  out.kind = static_cast<Kind>(datagram[5]);
  return PrefixFault::kNone;
}

/// Kind of a datagram that is ours and whole, of any version; nothing otherwise.
[[nodiscard]] inline std::optional<Prefix> prefix_of(
    std::span<const std::uint8_t> datagram) noexcept {
  Prefix prefix;
  if (read_prefix(datagram, prefix) != PrefixFault::kNone) return std::nullopt;
  return prefix;
}

}  // namespace tandem::net
