#pragma once

#include <string>
#include <vector>

namespace tandem::devices {

/// Chosen columns of a file of separated values, plain or packed by gzip. Comma, semicolon or tab,
/// whichever the first line has most of; the first line may be a heading; empty lines and lines
/// that begin with # are skipped.
///
/// `columns`: names of the heading, or "#1" for the first column and so on. Returns one vector of
/// numbers a column, in that order. Throws std::runtime_error with file, line, column and text.
[[nodiscard]] std::vector<std::vector<double>> read_csv_columns(
    const std::string& file, const std::vector<std::string>& columns);

}  // namespace tandem::devices
