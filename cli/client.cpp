#include <memory>

#include "arch_central/client_node.h"
#include "cli/beside_window.h"
#include "cli/commands.h"
#include "cli/node_command.h"
#include "scene/load_scene.h"

namespace tandem::cli {

namespace {

struct ClientArguments {
  NodeArguments node;
  std::string server, user, scene, bind = "0.0.0.0:0";
  std::vector<std::string> sets;
  double wait = 6.0;
};

}  // namespace

void add_client(CLI::App& app) {
  auto arguments = std::make_shared<ClientArguments>();
  CLI::App* command = app.add_subcommand("client", "one remote user of a `tandem server`");
  command->add_option("server", arguments->server, "HOST:PORT of the server")->required();
  command->add_option("--user", arguments->user,
                      "which user of the scene sits here (default: any free seat)");
  command->add_option("--scene", arguments->scene,
                      "scene, which must be the server's (default: the server sends its own)");
  command
      ->add_option("--set", arguments->sets,
                   "change one field of --scene, PATH=VALUE; what everyone must share has to stay")
      ->take_all()
      ->allow_extra_args(false);
  command->add_option("--bind", arguments->bind, "own ADDRESS:PORT; port 0: any")
      ->capture_default_str();
  command->add_option("--wait", arguments->wait, "how long to wait for the server's answer [s]")
      ->check(between(0.1, 1e6))
      ->capture_default_str();
  arguments->node.add(*command);
  command->callback([arguments] {
    const ClientArguments& a = *arguments;
    if (a.scene.empty() && !a.sets.empty())
      throw CLI::ValidationError("--set", "needs --scene; the server's own scene stays as it is");
    central::ClientOptions options;
    options.node = a.node.options(a.bind);
    options.server = a.server;
    options.user = a.user;
    options.wait = a.wait;
    if (!a.scene.empty()) options.scene = scene::load_scene(a.scene, a.sets);
    options.node.guard = a.node.guard(options.scene ? &*options.scene : nullptr);
    if (!a.node.view && a.node.hands != "pointer")
      return finish(central::run_client(options), a.node.json);
    if (a.scene.empty() || a.user.empty())
      throw CLI::ValidationError("--view", "needs --scene and --user: what and whom it shows");
    if (core::index_of(options.scene->users, a.user) < 0)
      throw CLI::ValidationError(
          "--user", "scene " + options.scene->name + " has no user \"" + a.user + "\"");
    run_node({*options.scene, a.user, a.user,
              [&](const node::NodeOptions& o) {
                options.node = o;
                return central::run_client(options);
              },
              a.server},
             options.node, a.node);
  });
}

}  // namespace tandem::cli
