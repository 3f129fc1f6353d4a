#include <memory>

#include "arch_distributed/replica_node.h"
#include "cli/beside_window.h"
#include "cli/commands.h"
#include "cli/node_command.h"
#include "cli/options.h"
#include "scene/load_scene.h"

namespace tandem::cli {

namespace {

struct ReplicaArguments {
  std::string scene, join;
  std::vector<std::string> sets;
  NodeArguments node;
  std::string user, bind = "0.0.0.0:0";
  std::vector<std::string> peers;
};

distributed::ReplicaOptions options_of(const ReplicaArguments& a) {
  distributed::ReplicaOptions o;
  o.node = a.node.options(a.bind);
  o.user = a.user;
  for (const std::string& peer : a.peers) {
    const auto equals = peer.find('=');
    if (equals == 0 || equals == std::string::npos || equals + 1 == peer.size())
      throw CLI::ValidationError("--peer", "\"" + peer + "\" is not USER=HOST:PORT");
    o.peers.push_back({peer.substr(0, equals), peer.substr(equals + 1)});
  }
  return o;
}

void run(const core::Scene& scene, distributed::ReplicaOptions& options,
         const ReplicaArguments& a) {
  if (a.node.view && core::index_of(scene.users, a.user) < 0)
    throw CLI::ValidationError("--user", "scene " + scene.name + " has no user \"" + a.user + "\"");
  run_node({scene, a.user, a.user,
            [&](const node::NodeOptions& o) {
              options.node = o;
              return distributed::run_replica(scene, options);
            }},
           options.node, a.node);
}

}  // namespace

void add_replica(CLI::App& app) {
  auto arguments = std::make_shared<ReplicaArguments>();
  CLI::App* command = app.add_subcommand(
      "replica",
      "one workstation of a distributed session: its own copy of everything, no server.\n"
      "Users that come first in the scene are joined by those after them:\n"
      "  host a:  tandem replica --scene box_distributed --user 1 --bind 0.0.0.0:7001\n"
      "  host b:  tandem replica --scene box_distributed --user 2 --peer 1=a:7001");
  auto* scene = command->add_option("--scene", arguments->scene,
                                    "scene: a name (`tandem scene list`) or a file");
  command
      ->add_option("--join", arguments->join,
                   "HOST:PORT of a running replica of a user before ours: its scene is ours")
      ->excludes(scene);
  command
      ->add_option("--set", arguments->sets,
                   "change one field of --scene, PATH=VALUE; what everyone must share has to be "
                   "changed everywhere")
      ->take_all()
      ->allow_extra_args(false);
  command->add_option("--user", arguments->user, "which user of the scene sits here")->required();
  command->add_option("--bind", arguments->bind, "own ADDRESS:PORT; port 0: any")
      ->capture_default_str();
  command
      ->add_option("--peer", arguments->peers,
                   "USER=HOST:PORT of another replica; needed of every user before ours")
      ->take_all()
      ->allow_extra_args(false);
  arguments->node.add(*command);
  command->callback([arguments] {
    const ReplicaArguments& a = *arguments;
    distributed::ReplicaOptions options = options_of(a);
    if (a.join.empty()) {
      if (a.scene.empty())
        throw CLI::RequiredError("--scene NAME|FILE, or --join HOST:PORT of a running replica");
      const core::Scene own = scene::load_scene(a.scene, a.sets);
      options.node.guard = a.node.guard(&own);
      return run(own, options, a);
    }
    if (!a.sets.empty())
      throw CLI::ValidationError("--set", "needs --scene; with --join the scene is the host's");
    const distributed::FetchedScene fetched = distributed::fetch_scene(a.join, options);
    options.peers.push_back(fetched.host);
    options.node.guard = a.node.guard(&fetched.scene);
    run(fetched.scene, options, a);
  });
}

}  // namespace tandem::cli
