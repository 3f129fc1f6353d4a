#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>

#include "core/packet.h"
#include "net/datagram.h"

namespace tandem::net {

/// What became of a received state packet. Everything but kOk is counted and not felt.
enum class Decode : std::uint8_t {
  kOk,
  kMalformed,      ///< shorter or longer than its length field, or not a protobuf message
  kWrongMagic,     ///< another protocol
  kWrongVersion,   ///< another version of this protocol
  kUnknownSender,  ///< no such user here, or not from that user's address
  kWrongSession,   ///< from before a reconnect, or from another session
  kWrongCount,     ///< number of values differs: another scene
  kNotFinite,      ///< NaN or infinity
  kOutOfRange,     ///< a value, counter or stamp nobody could have meant
  kStaleSequence,  ///< a newer packet came before it (core::SequenceGate)
  kDuplicate,      ///< came before (core::SequenceGate)
};
inline constexpr int kDecodeReasons = 11;

/// "malformed", "wrong version", ...; for tables and JSON keys with '_' for ' '.
[[nodiscard]] const char* name_of(Decode reason) noexcept;

/// How often each reason was given, index = static_cast<int>(Decode).
struct DecodeCounts {
  std::array<std::uint64_t, kDecodeReasons> by_reason{};

  void add(Decode reason) noexcept { ++by_reason[static_cast<std::size_t>(reason)]; }
  [[nodiscard]] std::uint64_t of(Decode reason) const noexcept {
    return by_reason[static_cast<std::size_t>(reason)];
  }
  [[nodiscard]] std::uint64_t rejected() const noexcept;
};

namespace limits {
inline constexpr double kMaxMagnitude = 1e3;             ///< values [SI]: 1 km, 1000 m/s, 1000 N
inline constexpr double kMaxEnergy = 1e9;                ///< cumulative energies [J]
inline constexpr std::int64_t kMaxStamp_ns = 1ll << 62;  ///< differences cannot overflow
inline constexpr std::uint64_t kMaxSequence = 1ull << 62;
}  // namespace limits

/// Writes state datagrams. After the first call nothing is allocated.
class StateEncoder {
 public:
  StateEncoder();
  ~StateEncoder();
  StateEncoder(const StateEncoder&) = delete;
  StateEncoder& operator=(const StateEncoder&) = delete;

  /// The datagram, valid until the next call; at most kMaxStateDatagram bytes. A value_count
  /// outside 0 .. kMaxPacketValues is clamped.
  [[nodiscard]] std::span<const std::uint8_t> encode(const core::StatePacket& packet,
                                                     std::uint64_t session,
                                                     Kind kind = Kind::kState) noexcept;

 private:
  struct Message;
  std::unique_ptr<Message> message_;
  std::array<std::uint8_t, kMaxDatagram> buffer_{};
};

/// Largest datagram `encode` can give [bytes]: every field present, 128 values.
inline constexpr std::size_t kMaxStateDatagram = 1115;

/// Reads state datagrams and distrusts all of them. Packets without unknown fields are decoded
/// without allocation after the first one.
class StateDecoder {
 public:
  /// @param max_magnitude  largest |value| accepted [SI]
  explicit StateDecoder(double max_magnitude = limits::kMaxMagnitude);
  ~StateDecoder();
  StateDecoder(const StateDecoder&) = delete;
  StateDecoder& operator=(const StateDecoder&) = delete;

  /// From now on packets of `sender` (user index or core::kServerSender) are accepted if they carry
  /// this session and number of values. Replaces what was expected before.
  void expect(std::uint32_t sender, std::uint64_t session, std::int32_t value_count) noexcept;
  /// From now on `sender` is unknown.
  void forget(std::uint32_t sender) noexcept;

  /// Fills `out` on kOk and leaves it untouched otherwise; counts the answer. Other kinds than
  /// `kind` (state, or a spectator's snapshot) are malformed.
  [[nodiscard]] Decode decode(std::span<const std::uint8_t> datagram, core::StatePacket& out,
                              Kind kind = Kind::kState) noexcept;

  [[nodiscard]] const DecodeCounts& counts() const noexcept { return counts_; }

 private:
  struct Message;
  struct Expected {
    bool known = false;
    std::uint64_t session = 0;
    std::int32_t value_count = 0;
  };
  [[nodiscard]] Decode examine(std::span<const std::uint8_t> datagram, core::StatePacket& out,
                               Kind kind) noexcept;

  std::unique_ptr<Message> message_;
  std::array<Expected, 256> expected_{};  ///< by sender index
  double max_magnitude_;
  DecodeCounts counts_;
};

}  // namespace tandem::net
