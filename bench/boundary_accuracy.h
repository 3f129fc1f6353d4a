#pragma once

#include <string>

#include <nlohmann/json.hpp>

namespace tandem::bench {

/// Time against error of each way to the boundary of Fig 5.4, d = 1, along its 100 columns: batched
/// numpy (`peer`: what bench/stability_maps.py printed under "line"), eigenvalues of the resampled
/// and of the measured map, the Routh test, and the boundary traced over the whole plane. Errors
/// are relative, against eigenvalues to 1e-13. Appends a table to `text`.
[[nodiscard]] nlohmann::ordered_json accuracy_table(const nlohmann::json& peer, std::string& text);

}  // namespace tandem::bench
