#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "harness/point_result.h"
#include "harness/sweep.h"

namespace tandem::cli {

/// Everything a report needs beside the results.
struct SweepRun {
  harness::Sweep sweep;
  std::vector<harness::PointResult> results;
  std::vector<harness::DelayBoundary> boundaries;
  bool real = false;
  std::uint64_t seed = 1;
  double wall_seconds = 0.0;
  std::string setting;                ///< what was granted (real)
  std::vector<std::string> left_out;  ///< points that this machine does not carry (real), why
};

/// [points], [disagreements] and all that was measured and predicted.
[[nodiscard]] nlohmann::ordered_json to_json(const SweepRun& run);

/// One row a point.
[[nodiscard]] std::string to_csv(const SweepRun& run);

/// Short table for a terminal, the statement and the disagreements.
[[nodiscard]] std::string to_text(const SweepRun& run);

/// One self-contained page, by scripts/netem_report.py; throws Failed where that cannot run.
void write_report(const std::string& file, const nlohmann::ordered_json& json);

}  // namespace tandem::cli
