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
