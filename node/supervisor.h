#pragma once

#include <atomic>
#include <cstdint>
#include <span>
#include <string>

#include "core/latest_value.h"
#include "core/realtime.h"
#include "devices/haptic_device.h"
#include "net/peer_link.h"
#include "node/force_loop.h"
#include "node/node_report.h"
#include "node/session_setup.h"
#include "node/stop_request.h"
#include "recording/recording_writer.h"

namespace tandem::node {

/// What the force thread and the rest of a node share, beside link and recording.
struct LoopShare {
  StopRequest stop;
  core::LatestValue<LoopStatus> status;
  std::atomic<std::int64_t> heartbeat{-1};  ///< newest slot
  std::atomic<bool> ended{false};
};

/// The node's main thread while the force loop runs: tells people how it goes, and stops the
/// devices when the force loop hangs.
class Supervisor {
 public:
  Supervisor(const SessionSetup& setup, net::PeerLink& link,
             const recording::RecordingWriter* recording, LoopShare& share,
             std::span<devices::HapticDevice* const> devices);

  /// Returns when the force loop has ended.
  void watch();
  /// Fills everything it knows in; call after the threads have ended.
  void fill(NodeReport& report);

 private:
  void look_for_hang();
  void tell_messages();
  void tell_status(bool on_terminal);
  [[nodiscard]] std::string status_line() const;

  const SessionSetup& setup_;
  net::PeerLink& link_;
  const recording::RecordingWriter* recording_;
  LoopShare& share_;
  std::span<devices::HapticDevice* const> devices_;
  LoopStatus loop_;
  std::int64_t last_beat_ = -1;
  int silent_looks_ = 0;
  bool recording_failure_told_ = false;
  bool line_open_ = false;  ///< the terminal's cursor is on a status line
  std::string failure_;
};

}  // namespace tandem::node
