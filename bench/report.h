#pragma once

#include <algorithm>
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace tandem::bench {

/// Of at least one value.
[[nodiscard]] inline double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
  return values[values.size() / 2];
}

/// Nothing where no file is named; throws std::runtime_error where it cannot be written.
inline void write_csv(const std::string& file, const std::string& text) {
  if (file.empty()) return;
  std::ofstream out(file);
  out << text;
  if (!out.flush()) throw std::runtime_error("cannot write " + file);
}

/// Text to the terminal, and one JSON object to `json_file` if there is one; "-" prints the object
/// instead of the text.
inline void report(const std::string& json_file, const std::string& text,
                   const nlohmann::ordered_json& json) {
  if (json_file == "-") {
    fmt::print("{}\n", json.dump(2));
    return;
  }
  fmt::print("{}", text);
  if (json_file.empty()) return;
  std::ofstream file(json_file);
  file << json.dump(2) << "\n";
  if (!file.flush()) throw std::runtime_error("cannot write " + json_file);
}

}  // namespace tandem::bench
