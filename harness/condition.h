#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/link_model.h"
#include "core/network_model.h"
#include "core/scene.h"

namespace tandem::harness {

/// How extra delay is spread. The tables are those of iproute2: Pareto is u^(-1/3) with its mean
/// taken out, scaled and cut at four; Pareto-normal is a quarter normal and three quarters Pareto.
enum class Distribution { kUniform, kNormal, kPareto, kParetoNormal };

/// Gilbert-Elliott, tc's `loss gemodel`: two states, judged once a packet.
struct Bursts {
  double enter = 0.0;         ///< p: chance to enter the bad state, (0, 1]
  double leave = 1.0;         ///< r: chance to leave it, (0, 1]
  double loss_inside = 1.0;   ///< 1 - h: loss in the bad state
  double loss_outside = 0.0;  ///< 1 - k: loss in the good state
  /// Fraction of packets lost in the long run.
  [[nodiscard]] double mean_loss() const {
    return (enter * loss_inside + leave * loss_outside) / (enter + leave);
  }
};

/// Everything sent within [start, start + length) is lost; again after every `period` if that is
/// not 0. Times from the start of the measured run.
struct Outage {
  double start = 0.0;   ///< [s]
  double length = 0.0;  ///< [s]
  double period = 0.0;  ///< [s]
};

/// A recorded network: what happened to packets sent at these times. A packet meets the fate of the
/// latest entry before it; after the end the series starts again.
struct RecordedSeries {
  std::string source;         ///< file it came from, for reports
  std::vector<double> time;   ///< sent, from the start of the recording, rising [s]
  std::vector<double> delay;  ///< one way [s]; not a number: lost
};

/// One direction of a link: what tc netem is told in real runs, and LinkModelParameters in virtual
/// time. Semantics are netem's: every packet draws its own delay, so jitter reorders.
struct Condition {
  double delay = 0.0;   ///< one way [s]
  double jitter = 0.0;  ///< uniform: half width; else the standard deviation of the table [s]
  Distribution distribution = Distribution::kNormal;
  double correlation = 0.0;        ///< of successive delays, [0, 1), as netem draws it
  double loss = 0.0;               ///< [0, 1], each packet by itself; not together with bursts
  std::optional<Bursts> bursts{};  ///< instead of `loss`
  double duplicate = 0.0;          ///< [0, 1]
  double reorder = 0.0;            ///< [0, 1]: sent at once, past those delayed; needs a delay
  double rate_bit_per_s = 0.0;     ///< of the line, packets queue behind each other; 0: no limit
  std::optional<Outage> outage{};
  std::shared_ptr<const RecordedSeries> recorded{};  ///< instead of delay, jitter and loss
};

/// Both directions. `there` is from a lower to a higher user, and central from the server to its
/// clients; `back` is the other one. With more than two users they must be equal, because netem
/// stands at a workstation's way out and treats all its packets alike.
struct LinkConditions {
  Condition there, back;
};

/// Nothing is done to packets: a real run then needs no netem.
[[nodiscard]] bool is_clear(const Condition& condition);

/// What is wrong with it, one sentence with field, value, what is allowed; empty: nothing. What
/// netem cannot do (loss and bursts, reordering without delay...) is wrong in virtual time too.
[[nodiscard]] std::string problem_with(const Condition& condition);

/// Short text for tables: "5 ms, sd 1 ms normal, loss 5 %"; "clear" for nothing. Everything is in
/// it: conditions of the same text are the same.
[[nodiscard]] std::string to_text(const Condition& condition);

/// Arguments after `tc qdisc ... netem`; empty for a clear condition. Outages and recordings are
/// not netem's: the runner plays them with `tc qdisc change` (their delay at time t is in the
/// arguments of `at_time`).
[[nodiscard]] std::vector<std::string> netem_arguments(const Condition& condition);

/// The condition that holds at `time` from the start: recordings become a constant delay or total
/// loss, outages total loss; the rest stays. For runners that change netem as they go.
[[nodiscard]] Condition at_time(const Condition& condition, double time);

/// Recordings as the modelled link wants them, packet by packet; loops point into it, so it must
/// outlive them. Not for several threads at once.
class FateStore {
 public:
  FateStore();
  /// Extra delay of every packet sent at the packet rate [ticks]; negative: lost.
  [[nodiscard]] const std::vector<double>& fates(const RecordedSeries& series,
                                                 const core::Rates& rates);

 private:
  struct Entry {
    const RecordedSeries* series;
    double packet_hz, local_hz;
    std::unique_ptr<std::vector<double>> fates;
  };
  std::vector<Entry> entries_;
};

/// One link in virtual time. `bytes` of a packet count for the rate, all headers down to Ethernet
/// as netem does. Delays are drawn one by one whatever `correlation` says: netem takes the
/// remainder of its correlated number by the size of its table, which leaves nothing of it.
[[nodiscard]] core::LinkModelParameters modelled_link(const Condition& condition,
                                                      const core::Rates& rates, std::uint64_t seed,
                                                      int bytes, FateStore& fates);

/// Every link of the session, each with a seed of its own drawn from `seed`. Ages are reckoned as
/// by nodes, whose clocks know of each other by packets both ways: half the round trip.
[[nodiscard]] core::NetworkModel modelled_network(const LinkConditions& conditions,
                                                  const core::Scene& scene, std::uint64_t seed,
                                                  FateStore& fates);

/// Bytes on the wire (payload, UDP, IP and Ethernet headers) of a state packet of this scene, at
/// most.
[[nodiscard]] int packet_bytes(const core::Scene& scene);

}  // namespace tandem::harness
