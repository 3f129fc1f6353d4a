#pragma once

#include <string>
#include <vector>

#include "analysis/reference_case.h"
#include "analysis/reference_check.h"

namespace tandem::analysis::reference {

/// Computes one line: `fields` as split at '|', `c` its scene. Fills expected, found, deviation and
/// limit. Throws std::logic_error where the line is not understood.
void compute(const std::vector<std::string>& fields, Case c, CheckRow& row);

/// Where a scene is stable: interval, count, nearest, least, fold, scan, edge.
/// Returns whether `row.kind` is one of them.
bool compute_region(const std::vector<std::string>& fields, Case& c, CheckRow& row);

/// `found` beside `expected`, relative; absolute where `expected` is zero.
void compare(double found, double expected, double limit, CheckRow& row);

}  // namespace tandem::analysis::reference
