#pragma once

#include <string>

#include "analysis/experiments.h"

namespace tandem::cli {

/// Comma-separated text with a header line, shortest numbers that read back the same.
[[nodiscard]] std::string to_csv(const analysis::Table& table);

/// `file` with `_name` before its extension.
[[nodiscard]] std::string with_suffix(const std::string& file, const std::string& name);

/// Draws a table with matplotlib through plot_table.py, which knows what belongs on which axes for
/// each `kind`. Where python3 or matplotlib is missing it says so, names the package and goes on;
/// returns whether there is a picture.
bool draw(const std::string& file, const std::string& kind, const analysis::Table& table);

}  // namespace tandem::cli
