#pragma once

#include <istream>
#include <string>
#include <vector>

#include "analysis/experiments.h"

namespace tandem::analysis {

/// One expected value beside ours.
struct CheckRow {
  std::string kind;  ///< interval, count, damping, radius, response, stiffness
  std::string name;
  std::string expected, found;  ///< as printed
  double deviation = 0.0;       ///< relative; for counts, how many cells; infinite: other shape
  double limit = 0.0;
  [[nodiscard]] bool passed() const { return deviation <= limit; }
};

/// Computes every line of a file of expected values (its form is said at its head) whose kind and
/// name contain `filter`. Limits: ends of intervals 1e-6 relative, counts exact, damping 1e-9,
/// radii 1e-10. Throws std::runtime_error with the line number where a line is not understood.
[[nodiscard]] std::vector<CheckRow> check_against(std::istream& expected, const SceneSource& scenes,
                                                  const std::string& filter = "");

}  // namespace tandem::analysis
