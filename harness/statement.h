#pragma once

#include <string>
#include <vector>

#include "harness/contest.h"

namespace tandem::harness {

/// Sentences for people, made from these contests only: how to read them; then for each
/// architecture which reconstruction has the least force error and which the largest stable
/// coupling at each value of the knob, how much of hold's margin compensation leaves, from which to
/// which age of the samples extrapolation wins, and what failed. Empty without contests.
[[nodiscard]] std::vector<std::string> statement(const std::vector<Contests>& contests);

/// The numbers behind them, a table for each architecture, for a terminal.
[[nodiscard]] std::string contest_table(const std::vector<Contests>& contests);

}  // namespace tandem::harness
