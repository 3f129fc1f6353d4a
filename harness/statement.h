#pragma once

#include <string>
#include <vector>

#include "harness/point_result.h"

namespace tandem::harness {

/// Sentences, made from these results only, on which reconstruction wins where: by force error
/// against the ideal twin, by largest stable coupling, by drag; and what fails. Points with the
/// same architecture and label are compared; a session that is not stable loses to one that is.
[[nodiscard]] std::vector<std::string> statement(const std::vector<PointResult>& results);

}  // namespace tandem::harness
