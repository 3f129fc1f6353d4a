#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "net/link.h"
#include "net/link_statistics.h"

namespace tandem::net {

inline constexpr std::uint64_t kMaxProbeCount = 10'000'000;  ///< 80 MB of round trips
inline constexpr double kMaxProbeRate = 100'000.0;           ///< [1/s]
inline constexpr double kMaxProbeSeconds = 86'400.0;

/// What to measure: numbered packets at a fixed rate, sent back by `serve_probe` on the other side.
struct ProbeOptions {
  double rate_hz = 1250.0;    ///< (0, 100000]
  std::uint64_t count = 0;    ///< packets, 1 to 10^7; 0: as many as fit into `seconds`
  double seconds = 0.0;       ///< (0, 86400]; 0: as long as `count` takes
  std::size_t datagram = 64;  ///< 48 to 1200 [bytes] without UDP header; 165 is sent as 164
  double patience = 1.0;      ///< how long after the last packet an answer still counts [s]

  /// Packets to send. @throws std::invalid_argument naming field, value and range
  [[nodiscard]] std::uint64_t packets() const;
};

struct ProbeResult {
  std::uint64_t sent = 0;
  std::uint64_t received = 0;  ///< different numbers that came back
  std::uint64_t duplicates = 0;
  std::uint64_t reordered = 0;  ///< came back after a larger number
  std::uint64_t strangers = 0;  ///< datagrams that were none of ours
  std::uint64_t send_failures = 0;
  double asked_rate_hz = 0.0;
  double achieved_rate_hz = 0.0;  ///< of sending, first to last packet
  double seconds = 0.0;           ///< first to last packet sent
  std::size_t datagram = 0;       ///< [bytes]
  bool interrupted = false;
  double mean = 0.0,
         rms_jitter = 0.0;      ///< of the round trip; jitter: rms deviation from the mean [s]
  double jitter_rfc3550 = 0.0;  ///< [s]
  double min = 0.0, p10 = 0.0, p50 = 0.0, p90 = 0.0, p99 = 0.0, p999 = 0.0,
         max = 0.0;                         ///< exact, nearest rank [s]
  std::vector<std::int64_t> round_trip_ns;  ///< by number - 1; -1: lost
  std::vector<double> sorted;               ///< round trips that arrived, ascending [s]

  [[nodiscard]] std::uint64_t lost() const { return sent - received; }
};

/// Sends and measures; returns when done, or soon after `stop` is set, with what there is until
/// then. `progress` is called about once a second with packets sent and received so far.
[[nodiscard]] ProbeResult run_probe(
    Link& link, const Endpoint& peer, const ProbeOptions& options, const std::atomic<bool>& stop,
    const std::function<void(std::uint64_t, std::uint64_t)>& progress = {});

/// Sends every probe packet back until `stop` is set or `seconds` are over (0: for ever). Returns
/// how many it answered.
std::uint64_t serve_probe(Link& link, const std::atomic<bool>& stop, double seconds = 0.0);

/// Fills everything in `result` that follows from sent, round_trip_ns and the counts.
void summarise(ProbeResult& result);

/// The table in the form of Table 1.1 of the thesis, the thesis's values beside it.
[[nodiscard]] std::string probe_table(const ProbeResult& result, const std::string& peer);
/// Histogram for a terminal, 80 columns.
[[nodiscard]] std::string probe_histogram(const ProbeResult& result);
/// Histogram as an SVG picture.
[[nodiscard]] std::string probe_picture(const ProbeResult& result, const std::string& peer);

/// Table 1.1 of the thesis, as printed there.
namespace thesis {
inline constexpr double kMeanRoundTrip = 2.4395e-3;  ///< [s]
inline constexpr double kRmsJitter = 0.4871e-3;      ///< [s]
inline constexpr double kLost = 2.0;
inline constexpr double kPackets = 2.7e6;
inline constexpr double kMinutes = 36.0;
inline constexpr double kStatedRate_hz = 128.0;
}  // namespace thesis

}  // namespace tandem::net
