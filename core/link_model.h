#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <type_traits>

#include "core/random.h"

namespace tandem::core {

enum class JitterKind { kNone, kUniform, kNormal, kExponential, kPareto, kParetoNormal };

/// How one direction of a link treats packets, in virtual time. Semantics are netem's: each
/// packet draws its own fate, so jitter reorders; first_in_first_out makes a later packet wait.
struct LinkModelParameters {
  double delay_ticks = 0.0;  ///< one way [ticks]; a fraction acts as the next whole tick
  JitterKind jitter = JitterKind::kNone;
  double jitter_ticks = 0.0;   ///< uniform: half width; normal: sd; exponential: mean; Pareto and
                               ///< Pareto-normal: factor of netem's table [ticks]
  double loss = 0.0;           ///< [0, 1], each packet by itself, outside bursts
  double burst_enter = 0.0;    ///< Gilbert-Elliott: chance per packet to enter the lossy state
  double burst_leave = 1.0;    ///< and to leave it
  double burst_loss = 1.0;     ///< chance to be lost in it
  double duplicate = 0.0;      ///< [0, 1], the copy draws its own jitter
  double reorder = 0.0;        ///< [0, 1]: delivered at once, past those delayed
  double service_ticks = 0.0;  ///< the line takes so long for a packet, and they queue [ticks]
  std::int64_t outage_start = -1;  ///< slots [start, start + length): everything sent is lost
  std::int64_t outage_length = 0;
  std::int64_t outage_period = 0;  ///< again after so many slots; 0: once
  bool first_in_first_out = false;
  /// Recorded delays [ticks], negative: lost. Packets take them in order, round and round, on top
  /// of the rest. Owned by whoever made them; must outlive the link.
  std::span<const double> recorded{};
  bool recorded_from_seed = false;  ///< begin at a seeded place, not at the first
  /// How much older than it is the receiver reckons a sample [ticks]. Two-way time stamps cannot
  /// tell in which direction a delay is: half of what the two directions differ by.
  double age_error_ticks = 0.0;
  std::uint64_t seed = 1;
};

/// What happens to packets, where it is not to be drawn.
struct PacketFate {
  bool given = false;  ///< false: drawn, as LinkModelParameters say
  bool lost = false;
  double delay_ticks = 0.0;  ///< one way; a fraction acts as the next whole tick
};

/// One direction of a modelled link: the packets in flight and their fates. Trivially copyable.
/// Its storage is fixed; when more packets are in flight than fit, the oldest is dropped and
/// counted, as a router's queue would.
template <typename Message, int kCapacity = 64>
class LinkModel {
  static_assert(std::is_trivially_copyable_v<Message>);

 public:
  explicit LinkModel(const LinkModelParameters& parameters = {}) noexcept
      : parameters_(parameters), random_(parameters.seed) {
    if (!parameters.recorded.empty() && parameters.recorded_from_seed)
      next_recorded_ = static_cast<std::size_t>(random_.uniform() *
                                                static_cast<double>(parameters.recorded.size()));
  }

  /// `late`: how long after the tick of its state the packet leaves [ticks].
  void push(const Message& message, std::int64_t slot, double late = 0.0) noexcept {
    ++sequence_;
    if (fate_.given ? fate_.lost : is_lost(slot)) {
      ++lost_;
      return;
    }
    admit(message, slot, late);
    if (parameters_.duplicate > 0.0 && random_.uniform() < parameters_.duplicate)
      admit(message, slot, late);
  }

  /// The fate of every packet pushed from now on; one that is not given ends it.
  void set_fate(const PacketFate& fate) noexcept { fate_ = fate; }

  /// Calls `accept(message, send_slot, sequence)` for every packet due at `slot`, in order of
  /// arrival (packets of the same tick: as sent).
  template <typename Accept>
  void deliver(std::int64_t slot, Accept&& accept) noexcept {
    while (static_cast<double>(slot) >= next_arrival_) {
      int first = -1;
      for (int i = 0; i < count_; ++i)
        if (arrival(i) <= static_cast<double>(slot) && (first < 0 || earlier(i, first))) first = i;
      if (first < 0) break;
      accept(flight_[first].message, flight_[first].send_slot, flight_[first].sequence);
      remove(first);
    }
  }

  /// Visits the messages still in flight, oldest first; they are states of the link.
  template <typename Visitor>
  void visit_in_flight(Visitor&& visitor) {
    for (int i = 0; i < count_; ++i) visitor(flight_[i].message);
  }

  /// Visits send slot and arrival [ticks] of each packet in flight, oldest first.
  template <typename Visitor>
  void visit_flights(Visitor&& visitor) const {
    for (int i = 0; i < count_; ++i) visitor(flight_[i].send_slot, flight_[i].arrival);
  }

  [[nodiscard]] const LinkModelParameters& parameters() const noexcept { return parameters_; }
  [[nodiscard]] int in_flight() const noexcept { return count_; }
  [[nodiscard]] std::int64_t lost() const noexcept { return lost_; }
  [[nodiscard]] std::int64_t overflowed() const noexcept { return overflowed_; }
  [[nodiscard]] std::uint64_t sent() const noexcept { return sequence_; }

 private:
  struct Flight {
    Message message{};
    std::int64_t send_slot = 0;
    std::uint64_t sequence = 0;
    double arrival = 0.0;
  };

  [[nodiscard]] static double nearest(double x) noexcept {
    return static_cast<double>(static_cast<std::int64_t>(x + 0.5));
  }
  [[nodiscard]] double arrival(int i) const noexcept { return flight_[i].arrival; }
  [[nodiscard]] bool earlier(int i, int j) const noexcept { return arrival(i) < arrival(j); }

  [[nodiscard]] bool is_lost(std::int64_t slot) noexcept {
    if (!parameters_.recorded.empty()) {
      recorded_ = parameters_.recorded[next_recorded_];
      next_recorded_ = next_recorded_ + 1 < parameters_.recorded.size() ? next_recorded_ + 1 : 0;
      if (recorded_ < 0.0) return true;
    }
    if (parameters_.burst_enter > 0.0)
      in_burst_ = in_burst_ ? random_.uniform() >= parameters_.burst_leave
                            : random_.uniform() < parameters_.burst_enter;
    if (in_burst_) {
      if (parameters_.burst_loss >= 1.0 || random_.uniform() < parameters_.burst_loss) return true;
    } else if (parameters_.loss > 0.0 && random_.uniform() < parameters_.loss) {
      return true;
    }
    if (parameters_.outage_length <= 0 || slot < parameters_.outage_start) return false;
    std::int64_t since = slot - parameters_.outage_start;
    if (parameters_.outage_period > 0) since %= parameters_.outage_period;
    return since < parameters_.outage_length;
  }

  [[nodiscard]] double draw_delay() noexcept {
    if (fate_.given) return fate_.delay_ticks;
    double delay = parameters_.delay_ticks;
    if (!parameters_.recorded.empty()) delay += recorded_;
    switch (parameters_.jitter) {
      case JitterKind::kNone:
        break;
      case JitterKind::kUniform:
        delay += random_.uniform(-parameters_.jitter_ticks, parameters_.jitter_ticks);
        break;
      case JitterKind::kNormal:
        delay += parameters_.jitter_ticks * random_.normal();
        break;
      case JitterKind::kExponential:
        delay += random_.exponential(parameters_.jitter_ticks);
        break;
      case JitterKind::kPareto:
        delay += parameters_.jitter_ticks * random_.netem_pareto();
        break;
      case JitterKind::kParetoNormal:
        delay += parameters_.jitter_ticks * random_.netem_pareto_normal();
        break;
    }
    if (parameters_.reorder > 0.0 && random_.uniform() < parameters_.reorder) return 0.0;
    return delay > 0.0 ? delay : 0.0;
  }

  void admit(const Message& message, std::int64_t slot, double late) noexcept {
    double at = static_cast<double>(slot) + draw_delay();
    if (late > 0.0) {  // 3.76 + 7.24 ticks are 11, not a rounding more
      at += late;
      if (const double whole = nearest(at); at - whole < 1e-9 && whole - at < 1e-9) at = whole;
    }
    const bool queued = parameters_.first_in_first_out || parameters_.service_ticks > 0.0;
    if (queued && at < last_arrival_) at = last_arrival_;
    at += parameters_.service_ticks;
    last_arrival_ = at;
    if (count_ == kCapacity) {
      remove(0);
      ++overflowed_;
    }
    flight_[count_++] = {message, slot, sequence_, at};
    if (at < next_arrival_) next_arrival_ = at;
  }

  void remove(int i) noexcept {
    for (int j = i + 1; j < count_; ++j) flight_[j - 1] = flight_[j];
    --count_;
    next_arrival_ = std::numeric_limits<double>::infinity();
    for (int j = 0; j < count_; ++j)
      if (flight_[j].arrival < next_arrival_) next_arrival_ = flight_[j].arrival;
  }

  LinkModelParameters parameters_;
  PacketFate fate_;
  Random random_;
  std::array<Flight, kCapacity> flight_{};
  int count_ = 0;
  bool in_burst_ = false;
  double next_arrival_ = std::numeric_limits<double>::infinity();
  double last_arrival_ = 0.0;
  std::size_t next_recorded_ = 0;
  double recorded_ = 0.0;  ///< of the packet being pushed
  std::uint64_t sequence_ = 0;
  std::int64_t lost_ = 0;
  std::int64_t overflowed_ = 0;
};

}  // namespace tandem::core
