#pragma once

#include "core/scene.h"
#include "node/node_options.h"
#include "node/node_report.h"

namespace tandem::central {

/// Runs the server of a central session, with the local users of the scene on this machine, until
/// its time is over or it is stopped. A scene of architecture SINGLE runs too: all its users are
/// local and nobody can join. Throws before anything runs: std::runtime_error and
/// std::invalid_argument in words for the user.
[[nodiscard]] node::NodeReport run_server(const core::Scene& scene,
                                          const node::NodeOptions& options);

}  // namespace tandem::central
