#pragma once

#include <array>
#include <cstdint>

namespace tandem::core {

/// Flat numbers a datagram can carry: below 1200 bytes with everything else in it.
inline constexpr int kMaxPacketValues = 128;

/// Sender index of the server in the central architecture; users are 0 .. kMaxUsers - 1.
inline constexpr std::uint32_t kServerSender = 255;

/// Content of one state packet, free of any space: `values` is filled by the world of the scene
/// (core/site_state.h), the rest by the link. Trivially copyable; crosses threads by LatestValue.
struct StatePacket {
  std::uint32_t sender = 0;
  std::uint64_t sequence = 0;      ///< starts at 1, one more per packet
  std::int64_t slot = 0;           ///< sender's tick number of the state
  std::int64_t send_ns = 0;        ///< sender's clock when it left
  std::int64_t echo_ns = 0;        ///< newest send_ns seen from the receiver; 0: none yet
  std::int64_t echo_hold_ns = 0;   ///< sender's clock time between that arrival and send_ns
  std::uint32_t contact_bits = 0;  ///< of the site's fingers, core/contact_state.h
  double energy_in = 0.0;   ///< absorbed so far at all network ports together [J]; replicas only
  double energy_out = 0.0;  ///< cumulative energy delivered there [J]
  std::int32_t value_count = 0;
  std::array<double, kMaxPacketValues> values{};
};

}  // namespace tandem::core
