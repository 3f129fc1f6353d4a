#pragma once

#include <functional>
#include <string>

#include "cli/node_command.h"
#include "core/scene.h"

namespace tandem::cli {

/// A node and what its window has to know of it.
struct WindowedNode {
  core::Scene scene;
  std::string user;     ///< whose node; "server" for a server
  std::string pointer;  ///< whose fingers a pointer leads there
  std::function<node::NodeReport(const node::NodeOptions&)> run;
  std::string server{};  ///< of a client: HOST:PORT where its window asks for the others' hands
};

/// Runs the node and finishes it (`finish`); with --view in a thread beside a window on the main
/// thread, which gets its state through the newest-value slots of a core::ViewTap. Whatever becomes
/// of the window, the node goes on to its end. Throws Failed as `finish` does.
void run_node(const WindowedNode& node, node::NodeOptions options, const NodeArguments& arguments);

}  // namespace tandem::cli
