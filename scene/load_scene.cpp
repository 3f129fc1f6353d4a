#include "scene/load_scene.h"

#include <algorithm>
#include <map>
#include <vector>

#include "scene/apply_set.h"
#include "scene/message_visitors.h"
#include "scene/scene.pb.h"
#include "scene/validate_scene.h"

namespace tandem::scene {
namespace {

/// Refuses what is no text at all, before the parser talks about its bytes.
void demand_text(const std::string& text, const std::string& origin) {
  if (text.empty())
    throw SceneError({{{}, "is empty; a scene starts with: scene_version: 1", origin}});
  const auto control = std::find_if(text.begin(), text.end(), [](char c) {
    const auto byte = static_cast<unsigned char>(c);
    return byte < 0x20 && c != '\n' && c != '\r' && c != '\t';
  });
  if (control == text.end()) return;
  throw SceneError({{{},
                     "is not a text file (control character at byte " +
                         std::to_string(control - text.begin()) + ")",
                     origin}});
}

/// Another version may have other fields: nothing else is worth saying about it.
void demand_version(const wire::Scene& message, const std::string& where) {
  if (!message.has_scene_version() || message.scene_version() == kSceneVersion) return;
  throw SceneError({{"scene_version",
                     "scene_version = " + std::to_string(message.scene_version()) +
                         ": this program reads version " + std::to_string(kSceneVersion),
                     where}});
}

/// Where a problem comes from: an edit of that field, else the line of the field or of the nearest
/// part around it.
class Whereabouts {
 public:
  std::string origin;
  LineOfPath lines;
  std::map<std::string, std::string> edits;  ///< path to assignment

  void fill(std::vector<Problem>& problems) const {
    for (Problem& problem : problems)
      if (problem.where.empty()) problem.where = of(problem.path);
  }

  [[nodiscard]] std::string of(std::string path) const {
    // An edit of a part of it may have spoiled the whole.
    for (const auto& [edited, set] : edits)
      if (edited.starts_with(path + ".")) return origin + ", --set " + set;
    while (!path.empty()) {
      if (const auto edit = edits.find(path); edit != edits.end())
        return origin + ", --set " + edit->second;
      if (const auto line = lines.find(path); line != lines.end())
        return origin + ":" + std::to_string(line->second);
      const auto dot = path.rfind('.');
      path.resize(dot == std::string::npos ? 0 : dot);
    }
    return origin;
  }
};

void append(std::vector<Problem>& problems, const std::vector<Problem>& more) {
  problems.insert(problems.end(), more.begin(), more.end());
}

}  // namespace

core::Scene load_scene_text(const std::string& text, const std::string& origin,
                            std::span<const std::string> sets) {
  demand_text(text, origin);
  wire::Scene message;
  std::vector<Problem> problems;
  Whereabouts whereabouts{origin, {}, {}};
  const bool whole = parse_scene_text(text, origin, message, whereabouts.lines, problems);
  demand_version(message, whereabouts.of("scene_version"));
  if (!whole) throw SceneError(problems);

  for (const std::string& set : sets) {
    try {
      whereabouts.edits[apply_set(message, set)] = set;
    } catch (const SceneError& error) {
      append(problems, error.problems());
    }
  }
  demand_version(message, whereabouts.of("scene_version"));
  if (!message.has_scene_version())
    problems.push_back({"scene_version", "scene_version is missing: write scene_version: 1", {}});

  core::Scene scene;
  MessageReader reader(message, "", "this scene", problems);
  visit_scene(scene, reader);
  reader.finish();
  append(problems, validate_scene(scene));
  whereabouts.fill(problems);
  if (!problems.empty()) throw SceneError(problems);
  normalise(scene);
  return scene;
}

core::Scene load_scene(const std::string& name_or_file, std::span<const std::string> sets) {
  const std::string file = find_scene(name_or_file);
  return load_scene_text(read_scene_file(file), file, sets);
}

}  // namespace tandem::scene
