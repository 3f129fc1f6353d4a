#pragma once

#include <functional>
#include <istream>
#include <string>
#include <vector>

#include "analysis/experiments.h"

namespace tandem::analysis {

/// One expected value beside ours.
struct CheckRow {
  std::string
      kind;  ///< interval, count, damping, radius, response...; the file says which are there
  std::string name;
  double round_trip = 0.0;      ///< [packet periods]
  std::string expected, found;  ///< as printed
  double deviation = 0.0;       ///< relative; for counts, how many cells; infinite: other shape
  double limit = 0.0;
  [[nodiscard]] bool passed() const { return deviation <= limit; }
};

/// Which lines to compute: by kind, name and round trip [packet periods].
using CheckFilter =
    std::function<bool(const std::string& kind, const std::string& name, double round_trip)>;

/// Computes every line of a file of expected values (its form is said at its head) that `wanted`
/// lets through. Limits: ends of intervals 1e-6 relative, counts exact, damping, stiffness and
/// responses 1e-9, radii 1e-10. Throws std::runtime_error with the line number where a line is not
/// understood.
[[nodiscard]] std::vector<CheckRow> check_against(std::istream& expected, const SceneSource& scenes,
                                                  const CheckFilter& wanted);

/// Lines whose "kind name" contains `filter`.
[[nodiscard]] std::vector<CheckRow> check_against(std::istream& expected, const SceneSource& scenes,
                                                  const std::string& filter = "");

}  // namespace tandem::analysis
