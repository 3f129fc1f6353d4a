#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/scene.h"

namespace tandem::cli {

/// One run of a session as processes of this program on the loopback interface.
struct DemoRun {
  core::Scene scene;
  std::string scene_file;  ///< the scene as the nodes load it; written by run_nodes
  std::string folder;      ///< recordings and reports go here
  std::string prefix;      ///< of their names
  double seconds = 20.0;
  std::int64_t start_ns = 0;  ///< when slot 0 of every node is due, monotonic clock [ns]
  std::vector<std::string> node_arguments;  ///< given to every node
  std::string view_picture;  ///< a spectator's window, or this file without a display; empty: none
};

struct DemoNode {
  std::string name;       ///< "server", "client 2", "replica 1"
  std::string user;       ///< "server" for a server
  std::string recording;  ///< its file
  nlohmann::ordered_json report;
};

/// Starts all nodes of the scene's architecture together, shows how they go until they end, and
/// reads their reports. Whatever happens to this program, none of them goes on without it.
/// Throws Failed with what a node said when one ends badly.
[[nodiscard]] std::vector<DemoNode> run_nodes(const DemoRun& run);

}  // namespace tandem::cli
