#include "cli/beside_window.h"
#include "cli/commands.h"

namespace tandem::cli {

namespace {

constexpr const char* kNoWindow =
    "this program was built without a window. Install libglfw3-dev libepoxy-dev libimgui-dev "
    "libpng-dev libx11-dev, then configure and build again (scripts/demo does both).";

}  // namespace

void run_node(const WindowedNode& node, node::NodeOptions options, const NodeArguments& arguments) {
  if (arguments.view || arguments.hands == "pointer")
    throw Failed(std::string("--view: ") + kNoWindow);
  finish(node.run(options), arguments.json);
}

void add_view(CLI::App& app) {
  CLI::App* command = app.add_subcommand("view", "a window on a session (not in this build)");
  command->allow_extras();
  command->callback([] { throw Failed(std::string("view: ") + kNoWindow); });
}

}  // namespace tandem::cli
