#pragma once

#include <functional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "harness/point_result.h"
#include "harness/sweep.h"

/// The part of `tandem netem` that uses real sockets.
namespace tandem::cli {

/// What the command line says beside the sweep.
struct RealRequest {
  bool quick = false;
  bool check = false, clean = false;
  std::string name;                     ///< of the namespaces; empty: tandem-<pid>
  std::string folder = "tandem-netem";  ///< recordings and reports of the nodes
  int at_once = 2;
  bool host_clock = false;  ///< of user-mode Linux
  /// Hidden: what the command is told that runs a part of a sweep in user-mode Linux.
  std::string part, part_results;
  [[nodiscard]] bool is_worker() const { return !part.empty() || !part_results.empty(); }
};

void add_real_options(CLI::App& command, RealRequest& request);

/// True: the command was one of the chores (clean up, look what there is) and is done.
[[nodiscard]] bool do_chores(const RealRequest& request);

/// A sweep's points on real sockets.
struct RealRun {
  std::vector<harness::PointResult> results;
  std::vector<std::string> left_out;  ///< points that were not run, and why
  std::string setting;  ///< kernel and what real-time setting was granted, for the report
};

/// How people hear of it. `progress(done, all, doing)` false: stops.
struct RealListener {
  std::function<bool(int, int, const std::string&)> progress;
  std::function<void(const std::string&)> say;  ///< a line beside the progress
};

/// Here where the kernel has netem, else as workers in user-mode Linux, one a processor. A point
/// that fails is marked and the sweep goes on. `boundaries` have what analysis says, and get what
/// sockets say.
[[nodiscard]] RealRun run_real(const harness::Sweep& sweep, const RealRequest& request,
                               std::vector<harness::DelayBoundary>& boundaries,
                               const RealListener& listener);

/// The life of a worker: its part of the sweep and of the boundaries, left in its file; progress on
/// standard output.
void run_real_part(const harness::Sweep& sweep, const RealRequest& request,
                   std::vector<harness::DelayBoundary> boundaries);

}  // namespace tandem::cli
