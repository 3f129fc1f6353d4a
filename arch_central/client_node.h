#pragma once

#include <optional>
#include <string>

#include "core/scene.h"
#include "node/node_options.h"
#include "node/node_report.h"

namespace tandem::central {

struct ClientOptions {
  node::NodeOptions node;
  std::string server;                ///< "HOST:PORT"
  std::string user;                  ///< empty: any free seat
  std::optional<core::Scene> scene;  ///< not given: the server's
  double wait = 6.0;                 ///< for the server's answer [s]
};

/// Runs one remote user of a central session until its time is over or it is stopped. Throws before
/// anything runs: std::runtime_error and std::invalid_argument in words for the user (no server
/// there, refused and why, ...).
[[nodiscard]] node::NodeReport run_client(const ClientOptions& options);

}  // namespace tandem::central
