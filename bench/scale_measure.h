#pragma once

#include <string>

#include "bench/scale_scene.h"
#include "bench/scale_traffic.h"
#include "core/scene.h"

namespace tandem::bench {

struct ScaleWork {
  int rounds = 11;       ///< timed stretches of a tick; the median counts
  double seconds = 1.0;  ///< of the run in real time; 0: none
  int priority = 80;
};

/// A session of one size, as the build's capacities let it be.
struct ScaleRow {
  std::string architecture;  ///< "central" or "mesh"
  double packet_hz = 0.0;    ///< of every sender
  ScaleSize size;
  int most_users = 0, most_objects = 0;  ///< capacities of the laws that were measured
  double tick_ns = 0.0;                  ///< the server's, or that of one replica
  double virtual_speed = 0.0;            ///< the whole session on one core, times real time
  bool finite = true;                    ///< the session did not blow up
  int values_in = 0, values_out = 0;     ///< in a packet to and from the site
  bool fits = false;                     ///< both fit into a datagram
  Traffic traffic;                       ///< of the site; where it fits
};

/// Throws std::invalid_argument where the size is beyond the capacities.
[[nodiscard]] ScaleRow measure_scale(const core::Scene& given, const ScaleSize& size,
                                     const ScaleWork& work);

}  // namespace tandem::bench
