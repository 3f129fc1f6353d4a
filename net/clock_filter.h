#pragma once

#include <array>
#include <cstdint>

namespace tandem::net {

/// [ns] unless said otherwise.
struct ClockFilterParameters {
  std::int64_t min_one_way = 0;  ///< d_min: no datagram is faster; 0 is always true
  double max_skew = 300e-6;  ///< largest difference in rate of two clocks; 2 x 100 ppm and margin
  double slew = 500e-6;      ///< the estimate moves no faster than this
  std::int64_t max_pause =
      100'000'000;  ///< a silence counts as this long for the slew: no step after it
};

/// The four stamps of one exchange, as a state packet brings them.
struct ClockStamps {
  std::int64_t echo_ns = 0;       ///< t1, our clock: when our packet left; 0: none echoed
  std::int64_t echo_hold_ns = 0;  ///< t3 - t2, peer's clock
  std::int64_t send_ns = 0;       ///< t3, peer's clock
  std::int64_t arrival_ns = 0;    ///< t4, our clock
};

enum class ClockAnswer : std::uint8_t {
  kUsed,
  kNoEcho,      ///< the peer has not heard us yet
  kImpossible,  ///< shorter than a round trip can be: a clock jumped inside it; not used
  kRestarted,   ///< contradicts all before: a clock jumped; begins anew from this exchange
};

/// Offset of a peer's clock from ours, and how long its packets take, from stamps on the packets
/// (Cristian 1989; minimum filter of 8 as in NTP, RFC 5905):
///   offset = ((t2 - t1) + (t3 - t4)) / 2,   round trip = (t4 - t1) - (t3 - t2),
///   |error of offset| <= round trip / 2 - d_min, whatever the delays of the two directions.
/// An asymmetric path hides in that bound: no two-way exchange can see it.
///
/// During the first 8 exchanges the estimate is that of the smallest bound; from then on it slews
/// towards it and never steps, so that ages stay smooth in contact. An exchange whose bound does
/// not meet that of the estimate proves a clock jump and restarts the filter at once.
class ClockFilter {
 public:
  explicit ClockFilter(const ClockFilterParameters& parameters = {}) noexcept : p_(parameters) {}

  ClockAnswer update(const ClockStamps& stamps) noexcept;
  /// Forgets everything: a new session.
  void reset() noexcept { *this = ClockFilter(p_); }

  /// False until the first exchange; then offset, bound and age mean nothing.
  [[nodiscard]] bool valid() const noexcept { return exchanges_ > 0; }
  /// Peer's clock less ours [ns].
  [[nodiscard]] std::int64_t offset_ns() const noexcept;
  /// The true offset, and so every age, is within this of the estimate at our time `now_ns` [ns].
  [[nodiscard]] std::int64_t bound_ns(std::int64_t now_ns) const noexcept;
  /// Age at our `now_ns` of what the peer stamped `send_ns`; never negative. 0 while not valid
  /// [ns].
  [[nodiscard]] std::int64_t age_ns(std::int64_t send_ns, std::int64_t now_ns) const noexcept;
  /// Of the newest exchange used [ns].
  [[nodiscard]] std::int64_t round_trip_ns() const noexcept { return round_trip_ns_; }
  [[nodiscard]] std::uint64_t restarts() const noexcept { return restarts_; }

 private:
  static constexpr std::size_t kWindow = 8;
  struct Exchange {
    std::int64_t offset_ns = 0;
    std::int64_t arrival_ns = 0;
    double half_width_ns = 0.0;  ///< bound on the error of offset_ns at arrival_ns
  };
  [[nodiscard]] double width_now(const Exchange& exchange, std::int64_t now_ns) const noexcept;
  [[nodiscard]] const Exchange& best(std::int64_t now_ns) const noexcept;

  ClockFilterParameters p_;
  std::array<Exchange, kWindow> window_{};
  std::uint64_t exchanges_ = 0;  ///< since the start or restart
  std::uint64_t restarts_ = 0;
  std::int64_t round_trip_ns_ = 0;
  std::int64_t base_ns_ = 0;  ///< estimate = base + fraction
  double fraction_ns_ = 0.0;
  std::int64_t last_ns_ = 0;        ///< our clock at the last exchange
  double estimate_bound_ns_ = 0.0;  ///< at last_ns_
};

}  // namespace tandem::net
