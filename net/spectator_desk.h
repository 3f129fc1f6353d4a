#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "core/packet.h"
#include "net/session.h"

namespace tandem::net {

/// The host's side of those who only look on: gives them a session and says whom to send snapshots
/// to. They take no seat and nothing they send reaches a law. Like the sessions: no socket, no
/// clock. The rules are in WIRE_FORMAT.md.
class SpectatorDesk : public SessionOutput {
 public:
  static constexpr std::size_t kMost = 8;

  /// Uses scene, rate, version, own sender, times and seed of the options.
  explicit SpectatorDesk(HostOptions options)
      : options_(std::move(options)), random_(options_.seed ^ 0x5bec7a70) {}

  struct Spectator {
    bool here = false;
    bool proven = false;  ///< answered with its session: the address is its own
    Endpoint address;
    std::uint64_t session = 0, nonce = 0;
    std::int64_t heard_ns = 0, keep_alive_ns = 0;
    std::array<std::uint64_t, core::kMaxUsers + 1> sequence{};  ///< of the last snapshot, by site
  };

  /// False: not a spectator's, look elsewhere.
  [[nodiscard]] bool on_control(const ControlMessage& message, const Endpoint& from,
                                std::int64_t now_ns);
  /// Call at least every 50 ms.
  void poll(std::int64_t now_ns);
  void leave();

  [[nodiscard]] std::span<Spectator> spectators() noexcept { return spectators_; }
  [[nodiscard]] bool anybody() const noexcept;

 private:
  void on_spectate(const ControlMessage& message, const Endpoint& from, std::int64_t now_ns);
  void refuse(const Endpoint& to, std::uint64_t nonce, RefuseReason reason,
              const std::string& text);
  void welcome(const Spectator& spectator);

  HostOptions options_;
  std::uint64_t random_;
  std::array<Spectator, kMost> spectators_{};
};

}  // namespace tandem::net
