#pragma once

#include <string>
#include <vector>

#include "harness/measures.h"
#include "harness/prediction.h"
#include "harness/seen_check.h"
#include "harness/sweep.h"

namespace tandem::harness {

/// One direction of a link as it was seen, by `tandem probe` and in the recordings.
struct SeenLink {
  std::string from, to;                     ///< user's name, or "server"
  std::string set;                          ///< to_text of what was set
  double delay_p50 = kNotMeasured;          ///< one way, by probe [s]
  double delay_sd = kNotMeasured;           ///< by probe, sd_by_spread [s]
  double delay_rms = kNotMeasured;          ///< the same of all packets, stalls with them [s]
  double delay_spread = kNotMeasured;       ///< by probe, 10th to 90th percentile [s]
  double loss = kNotMeasured;               ///< by probe
  long long sent = 0, lost = 0;             ///< by probe
  long long duplicates = 0, reordered = 0;  ///< by probe
  double rate_set = 0.0, rate_seen = 0.0;   ///< by probe; 0: not limited [bit/s]
  bool changes = false;                     ///< an outage or a recorded network is played
  ExpectedSight expected;                   ///< what the probe should see
  double delay_ticks = kNotMeasured;        ///< from the slot of sending to that of first use, mean
  double phase_ticks = kNotMeasured;        ///< packet slots of `from` [ticks]
  double age_error_ticks = kNotMeasured;    ///< MeasuredLink's
  double used_share = kNotMeasured;         ///< of the packets sent: used by a tick of the receiver
};

/// The same session in virtual time, over the network packet by packet as the real one recorded it.
struct VirtualTwin {
  bool judged = false;
  bool stable = false;
  /// With 1.09 times more or less coupling it falls on the other side.
  bool near_boundary = false;
  double drag = kNotMeasured;  ///< [N s/m]
};

/// Ticks that a node missed, a share of those due, above which a session is compared with nothing:
/// neither the analysis nor virtual time misses any.
inline constexpr double kMostMissed = 0.01;

/// A real session at a multiple of the predicted largest coupling.
struct BoundaryTry {
  bool done = false;
  Stability stability;
  /// Its coupling over the largest one predicted from the delays of this very run, which are not
  /// exactly those of the run that the prediction was made from.
  double ratio = kNotMeasured;
  VirtualTwin twin;
  double missed_share = 0.0;  ///< of its ticks
};

/// What one point of a sweep gave, in virtual time or on real sockets.
struct PointResult {
  SweepPoint point;
  bool real = false;
  bool failed = false;  ///< a node died or would not start; `log` says why
  std::string log;
  double wall_seconds = 0.0;  ///< virtual; real sessions share their time with others'
  double session_seconds = 0.0;
  /// Of the samples that a site uses, over all ticks and links: what the network and the wait for
  /// the next packet make together [s].
  double mean_age = kNotMeasured;
  Prediction prediction;
  Measures measures;
  double largest_coupling = kNotMeasured;  ///< by search in virtual time [N/m]
  /// Real: the session at 0.9 and 1.1 times the predicted largest coupling.
  BoundaryTry below, above;
  VirtualTwin twin;                    ///< real: of the sessions as they are
  double missed_share = kNotMeasured;  ///< real: of the ticks due, the worst node of all sessions
  double kick_missed = 0.0, push_missed = 0.0;  ///< of those two sessions
  /// Real: drag over this network of a hold without compensation, of which that of the other styles
  /// is what is left or made up for [N s/m].
  double hold_drag = kNotMeasured;
  std::vector<SeenLink> seen;
};

/// Smallest one-way delay, the same both ways, with which a scene is no longer stable, as each
/// names it [s]; infinite: stable as far as was looked.
struct DelayBoundary {
  std::string scene;
  double tick = 1.0 / 1024.0;             ///< of the scene [s]
  double predicted = kNotMeasured;        ///< analysis, linearised at the grasp
  double in_virtual_time = kNotMeasured;  ///< search
  /// Sockets, as their samples came: mean of both directions.
  double real_stable = kNotMeasured;      ///< longest delay seen stable
  double real_not_stable = kNotMeasured;  ///< shortest delay seen not stable
  std::string failure;                    ///< sessions that did not run
};

/// A point where measured and predicted are on different sides, not within 10 % of the boundary, or
/// the drag is off by more than 10 %; with extrapolation by more than that and 2 % of the drag that
/// hold has there.
struct Disagreement {
  /// False: there is no exact prediction. The network has jitter or loss, and stands for a steady
  /// one of the same mean age.
  bool exact = true;
  std::string point, what;  ///< "stability: predicted stable (growth 0.991), measured not: ..."
};
[[nodiscard]] std::vector<Disagreement> disagreements(const std::vector<PointResult>& results);

/// The same of boundaries in delay: virtual time, or what is stable and what is not on sockets, off
/// the analysis by more than a tick and a tenth.
[[nodiscard]] std::vector<Disagreement> disagreements(const std::vector<DelayBoundary>& boundaries);

/// How many verdicts could be compared, not near a boundary, and how many drags.
struct Comparisons {
  int with_analysis = 0, with_virtual_time = 0;
  int near_boundary = 0;  ///< not compared with the analysis
  int missed_ticks = 0;   ///< compared with neither: kMostMissed
  int drags = 0;          ///< with the analysis
};
[[nodiscard]] Comparisons comparisons(const std::vector<PointResult>& results);

}  // namespace tandem::harness
