#pragma once

#include <string>

#include <nlohmann/json.hpp>

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

/// The same for results of several kinds, by a script of their own that reads them as JSON.
bool draw_json(const std::string& file, const std::string& script,
               const nlohmann::ordered_json& results);

/// Of a picture's name, for CLI11's check: what is wrong with it; empty: nothing.
[[nodiscard]] std::string picture_file(const std::string& file);

}  // namespace tandem::cli
