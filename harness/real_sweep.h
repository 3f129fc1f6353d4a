#pragma once

#include <functional>
#include <string>
#include <vector>

#include "harness/part_results.h"
#include "harness/point_result.h"
#include "harness/real_network.h"
#include "harness/sweep.h"

namespace tandem::harness {

struct RealOptions {
  NodeProgram program;
  std::string name;    ///< of the namespaces
  std::string folder;  ///< scenes, recordings and reports of the nodes go here
  int at_once = 2;     ///< sessions that run at the same time, each in a network of its own
  /// More force loops than this are not started at the same time, whatever `at_once` says.
  int most_nodes = 4;
  bool carry = true;  ///< also a carry: gap, force error against the twin
  bool push = true;   ///< also a push: drag; axis scenes
  bool touch = true;  ///< also a touch: rendered stiffness, motion to force; axis scenes
  bool probe = true;  ///< first tandem probe through all conditions
  bool tries = true;  ///< also at 0.9 and 1.1 times the predicted largest coupling
  SweepPart part;     ///< only these points, and its share of the sessions for boundaries
};

/// Gets the sessions done, how many there will be at most, and what is being done.
using RealProgress = std::function<void(int done, int all, const std::string& doing)>;

/// Runs the points of a sweep on real sockets, sessions of several points at a time:
///   tandem probe through every condition, one direction at a time (once for conditions alike);
///   each point's session, its hands kicked: delays in ticks and phases of the packet slots,
///   stability; a push (drag), a touch (stiffness, motion to force) and a carry (gap, force error,
///   energy);
///   the predictions, from these delays, and the same session in virtual time over the network that
///   it recorded, whose largest stable coupling is searched;
///   each point's session at 0.9 and 1.1 times the predicted largest stable coupling.
/// A point whose node died is marked failed with what it said, and the sweep goes on. Only the
/// points of `options.part` come back; files are numbered by the whole sweep. `wall_seconds` stays
/// 0: here the clock may be a guest's. Throws HarnessError when the networks cannot be made, and
/// Interrupted.
[[nodiscard]] std::vector<PointResult> run_real_sweep(const Sweep& sweep,
                                                      const RealOptions& options,
                                                      const RealProgress& progress = {});

/// Fills what sockets say of boundaries that analysis has named: kicked sessions at one-way delays
/// of whole ticks about it, of `seconds` each; `few`: one on each side. Never throws for a session
/// that fails (`failure` says it).
void find_real_boundaries(std::vector<DelayBoundary>& boundaries, const RealOptions& options,
                          double seconds, bool few, const RealProgress& progress = {});

}  // namespace tandem::harness
