#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include "cli/options.h"
#include "cli/window_arguments.h"
#include "view/viewer.h"

namespace tandem::cli {

/// What arrows, rings and dots mean in a scene.
[[nodiscard]] std::string legend_of(const core::Scene& scene, bool pointer);
/// Predicted stability of the scene in a line; says why where there is none.
[[nodiscard]] std::string margin_of(const core::Scene& scene, double delay_packets);

[[nodiscard]] nlohmann::ordered_json to_json(const core::Scene& scene,
                                             const view::ViewerReport& report);

}  // namespace tandem::cli
