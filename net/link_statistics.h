#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "core/sequence_gate.h"
#include "core/wakeup_statistics.h"
#include "net/state_codec.h"

namespace tandem::net {

/// [s]
struct DelaySummary {
  std::uint64_t count = 0;
  double mean = 0.0;
  double rms_jitter = 0.0;  ///< root mean square of the deviations from the mean
  double min = 0.0, p50 = 0.0, p90 = 0.0, p99 = 0.0, p999 = 0.0, max = 0.0;
};

/// Mean, jitter and percentiles of delays in fixed memory, no allocation. Percentiles are by
/// nearest rank, never below the true one and at most 1/64 (1.6 %) above it
/// (core::WakeupStatistics, which is a histogram of nanoseconds whatever they measure); the rest is
/// exact to rounding.
class DelayStatistics {
 public:
  /// Negative delays count as 0.
  void record(std::int64_t delay_ns) noexcept {
    delay_ns = std::max<std::int64_t>(delay_ns, 0);
    histogram_.record(delay_ns);
    min_ns_ = histogram_.count() == 1 ? delay_ns : std::min(min_ns_, delay_ns);
    // Welford: no cancellation however many.
    const double x = static_cast<double>(delay_ns);
    const double before = x - mean_ns_;
    mean_ns_ += before / static_cast<double>(histogram_.count());
    squares_ += before * (x - mean_ns_);
  }

  [[nodiscard]] DelaySummary summary() const noexcept {
    DelaySummary s;
    s.count = histogram_.count();
    if (s.count == 0) return s;
    const auto percentile = [&](double f) {
      return 1e-9 * static_cast<double>(std::max(histogram_.percentile_ns(f), min_ns_));
    };
    s.mean = 1e-9 * mean_ns_;
    s.rms_jitter = 1e-9 * std::sqrt(squares_ / static_cast<double>(s.count));
    s.min = 1e-9 * static_cast<double>(min_ns_);
    s.p50 = percentile(0.5);
    s.p90 = percentile(0.9);
    s.p99 = percentile(0.99);
    s.p999 = percentile(0.999);
    s.max = 1e-9 * static_cast<double>(histogram_.max_ns());
    return s;
  }

 private:
  core::WakeupStatistics histogram_;
  std::int64_t min_ns_ = 0;
  double mean_ns_ = 0.0;
  double squares_ = 0.0;
};

/// Interarrival jitter of RFC 3550, 6.4.1: J += (|D| - J) / 16, D the change of transit time from
/// one packet to the next. Needs no common clock.
class ArrivalJitter {
 public:
  void record(std::int64_t send_ns, std::int64_t arrival_ns) noexcept {
    const double transit = static_cast<double>(arrival_ns - send_ns);
    if (started_) jitter_ns_ += (std::abs(transit - last_transit_) - jitter_ns_) / 16.0;
    last_transit_ = transit;
    started_ = true;
  }
  /// The next packet starts afresh: the peer's clock is another one now. The value stays.
  void restart() noexcept { started_ = false; }
  [[nodiscard]] double jitter() const noexcept { return 1e-9 * jitter_ns_; }  ///< [s]

 private:
  bool started_ = false;
  double last_transit_ = 0.0;
  double jitter_ns_ = 0.0;
};

/// State of the link to one peer since the start, all sessions together.
struct LinkSnapshot {
  std::uint64_t packets_sent = 0;      ///< state packets
  std::uint64_t bytes_sent = 0;        ///< of them, without UDP and IP headers
  std::uint64_t send_failures = 0;     ///< the system did not take them
  std::uint64_t packets_received = 0;  ///< state packets, good or bad
  std::uint64_t bytes_received = 0;
  std::uint64_t accepted = 0;
  std::uint64_t lost = 0;       ///< numbers that never arrived
  std::uint64_t reordered = 0;  ///< arrived after a newer one; not used
  std::uint64_t duplicates = 0;
  DecodeCounts by_reason;               ///< index Decode, accepted included
  DelaySummary round_trip;              ///< [s] holds at the peer taken out
  DelaySummary one_way;                 ///< [s] peer to us, by the clock filter
  double one_way_bound = 0.0;           ///< error of one_way is at most this now [s]
  double jitter_rfc3550 = 0.0;          ///< [s]
  std::uint64_t clock_restarts = 0;     ///< a clock jumped; offset and delay begun anew
  std::uint64_t impossible_stamps = 0;  ///< not used for the delay: a clock jumped inside them
};

/// Collects a LinkSnapshot. For one thread.
class LinkStatistics {
 public:
  void sent(std::size_t bytes, bool taken) noexcept {
    ++counts_.packets_sent;
    counts_.bytes_sent += bytes;
    counts_.send_failures += taken ? 0 : 1;
  }
  void received(std::size_t bytes, Decode answer) noexcept {
    ++counts_.packets_received;
    counts_.bytes_received += bytes;
    counts_.by_reason.add(answer);
  }
  void round_trip(std::int64_t delay_ns) noexcept { round_trip_.record(delay_ns); }
  void one_way(std::int64_t delay_ns) noexcept { one_way_.record(delay_ns); }
  [[nodiscard]] ArrivalJitter& jitter() noexcept { return jitter_; }

  [[nodiscard]] LinkSnapshot snapshot(const core::SequenceGate& gate) const noexcept {
    LinkSnapshot s = counts_;
    s.accepted = gate.counts().accepted;
    s.lost = gate.lost();
    s.reordered = gate.counts().old;
    s.duplicates = gate.counts().duplicate;
    s.round_trip = round_trip_.summary();
    s.one_way = one_way_.summary();
    s.jitter_rfc3550 = jitter_.jitter();
    return s;
  }

 private:
  LinkSnapshot counts_;
  DelayStatistics round_trip_, one_way_;
  ArrivalJitter jitter_;
};

}  // namespace tandem::net
