#pragma once

#include <array>
#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "core/latest_value.h"
#include "core/packet.h"
#include "core/realtime.h"
#include "core/scene.h"
#include "core/spectator_packet.h"
#include "core/view_tap.h"
#include "net/inheriting_mutex.h"
#include "net/link.h"
#include "net/link_statistics.h"
#include "net/session.h"
#include "net/spectator_desk.h"

namespace tandem::net {

/// Newest accepted packet of a peer, as the force loop gets it.
struct PeerSample {
  core::StatePacket packet;
  std::int64_t arrival_ns = 0;         ///< our monotonic clock
  std::int64_t age_at_arrival_ns = 0;  ///< by the clock filter; 0 until it knows
  std::int64_t age_bound_ns = 0;       ///< error of the age at most; 0 with age 0: not known
  std::uint32_t epoch = 0;             ///< one more with every join of this peer; 1 is the first
  bool left = false;                   ///< said goodbye or was given up; packet is the last one

  /// Age of the sample at our `now_ns` [s].
  [[nodiscard]] double age(std::int64_t now_ns) const noexcept {
    return 1e-9 * static_cast<double>(age_at_arrival_ns + (now_ns - arrival_ns));
  }
};

struct PeerLinkOptions {
  std::string bind = "0.0.0.0:0";
  std::optional<HostOptions> host;  ///< set: others can join here (times and seed are filled in)
  std::vector<std::string> join;    ///< "HOST:PORT" of every host to join
  std::string user_name;            ///< as guest; empty: any free seat
  std::uint64_t scene_hash = 0;     ///< as guest; 0: have the scene sent
  std::string program_version;
  SessionTimes times{};
  /// Of the link thread. Ordinary by default; what is asked and not granted is in `realtime()`.
  core::RealtimeRequest realtime{.priority = 0,
                                 .lock_memory = false,
                                 .cpu = {},
                                 .timer_slack_ns = 1,
                                 .hold_cpu_dma_latency = false};
};

/// When and what state packets are exchanged; known once the scene is.
struct ExchangeOptions {
  std::uint32_t own_sender = 0;  ///< user index, or core::kServerSender
  std::int64_t start_ns = 0;     ///< of slot 0, our monotonic clock
  double packet_hz = 128.0;      ///< packet k leaves at start + k / packet_hz
  double local_hz = 0.0;         ///< in the first tick of this rate then; 0: at once
  /// Number of values in packets from each user, and last from the server; -1: sends us nothing.
  std::array<std::int32_t, core::kMaxUsers + 1> values_from{-1, -1, -1, -1, -1, -1, -1, -1, -1};
  core::SpectatorLayout spectators{};  ///< what their snapshots of us hold
  /// The link thread is awake from `watch_before_ns` before a packet slot is due, as a wake-up
  /// takes tens of microseconds, and looks in the outboxes without sleeping until there is
  /// something to send, for `watch_after_ns` at most; each at most a sixteenth of the packet
  /// period. From then on it sleeps from look to look. Both 0: it sleeps from the slot on.
  std::int64_t watch_before_ns = 30'000;
  std::int64_t watch_after_ns = 30'000;
  std::int64_t look_again_ns = 60'000;
};

/// Index of a sender in arrays of kMaxUsers + 1; -1 if there is no such sender.
[[nodiscard]] constexpr int peer_index(std::uint32_t sender) noexcept {
  if (sender == core::kServerSender) return core::kMaxUsers;
  return sender < core::kMaxUsers ? static_cast<int>(sender) : -1;
}

struct PeerStatus {
  bool connected = false;
  std::string address;
  std::uint32_t epoch = 0;
  double silent_for = 0.0;  ///< since its last accepted packet, or since it joined [s]
  bool delay_known = false;
  double one_way_delay = 0.0;  ///< of the newest packet, peer to us [s]
  double delay_bound = 0.0;    ///< the true delay is within this of it [s]
  double round_trip = 0.0;     ///< newest [s]
};

struct LinkMessage {
  bool is_error = false;
  std::string text;
};

/// What `wait_until_joined` brings.
struct JoinResult {
  bool joined = false;
  std::string error;             ///< for people, when not joined
  std::uint32_t user_index = 0;  ///< our seat, as guest
  std::uint64_t scene_hash = 0;
  std::string scene_text;  ///< if we asked for it
  double packet_hz = 0.0;
};

/// The link thread of a node and what it shares with the force loop: owns socket, sessions,
/// decoder, gates, clocks and statistics.
///
/// The force loop calls `outbox(s).publish` and `inbox(s).fetch` and nothing else: no lock, no
/// system call. All other functions may be called from any other thread; they take a short lock.
/// The link thread sleeps until a datagram arrives or just before a packet slot is due, then looks
/// in the outboxes (see ExchangeOptions) until the force loop has published for every peer; so the
/// force loop wakes nobody. It stamps sender, sequence, send and echo stamps as the datagram
/// leaves.
class PeerLink {
 public:
  /// Opens the socket and resolves the hosts.
  /// @throws std::runtime_error, std::invalid_argument in words for the user
  explicit PeerLink(PeerLinkOptions options);
  /// The same over another link (tests).
  PeerLink(PeerLinkOptions options, std::unique_ptr<Link> link);
  ~PeerLink();  ///< stops
  PeerLink(const PeerLink&) = delete;
  PeerLink& operator=(const PeerLink&) = delete;

  void start();
  void stop();  ///< says goodbye to all peers; at most 50 ms

  /// Waits until every host in `join` has let us in and sent its scene, one has refused us, one has
  /// not answered in time, or `seconds` are over. Without hosts to join it returns at once, joined.
  [[nodiscard]] JoinResult wait_until_joined(double seconds);

  /// Begins to exchange state: until then state packets are dropped uncounted. May be called again
  /// with other options.
  void open_exchange(const ExchangeOptions& options);

  /// Where the force loop puts its newest packet for this sender (user index or kServerSender).
  [[nodiscard]] core::LatestValue<core::StatePacket>& outbox(std::uint32_t sender);
  [[nodiscard]] core::LatestValue<PeerSample>& inbox(std::uint32_t sender);

  /// Where the force loop leaves its ticks for those who look on; nullptr: nobody can here.
  [[nodiscard]] core::ViewTap* spectator_tap() noexcept { return tap_.get(); }

  [[nodiscard]] PeerStatus status(std::uint32_t sender) const;
  [[nodiscard]] LinkSnapshot statistics(std::uint32_t sender) const;
  /// Datagrams from addresses that are no peer's, by reason.
  [[nodiscard]] DecodeCounts strays() const;
  [[nodiscard]] int connected_peers() const;
  /// What happened since the last call: joined, left, lost, refused, a clock that jumped, what the
  /// link thread asked the system for and did not get.
  [[nodiscard]] std::vector<LinkMessage> take_messages();
  [[nodiscard]] Endpoint local() const noexcept { return link_->local(); }

 private:
  struct Peer;
  void run();
  void receive_all();
  void on_state(std::span<const std::uint8_t> datagram, const Endpoint& from, std::int64_t now_ns);
  void on_control(std::span<const std::uint8_t> datagram, const Endpoint& from,
                  std::int64_t now_ns);
  void flush_sessions(std::int64_t now_ns);
  void on_event(const SessionEvent& event, bool is_host, std::int64_t now_ns);
  void join_peer(const SessionEvent& event, std::int64_t now_ns);
  void leave_peer(std::uint32_t sender, std::int64_t now_ns);
  void expect_from(const Peer& peer, std::uint32_t sender) noexcept;
  [[nodiscard]] std::int64_t look_in_outboxes(std::int64_t now_ns);
  void send_state(Peer& peer, core::StatePacket& packet);
  void send_snapshots();
  void send_snapshot(core::StatePacket& packet);
  [[nodiscard]] Peer& peer_of(std::uint32_t sender) const;

  PeerLinkOptions options_;
  std::unique_ptr<Link> link_;
  std::unique_ptr<HostSession> host_;
  std::unique_ptr<SpectatorDesk> desk_;  ///< there is one where there is a host
  std::unique_ptr<core::ViewTap> tap_;
  core::TappedTick tapped_;
  core::TappedPacket tapped_hand_;
  std::vector<std::unique_ptr<GuestSession>> guests_;
  std::array<std::unique_ptr<Peer>, core::kMaxUsers + 1> peers_;
  StateEncoder encoder_;
  StateDecoder decoder_;
  DecodeCounts strays_;
  std::optional<ExchangeOptions> exchange_;
  core::PacketSlots slots_;        ///< ticks of exchange_->local_hz
  std::int64_t packet_slot_ = -1;  ///< newest packet that is due
  std::vector<LinkMessage> messages_;

  mutable InheritingMutex mutex_;  ///< all of the above but link_ and the peers' boxes
  std::condition_variable_any joined_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace tandem::net
