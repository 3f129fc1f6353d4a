#pragma once

#include <array>
#include <cstddef>

#include "bench/latency_stages.h"
#include "core/scene.h"

namespace tandem::bench {

struct PathOptions {
  double seconds = 5.0;
  double phase = 0.5;  ///< of the second user's ticks against the first's, in periods
  int priority = 80;   ///< SCHED_FIFO of the force threads, as a node's; 0: ordinary
  bool watch = true;   ///< false: the link threads sleep from look to look, 40 us after the slot on
};

struct PathResult {
  std::array<PathRun, 2> runs;  ///< to user 2, to user 1
  std::size_t bytes = 0;        ///< of a datagram
  double processor = 0.0;       ///< of a core, of one replica: force loop with its spin, and link
};

/// Runs a distributed planar session of two users in real time over UDP on the loopback interface:
/// the force loop, law, devices and link threads of two replicas, in one process. Throws
/// std::runtime_error when it cannot.
[[nodiscard]] PathResult run_path(const core::Scene& scene, const PathOptions& options);

}  // namespace tandem::bench
