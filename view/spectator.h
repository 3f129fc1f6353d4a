#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "core/scene.h"
#include "core/spectator_packet.h"
#include "net/session.h"
#include "net/state_codec.h"
#include "net/udp_socket.h"
#include "view/assemble.h"
#include "view/interpolate.h"
#include "view/snapshot.h"

namespace tandem::view {

/// Turns a node's snapshots, as they come, into pictures at any time: buffers a site each,
/// played 2.5 packet periods behind the newest. Without socket and clock, so that it can be tested
/// in virtual time. One thread.
class SpectatorPicture {
 public:
  static constexpr double kBufferPackets = 2.5;

  /// `host_sender`: whose snapshots: a user's index or core::kServerSender.
  SpectatorPicture(const core::Scene& scene, std::uint32_t host_sender,
                   double buffer_packets = kBufferPackets);

  [[nodiscard]] const core::SpectatorLayout& layout() const noexcept { return layout_; }
  /// Values in the snapshots of this site; -1: it has none.
  [[nodiscard]] std::int32_t values_from(std::uint32_t sender) const;

  /// A decoded snapshot that arrived at `now` [s].
  void take(const core::StatePacket& packet, double now);
  /// What to draw at `now`; false before the first snapshot.
  [[nodiscard]] bool at(double now, Snapshot& out);
  [[nodiscard]] double buffer() const noexcept { return buffer_; }

 private:
  struct Stream {
    SiteBuffer buffer;
    PlaybackClock clock;
    double newest_drawn = -1e300;
    bool guessing = false;  ///< what was drawn last was beyond the newest state
    std::array<Softener, core::kMaxFingers> fingers;
    std::array<Softener, core::kMaxObjects> objects;
    explicit Stream(double b) : clock(b) {}
  };
  void put(int site, std::int64_t slot, double now);

  core::Scene scene_;
  core::SpectatorLayout layout_;
  std::uint32_t host_;
  double buffer_;
  Assembler assembler_;
  std::vector<Stream> streams_;  ///< by site
  std::array<std::int64_t, kSites> used_{};
  double drawn_at_ = 0.0;
};

/// A spectator on the network: joins a node, keeps the session alive, and draws from what comes.
class Spectator {
 public:
  /// Waits for the scene at most `seconds`. Throws std::runtime_error in words for the user.
  Spectator(const std::string& host, const std::string& program_version, double seconds);
  ~Spectator();
  Spectator(const Spectator&) = delete;
  Spectator& operator=(const Spectator&) = delete;

  [[nodiscard]] const core::Scene& scene() const { return scene_; }
  [[nodiscard]] bool at_now(Snapshot& out);
  [[nodiscard]] std::vector<std::string> take_messages();
  [[nodiscard]] std::uint64_t accepted() const { return accepted_.load(); }
  /// How much later than it comes a state is drawn [s].
  [[nodiscard]] double buffer() const {
    return SpectatorPicture::kBufferPackets / scene_.rates.packet_hz;
  }

 private:
  void run();
  void receive();
  void flush();

  net::UdpLink link_;
  net::GuestSession session_;
  net::StateDecoder decoder_;
  core::Scene scene_;
  std::unique_ptr<SpectatorPicture> picture_;
  std::mutex mutex_;  ///< picture_ and messages_
  std::vector<std::string> messages_;
  std::atomic<std::uint64_t> accepted_{0};
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace tandem::view
