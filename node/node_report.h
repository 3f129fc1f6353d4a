#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "core/realtime.h"
#include "net/link_statistics.h"
#include "net/peer_link.h"
#include "node/force_loop.h"

namespace tandem::node {

struct PeerReport {
  std::string name;
  std::uint32_t sender = 0;
  net::LinkSnapshot link;
  net::PeerStatus status;
  double gain = 0.0;  ///< of its force, in the last tick
};

/// How a run went, as the tables and JSON of the commands show it.
struct NodeReport {
  std::string role;      ///< "replica", "server", "client"
  std::string user;      ///< "server" for a server
  double seconds = 0.0;  ///< asked for; 0: until stopped
  double local_hz = 0.0, packet_hz = 0.0;
  LoopStatus loop;
  std::vector<PeerReport> peers;
  net::DecodeCounts strays;  ///< datagrams from nobody we know, by reason
  std::uint64_t allocations_in_force_loop = 0;
  bool allocations_counted = false;  ///< false: the number above means nothing
  std::vector<core::RealtimeSetting> realtime;
  std::int64_t spin_ns = 0;
  std::string recording;  ///< file; empty: none
  recording::RecordingStatus recorded;
  int stop_signal = 0;  ///< 0: it ended by itself
  std::string failure;  ///< why it did not end well; empty: it did

  [[nodiscard]] double loop_hz() const;  ///< ticks over the time they took
  [[nodiscard]] std::uint64_t packets_sent() const;
  [[nodiscard]] std::uint64_t packets_accepted() const;
  /// Packets that were out of sequence: lost, reordered or twice.
  [[nodiscard]] std::uint64_t sequence_errors() const;
  /// Datagrams that were counted and not felt.
  [[nodiscard]] std::uint64_t rejected() const;
};

[[nodiscard]] nlohmann::ordered_json to_json(const NodeReport& report);
/// A few lines for people.
[[nodiscard]] std::string to_text(const NodeReport& report);

}  // namespace tandem::node
