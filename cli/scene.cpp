#include <fmt/format.h>

#include "cli/commands.h"
#include "cli/options.h"
#include "scene/load_scene.h"
#include "scene/scene_error.h"

namespace tandem::cli {

namespace {

struct SceneCommand {
  SceneOption scene;
  JsonOption json;
};

const char* space_name(core::Space space) {
  switch (space) {
    case core::Space::kAxis:
      return "axis";
    case core::Space::kPlane:
      return "plane";
    case core::Space::kSpace:
      return "space";
  }
  return "?";
}

core::Scene load_or_tell(const SceneCommand& o) {
  try {
    return o.scene.load();
  } catch (const scene::SceneError& e) {
    nlohmann::ordered_json problems = nlohmann::ordered_json::array();
    for (const scene::Problem& p : e.problems())
      problems.push_back({{"field", p.path}, {"problem", p.text}, {"where", p.where}});
    o.json.write({{"scene", o.scene.scene}, {"valid", false}, {"problems", problems}});
    throw;
  }
}

void check(const SceneCommand& o) {
  const core::Scene scene = load_or_tell(o);
  const std::string hash = fmt::format("{:016x}", scene::shared_hash(scene));
  if (!o.json.to_stdout())
    fmt::print("{}: valid. {}; {} users, {} objects, {} walls, {} couplers; hash {}\n", scene.name,
               space_name(scene.space), scene.users.size(), scene.objects.size(),
               scene.walls.size(), scene.couplers.size(), hash);
  o.json.write({{"scene", scene.name},
                {"valid", true},
                {"space", space_name(scene.space)},
                {"users", scene.users.size()},
                {"hash", hash}});
}

CLI::App* add(CLI::App* parent, const char* name, const char* what,
              void (*action)(const SceneCommand&)) {
  auto o = std::make_shared<SceneCommand>();
  CLI::App* command = parent->add_subcommand(name, what);
  o->json.add(*command);
  o->scene.add(*command);
  command->callback([o, action] { action(*o); });
  return command;
}

}  // namespace

void add_scene(CLI::App& app) {
  CLI::App* command = app.add_subcommand("scene", "look at scenes and check them");
  command->require_subcommand(1);
  add(command, "check", "read, validate, say everything that is wrong", check);
  add(command, "show", "the whole scene with every default filled in", [](const SceneCommand& o) {
    const std::string text = scene::to_text(o.scene.load());
    if (!o.json.to_stdout()) fmt::print("{}", text);
    o.json.write({{"text", text}});
  });
  add(command, "hash", "hash of what all workstations must share", [](const SceneCommand& o) {
    const std::string hash = fmt::format("{:016x}", scene::shared_hash(o.scene.load()));
    if (!o.json.to_stdout()) fmt::print("{}\n", hash);
    o.json.write({{"hash", hash}});
  });
  auto json = std::make_shared<JsonOption>();
  CLI::App* list = command->add_subcommand("list", "the scenes that come with the program");
  json->add(*list);
  list->callback([json] {
    nlohmann::ordered_json names = nlohmann::ordered_json::array();
    for (const std::string& name : scene::scene_names()) {
      const core::Scene scene = scene::load_scene(name);
      if (!json->to_stdout())
        fmt::print("{:26} {:6} {}\n", name, space_name(scene.space), scene.description);
      names.push_back({{"name", name}, {"description", scene.description}});
    }
    json->write(names);
  });
}

}  // namespace tandem::cli
