#pragma once

#include <string>
#include <vector>

#include "core/scene.h"
#include "node/node_options.h"
#include "node/node_report.h"

namespace tandem::distributed {

struct ReplicaOptions {
  node::NodeOptions node;
  std::string user;  ///< of the scene, who sits here
  struct Peer {
    std::string user;
    std::string address;  ///< "HOST:PORT"; needed of users before us in the scene, whom we join
  };
  std::vector<Peer> peers;
};

/// The scene of a running replica, and who sits there.
struct FetchedScene {
  core::Scene scene;
  ReplicaOptions::Peer host;
};
/// Asks the replica at `host` ("HOST:PORT") for its scene, as `options.user`. Throws
/// std::runtime_error: no answer, refused and why, not a distributed session.
[[nodiscard]] FetchedScene fetch_scene(const std::string& host, const ReplicaOptions& options);

/// Runs one workstation of a distributed session until its time is over or it is stopped. Returns
/// how it went, a refusal included (`failure`). Throws before anything runs: std::runtime_error and
/// std::invalid_argument in words for the user (port in use, unknown user, ...).
[[nodiscard]] node::NodeReport run_replica(const core::Scene& scene, const ReplicaOptions& options);

}  // namespace tandem::distributed
