#pragma once

#include <vector>

#include <nlohmann/json.hpp>

#include "harness/contest.h"

namespace tandem::cli {

/// What the statement of a sweep is made from, one object an architecture.
[[nodiscard]] nlohmann::ordered_json to_json(const std::vector<harness::Contests>& contests);

/// A finite number, null, or "infinite": stable as far as was looked is something to say.
[[nodiscard]] nlohmann::ordered_json number_or_word(double x);

}  // namespace tandem::cli
