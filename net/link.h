#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "net/endpoint.h"

namespace tandem::net {

/// Carries datagrams: over UDP, or inside one process for tests. Used by one thread.
class Link {
 public:
  virtual ~Link() = default;

  /// Never waits. False if the system would not take it (queue full, no route): the datagram is
  /// lost, as any may be.
  virtual bool send(const Endpoint& to, std::span<const std::uint8_t> datagram) noexcept = 0;

  /// Next datagram, if one has arrived: its size, and the first bytes of it in `buffer`. Never
  /// waits.
  [[nodiscard]] virtual std::optional<std::size_t> receive(
      Endpoint& from, std::span<std::uint8_t> buffer) noexcept = 0;

  /// Returns when a datagram can be received or `timeout_ns` is over.
  virtual void wait(std::int64_t timeout_ns) noexcept = 0;

  /// Address of a peer written "HOST:PORT". May ask a name server and so take seconds.
  /// @throws std::runtime_error if the name cannot be resolved; std::invalid_argument if misspelt
  [[nodiscard]] virtual Endpoint resolve(const std::string& host_port) const = 0;

  /// Our own address; the port is the real one when 0 was asked for.
  [[nodiscard]] virtual Endpoint local() const noexcept = 0;
};

}  // namespace tandem::net
