#include <memory>

#include "arch_distributed/replica_node.h"
#include "cli/commands.h"
#include "cli/node_command.h"
#include "cli/options.h"

namespace tandem::cli {

namespace {

struct ReplicaArguments {
  SceneOption scene;
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

}  // namespace

void add_replica(CLI::App& app) {
  auto arguments = std::make_shared<ReplicaArguments>();
  CLI::App* command = app.add_subcommand(
      "replica",
      "one workstation of a distributed session: its own copy of everything, no server.\n"
      "Users that come first in the scene are joined by those after them:\n"
      "  host a:  tandem replica --scene box_distributed --user 1 --bind 0.0.0.0:7001\n"
      "  host b:  tandem replica --scene box_distributed --user 2 --peer 1=a:7001");
  arguments->scene.add(*command);
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
    const core::Scene scene = arguments->scene.load();
    finish(distributed::run_replica(scene, options_of(*arguments)), arguments->node.json);
  });
}

}  // namespace tandem::cli
