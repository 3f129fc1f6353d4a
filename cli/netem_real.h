#pragma once

#include <functional>
#include <optional>
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
};

void add_real_options(CLI::App& command, RealRequest& request);

/// True: the command was one of the chores (clean up, look what there is) and is done.
[[nodiscard]] bool do_chores(const RealRequest& request);

/// Exit status of the same command run where netem is, if it is not here; empty: go on here.
[[nodiscard]] std::optional<int> run_elsewhere(const RealRequest& request);

/// A sweep's points on real sockets.
struct RealRun {
  std::vector<harness::PointResult> results;
  std::vector<std::string> left_out;  ///< points that were not run, and why
};

/// A point that fails is marked and the sweep goes on. `boundaries` have what analysis says, and
/// get what sockets say. `progress(done, all, doing)` false: stops.
[[nodiscard]] RealRun run_real(const harness::Sweep& sweep, const RealRequest& request,
                               std::vector<harness::DelayBoundary>& boundaries,
                               const std::function<bool(int, int, const std::string&)>& progress);

/// Machine and what real-time setting was granted, for the report.
[[nodiscard]] std::string real_setting();

}  // namespace tandem::cli
