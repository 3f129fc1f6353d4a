#include <memory>

#include "arch_central/server_node.h"
#include "cli/beside_window.h"
#include "cli/commands.h"
#include "cli/node_command.h"
#include "cli/options.h"

namespace tandem::cli {

namespace {

struct ServerArguments {
  SceneOption scene;
  NodeArguments node;
  std::string bind = "0.0.0.0:7000";
};

}  // namespace

void add_server(CLI::App& app) {
  auto arguments = std::make_shared<ServerArguments>();
  CLI::App* command = app.add_subcommand(
      "server",
      "simulates the objects of a central session; users who are `local` in the scene sit here,\n"
      "the others join with `tandem client`. A scene with one user and no network runs here too");
  arguments->scene.add(*command);
  command->add_option("--bind", arguments->bind, "own ADDRESS:PORT; port 0: any")
      ->capture_default_str();
  arguments->node.add(*command);
  command->callback([arguments] {
    const core::Scene scene = arguments->scene.load();
    std::string user = "server";  // whose hand the window leads, where it leads one
    if (arguments->node.hands == "pointer")
      for (auto u = scene.users.rbegin(); u != scene.users.rend(); ++u)
        if (u->local || scene.architecture == core::Architecture::kSingle) user = u->name;
    node::NodeOptions options = arguments->node.options(arguments->bind);
    options.guard = arguments->node.guard(&scene);
    run_node({scene, "server", user,
              [&](const node::NodeOptions& o) { return central::run_server(scene, o); }},
             options, arguments->node);
  });
}

}  // namespace tandem::cli
