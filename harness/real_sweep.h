#pragma once

#include <functional>
#include <string>
#include <vector>

#include "harness/point_result.h"
#include "harness/sweep.h"

namespace tandem::harness {

struct RealOptions {
  std::string program;  ///< tandem, as the nodes are started
  std::string name;     ///< of the namespaces
  std::string folder;   ///< scenes, recordings and reports of the nodes go here
  int at_once = 2;      ///< sessions that run at the same time, each in a network of its own
  /// More force loops than this are not started at the same time, whatever `at_once` says.
  int most_nodes = 4;
  bool carry = true;  ///< also a carry: gap, force error against the twin
  bool push = true;   ///< also a push: drag; axis scenes
};

/// Runs the points of a sweep on real sockets, one after the other. Of each point:
///   tandem probe through its conditions, one direction at a time (once for points alike);
///   the session, its hands kicked: delays in ticks and phases of the packet slots, stability;
///   the prediction, from these delays;
///   the session at 0.9 and 1.1 times the predicted largest stable coupling;
///   a push (drag) and a carry (gap, force error, energy).
/// A point whose node died is marked failed with what it said, and the sweep goes on. `progress`
/// gets the points done, all, and what is being done. Throws HarnessError when the networks cannot
/// be made, and Interrupted.
[[nodiscard]] std::vector<PointResult> run_real_sweep(
    const Sweep& sweep, const RealOptions& options,
    const std::function<void(int done, int all, const std::string& doing)>& progress = {});

/// The scene as nodes run it: a finger whose device is not limited gets one with the largest force
/// there is, because a node drives no device without a limit.
[[nodiscard]] core::Scene with_limited_devices(core::Scene scene);

}  // namespace tandem::harness
