#pragma once

#include <string>
#include <vector>

#include "core/network_model.h"
#include "core/scene.h"
#include "harness/measures.h"
#include "harness/real_network.h"

namespace tandem::harness {

/// How samples came over one direction of a link, from what its receiver recorded. Slots of all
/// nodes are those of one clock, due at the same instants, so delays in ticks are exact.
struct MeasuredLink {
  int from = 0, to = 0;  ///< users, or core::NetworkModel::kServer
  std::string from_name, to_name;
  std::int64_t used = 0;    ///< packets that a tick used
  std::int64_t sent = 0;    ///< from the first to the last of these
  double mean_ticks = 0.0;  ///< from the slot of the state to that of its first use
  double sd_ticks = 0.0;
  int usual_ticks = 0;       ///< the most frequent
  double usual_share = 0.0;  ///< how many of all
  int least_ticks = 0, most_ticks = 0;
  int phase_ticks = 0;    ///< of the sender's packet slots, the most frequent: slot mod N
  double mean_age = 0.0;  ///< of the sample in use, over all ticks, exact slots [ticks]
  /// What the receiver took for the age of the sample in use, less that age; mean; of users'
  /// samples only [ticks]. Two clocks are known to each other to half of what their two directions
  /// differ by.
  double age_error_ticks = 0.0;
  /// The steady delay whose samples have that mean age: it counts loss and overtaken packets in
  /// [ticks].
  double steady_ticks = 0.0;
  /// What became of each packet of the sender from slot 0 on, as used: its delay [ticks], or -1:
  /// lost, overtaken or late by more than a tick's turn. Before the first, and once the session has
  /// blown up: the usual delay.
  std::vector<double> fates;
};

/// What the recordings of a session hold.
struct RecordedSession {
  Trajectory trajectory;
  std::vector<MeasuredLink> links;
  double missed_share = 0.0;  ///< of the ticks due, at the node that missed most
};

/// Reads the recordings of a session that ended well. Measures begin where every site has heard
/// every peer it should hear, and end with the shortest recording; those of links end before a
/// session that blows up has numbers that receivers refuse. Throws
/// recording::RecordingError, or HarnessError when a peer was never heard.
[[nodiscard]] RecordedSession read_session(const RealSession& session, const core::Scene& scene,
                                           int packet_bytes);

/// The measured links as the network of a prediction: constant delays (steady_ticks, which are no
/// whole ticks), ages as far off as there, and the phases of the packet slots.
[[nodiscard]] core::NetworkModel measured_network(const std::vector<MeasuredLink>& links);

/// The measured links packet by packet, for virtual time, with the ages as far off: `links` must
/// outlive it.
[[nodiscard]] core::NetworkModel replayed_network(const std::vector<MeasuredLink>& links);

}  // namespace tandem::harness
