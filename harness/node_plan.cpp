#include "harness/node_plan.h"

#include <fmt/format.h>

namespace tandem::harness {
namespace {

[[nodiscard]] bool has_server(const core::Scene& scene) {
  return scene.architecture == core::Architecture::kCentral ||
         scene.architecture == core::Architecture::kSingle;
}

[[nodiscard]] bool sits_at_server(const core::Scene& scene, const core::UserParameters& user) {
  return has_server(scene) && (user.local || scene.architecture == core::Architecture::kSingle);
}

void append(std::vector<std::string>& words, const std::vector<std::string>& more) {
  words.insert(words.end(), more.begin(), more.end());
}

}  // namespace

int node_count(const core::Scene& scene) {
  int count = has_server(scene) ? 1 : 0;
  for (const core::UserParameters& user : scene.users)
    if (!sits_at_server(scene, user)) ++count;
  return count;
}

std::vector<PlannedNode> plan_nodes(const core::Scene& scene, const NodePlan& plan) {
  std::vector<PlannedNode> nodes;
  const auto add = [&](const std::string& role, const std::string& user) -> PlannedNode& {
    PlannedNode& node = nodes.emplace_back();
    node.user = user;
    node.name = role == "server" ? role : role + " " + user;
    const std::string base = plan.base + "_" + (role == "server" ? role : "user_" + user);
    node.recording = base + ".h5";
    node.report_file = base + ".json";
    node.words = {role};
    return node;
  };
  if (has_server(scene)) append(add("server", "server").words, {"--scene", plan.scene_file});
  for (std::size_t u = 0; u < scene.users.size(); ++u) {
    const core::UserParameters& user = scene.users[u];
    if (sits_at_server(scene, user)) continue;
    if (has_server(scene)) {
      append(add("client", user.name).words,
             {plan.address_of(0), "--user", user.name, "--scene", plan.scene_file});
      continue;
    }
    PlannedNode& replica = add("replica", user.name);
    append(replica.words, {"--scene", plan.scene_file, "--user", user.name});
    for (std::size_t j = 0; j < u; ++j)
      append(replica.words,
             {"--peer", scene.users[j].name + "=" + plan.address_of(static_cast<int>(j))});
  }
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    append(nodes[i].words, {"--bind", plan.address_of(static_cast<int>(i)), "--seconds",
                            fmt::format("{}", plan.seconds), "--record", nodes[i].recording,
                            "--json", nodes[i].report_file});
    append(nodes[i].words, plan.more);
  }
  return nodes;
}

}  // namespace tandem::harness
