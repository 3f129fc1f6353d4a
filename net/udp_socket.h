#pragma once

#include <memory>
#include <string>

#include "net/link.h"

namespace tandem::net {

/// One UDP socket, non-blocking, IPv4 or IPv6 as its own address says.
class UdpLink final : public Link {
 public:
  /// @param bind  our own "ADDRESS:PORT"; port 0 lets the system choose, 0.0.0.0 and [::] listen on
  ///              every interface
  /// @throws std::runtime_error in words for the user: port in use, not an address of this machine,
  ///         name cannot be resolved, no permission; std::invalid_argument for a misspelt address
  explicit UdpLink(const std::string& bind);
  ~UdpLink() override;

  bool send(const Endpoint& to, std::span<const std::uint8_t> datagram) noexcept override;
  [[nodiscard]] std::optional<std::size_t> receive(
      Endpoint& from, std::span<std::uint8_t> buffer) noexcept override;
  void wait(std::int64_t timeout_ns) noexcept override;
  [[nodiscard]] Endpoint local() const noexcept override;

  /// Of the same family as ours; port 0 is refused too.
  [[nodiscard]] Endpoint resolve(const std::string& host_port) const override;

 private:
  struct Socket;
  std::unique_ptr<Socket> socket_;
};

}  // namespace tandem::net
