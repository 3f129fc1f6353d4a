#pragma once

#include <cstdint>

#include "core/packet.h"
#include "core/records.h"
#include "net/peer_link.h"
#include "node/tick_log.h"

namespace tandem::node {

/// The force loop's end of the link to one peer.
///
/// A peer that comes back with a new session is another one as far as forces go: its copy may be
/// anywhere. Its packets are withheld until the force of the old one has faded, so that the law
/// seats it at zero stretch however quickly it was back.
class PeerPort {
 public:
  PeerPort() = default;
  PeerPort(net::PeerLink& link, std::uint32_t sender)
      : outbox_(&link.outbox(sender)), inbox_(&link.inbox(sender)), sender_(sender) {}

  void send(const core::StatePacket& packet) noexcept { outbox_->publish(packet); }

  /// Looks for a new packet. True: `packet` is one to use in this tick, and was logged.
  /// @param faded  the law feels nothing of this peer now
  [[nodiscard]] bool receive(std::int64_t slot, bool faded, TickLog& log) noexcept {
    if (!inbox_->fetch(arrived_) || arrived_.left) return false;
    if (arrived_.epoch != newest_.epoch && newest_.epoch != 0 && !faded) return false;
    newest_ = arrived_;
    log.push(core::PacketRecord{.slot = slot, .peer = sender_, .packet = newest_.packet});
    return true;
  }

  [[nodiscard]] const core::StatePacket& packet() const noexcept { return newest_.packet; }
  /// Of the newest packet used [s]; 0 before the first.
  [[nodiscard]] double age(std::int64_t now_ns) const noexcept {
    if (newest_.epoch == 0) return 0.0;
    const double age = newest_.age(now_ns);
    return age > 0.0 ? age : 0.0;  // it can arrive between the wake-up and the look
  }

 private:
  core::LatestValue<core::StatePacket>* outbox_ = nullptr;
  core::LatestValue<net::PeerSample>* inbox_ = nullptr;
  std::uint32_t sender_ = 0;
  net::PeerSample arrived_, newest_;
};

}  // namespace tandem::node
