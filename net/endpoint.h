#pragma once

#include <array>
#include <compare>
#include <cstdint>
#include <string>
#include <string_view>

namespace tandem::net {

/// Where a datagram comes from or goes to. A plain value, so that sessions and tests need no
/// socket.
struct Endpoint {
  std::array<std::uint8_t, 16> ip{};  ///< network order; IPv4 in the first four bytes
  std::uint16_t port = 0;             ///< 0: none
  bool is_v6 = false;

  friend auto operator<=>(const Endpoint&, const Endpoint&) = default;
};

/// "192.168.1.5:7000", "[fe80::1]:7000".
[[nodiscard]] std::string to_string(const Endpoint& endpoint);

struct HostPort {
  std::string host;
  std::uint16_t port = 0;
};

/// Splits "host:port", "1.2.3.4:7000" or "[::1]:7000".
/// @throws std::invalid_argument naming what is wrong and what is allowed
[[nodiscard]] HostPort parse_host_port(std::string_view text);

}  // namespace tandem::net
