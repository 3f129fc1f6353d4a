#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "net/datagram.h"

namespace tandem::net {

enum class ControlType : std::uint8_t {
  kHello = 1,
  kWelcome = 2,
  kRefuse = 3,
  kSceneRequest = 4,
  kSceneChunk = 5,
  kKeepAlive = 6,
  kLeave = 7,
  kSpectate = 8,
};

/// Why a host says no. Numbers are on the wire.
enum class RefuseReason : std::uint32_t {
  kNone = 0,
  kWrongVersion = 1,
  kOtherScene = 2,
  kServerFull = 3,
  kUserNameTaken = 4,
  kUnknownUserName = 5,
  kUnknownSession = 6,
  kWrongRole = 7,
};

/// "wrong version", "other scene", ...
[[nodiscard]] const char* name_of(RefuseReason reason) noexcept;

inline constexpr std::size_t kMaxNameBytes = 64;
inline constexpr std::size_t kMaxTextBytes = 400;
inline constexpr std::size_t kMaxChunkBytes = 1000;
inline constexpr std::uint32_t kMaxSceneBytes = 1u << 20;

/// One control message; which fields a type uses is in WIRE_FORMAT.md.
struct ControlMessage {
  std::uint8_t version = kProtocolVersion;  ///< of the datagram it came in
  ControlType type = ControlType::kHello;
  std::uint64_t session = 0;
  std::uint64_t nonce = 0;
  std::uint64_t scene_hash = 0;
  std::string user_name{};
  std::string program_version{};
  double packet_hz = 0.0;
  RefuseReason reason = RefuseReason::kNone;
  std::string text{};
  std::uint32_t user_index = 0;
  std::uint32_t host_sender = 0;
  std::uint32_t offset = 0;
  std::uint32_t total = 0;
  std::string chunk{};
};

/// Texts that are too long are cut. Not for the force loop: allocates.
[[nodiscard]] std::vector<std::uint8_t> encode_control(const ControlMessage& message);

/// Nothing if it is not a whole control datagram or breaks a rule of WIRE_FORMAT.md. Of a message
/// of another version only type, session, nonce, reason and text are read.
[[nodiscard]] std::optional<ControlMessage> decode_control(std::span<const std::uint8_t> datagram);

}  // namespace tandem::net
