#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "core/packet.h"
#include "net/peer_link.h"

namespace tandem::bench {

/// One site of a session whose link and force thread are to be measured: a server, or a replica.
struct TrafficHost {
  std::uint32_t own_sender = 0;
  std::vector<std::string> user_names;       ///< of the scene, in order
  std::vector<core::StatePacket> from_user;  ///< what each of them sends; no values: sits here
  int values_out = 0;
  double local_hz = 1024.0, packet_hz = 128.0;
  /// One tick of the force loop: takes from the inboxes, publishes in the outboxes if it sends.
  std::function<void(std::int64_t slot, bool sends, net::PeerLink&)> tick;
};

struct TrafficOptions {
  double seconds = 1.0;
  int priority = 80;  ///< SCHED_FIFO of the force thread; the link thread has one less. 0: ordinary
};

/// Over the measured window. Shares are of one processor.
struct Traffic {
  double in_per_s = 0.0;                               ///< state packets accepted [1/s]
  double out_per_s = 0.0;                              ///< sent [1/s]
  double delivered_per_s = 0.0;                        ///< of these, decoded by the others [1/s]
  double bytes_in_per_s = 0.0, bytes_out_per_s = 0.0;  ///< of datagrams, without UDP and IP headers
  double force_share = 0.0;                            ///< force thread, which does not spin here
  double link_share = 0.0;    ///< link thread, system calls and what the kernel does in them
  double others_share = 0.0;  ///< the thread that plays all other users
  double missed_share = 0.0;  ///< of ticks
  double late_p99_us = 0.0;   ///< wake-up of the force thread
  std::string why_not;        ///< it could not be run; empty: it was
};

/// Runs the site in real time on the loopback interface: its own PeerLink, everybody else played by
/// one thread with a socket and a session for each, whose packets come all at once.
[[nodiscard]] Traffic run_traffic(const TrafficHost& host, const TrafficOptions& options);

/// What one thread that sends to itself can do [datagrams/s], in blocks of 32.
struct LoopbackRate {
  double sendmmsg = 0.0;  ///< sendmmsg and recvmmsg
  double send = 0.0;      ///< send and recv on a connected socket
};
/// For `seconds` each. Throws std::runtime_error where there is no loopback interface.
[[nodiscard]] LoopbackRate measure_loopback(std::size_t bytes, double seconds);

}  // namespace tandem::bench
