#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/scene.h"

namespace tandem::harness {

/// One process of a session: what it is, and the words that start it.
struct PlannedNode {
  std::string name;  ///< "server", "client 2", "replica 1"
  std::string user;  ///< "server" for a server
  std::string recording, report_file;
  std::vector<std::string> words;  ///< after the program's own name
};

/// How the nodes of a session are told where and how long to run.
struct NodePlan {
  std::string scene_file;  ///< the scene as all of them load it
  std::string base;        ///< recordings and reports are BASE_server.h5, BASE_user_1.json, ...
  double seconds = 0.0;
  std::function<std::string(int)> address_of;  ///< "HOST:PORT" of site 0, 1, ...
  std::vector<std::string> more;               ///< given to every node
};

/// All nodes of the scene's architecture. Central: the server first, then a client for every user
/// who is not local; distributed: a replica for every user.
[[nodiscard]] std::vector<PlannedNode> plan_nodes(const core::Scene& scene, const NodePlan& plan);

/// How many there would be.
[[nodiscard]] int node_count(const core::Scene& scene);

}  // namespace tandem::harness
