#pragma once

#include <string>
#include <vector>

#include "harness/measures.h"
#include "harness/prediction.h"
#include "harness/sweep.h"

namespace tandem::harness {

/// One direction of a link as it was seen, by `tandem probe` and in the recordings.
struct SeenLink {
  std::string from, to;               ///< user's name, or "server"
  std::string set;                    ///< to_text of what was set
  double delay_p50 = kNotMeasured;    ///< one way, by probe [s]
  double delay_sd = kNotMeasured;     ///< by probe [s]
  double loss = kNotMeasured;         ///< by probe
  long long sent = 0, lost = 0;       ///< by probe
  double delay_ticks = kNotMeasured;  ///< from the slot of sending to that of first use, mean
  double phase_ticks = kNotMeasured;  ///< packet slots of `from` [ticks]
};

/// What one point of a sweep gave, in virtual time or on real sockets.
struct PointResult {
  SweepPoint point;
  bool real = false;
  bool failed = false;  ///< a node died or would not start; `log` says why
  std::string log;
  double wall_seconds = 0.0, session_seconds = 0.0;
  /// Of the samples that a site uses, over all ticks and links: what the network and the wait for
  /// the next packet make together [s].
  double mean_age = kNotMeasured;
  Prediction prediction;
  Measures measures;
  double largest_coupling = kNotMeasured;  ///< by search (virtual) [N/m]
  /// Real: the session at 0.9 and 1.1 times the predicted largest coupling.
  bool tried_below = false, tried_above = false;
  Stability below, above;
  std::vector<SeenLink> seen;
};

/// Smallest one-way delay, the same both ways, with which a scene is no longer stable, as each
/// names it [s]; infinite: stable as far as was looked.
struct DelayBoundary {
  std::string scene;
  double predicted = kNotMeasured;        ///< analysis, linearised at the grasp
  double in_virtual_time = kNotMeasured;  ///< search
  double real_stable = kNotMeasured;      ///< longest delay seen stable on sockets
  double real_not_stable = kNotMeasured;  ///< shortest delay seen not stable
};

/// A point where measured and predicted are on different sides, not within 10 % of the boundary, or
/// the drag is off by more than 10 %.
struct Disagreement {
  /// False: the network has jitter or loss, for which there is no exact prediction, only that of a
  /// steady network of the same mean age.
  bool exact = true;
  std::string point, what;  ///< "stability: predicted stable (growth 0.991), measured not: ..."
};
[[nodiscard]] std::vector<Disagreement> disagreements(const std::vector<PointResult>& results);

}  // namespace tandem::harness
