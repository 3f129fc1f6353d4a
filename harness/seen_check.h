#pragma once

#include <string>
#include <vector>

#include "harness/condition.h"

namespace tandem::harness {

struct SeenLink;

/// How `tandem probe` goes through a condition.
struct ProbePlan {
  double rate_hz = 500.0;
  double seconds = 2.0;
};
/// Long enough for what changes slowly.
[[nodiscard]] ProbePlan probe_plan(const Condition& condition);

/// What a probe should see of a condition, and how much runs of that length differ by chance: from
/// many runs of the modelled link (core/link_model.h) at ticks of 10 us, the same model that
/// virtual time uses.
struct ExpectedSight {
  double delay_p50 = 0.0, delay_p50_sd = 0.0;    ///< one way [s]
  double delay_sd = 0.0;                         ///< of one packet's delay [s]
  double delay_spread = 0.0;                     ///< from its 10th to its 90th percentile [s]
  double loss = 0.0, loss_sd = 0.0;              ///< of a run
  double duplicates = 0.0, duplicates_sd = 0.0;  ///< share of the packets sent
  /// Came after a later one, share of those sent; only where reordering is asked for: what jitter
  /// overtakes hangs on when exactly each packet leaves.
  double reordered = 0.0, reordered_sd = 0.0;
};
[[nodiscard]] ExpectedSight expected_sight(const Condition& condition, const ProbePlan& plan);

/// Standard deviation of the delay from its 10th and 90th percentiles, by the shape of what was
/// set: a stall of the machine that holds a few packets does not enter. That of all packets where
/// what was set has no such spread [s].
[[nodiscard]] double sd_by_spread(const SeenLink& seen);

/// Bounds: p50 of the delay within 0.3 ms, its standard deviation within 10 % (where it is more
/// than 0.5 ms: below, the machine's own shows), loss, duplicates and reordering within 99.9 % of
/// chance, the rate within 5 %; means of chance (3.3 standard deviations) are added where what is
/// drawn decides. One sentence for each that is out of its bound; empty: all are within.
[[nodiscard]] std::vector<std::string> out_of_bounds(const SeenLink& seen);

}  // namespace tandem::harness
