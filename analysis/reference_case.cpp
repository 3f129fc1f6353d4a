#include "analysis/reference_case.h"

#include <sstream>
#include <stdexcept>

#include "analysis/drag.h"
#include "analysis/resampled.h"

namespace tandem::analysis::reference {

std::vector<std::string> split(const std::string& text, char by) {
  std::vector<std::string> out;
  std::stringstream stream(text);
  for (std::string part; std::getline(stream, part, by);) out.push_back(part);
  return out;
}

double to_number(const std::string& text) {
  std::size_t read = 0;
  double value = 0.0;
  try {
    value = std::stod(text, &read);
  } catch (const std::logic_error&) {
    read = 0;
  }
  if (read == 0 || read != text.size())
    throw std::invalid_argument("'" + text + "' is not a number");
  return value;
}

std::string long_field(const std::string& field) {
  const std::size_t colon = field.find(':');
  if (colon == std::string::npos) return field;
  const char* number = field.substr(colon + 1) == "k" ? ".stiffness" : ".damping";
  std::string out;
  for (const std::string& name : split(field.substr(0, colon), ','))
    out += (out.empty() ? "coupler." : ",coupler.") + name + number;
  return out;
}

namespace {

/// Two numbers with a colon between them.
std::pair<double, double> pair_of(const std::string& text) {
  const auto parts = split(text, ':');
  if (parts.size() != 2) throw std::invalid_argument("'" + text + "' is not A:B");
  return {to_number(parts[0]), to_number(parts[1])};
}

struct Edits {
  std::vector<std::string> fields;  ///< for the scene's loader
  std::string wall, links, model;
};

void add(const std::string& word, Edits& edits) {
  const std::size_t equal = word.find('=');
  if (equal == std::string::npos) throw std::invalid_argument("'" + word + "' is not FIELD=VALUE");
  const std::string name = word.substr(0, equal), value = word.substr(equal + 1);
  if (name == "wall") {
    edits.wall = value;
  } else if (name == "links") {
    edits.links = value;
  } else if (name == "analysis") {
    edits.model = value;
  } else {
    for (const std::string& field : split(long_field(name), ','))
      edits.fields.push_back(field + "=" + value);
  }
}

}  // namespace

Case Cases::build(const std::string& name, double packets, const std::string& edits) const {
  Edits all;
  for (const std::string& word : split(edits, ' ')) {
    if (word.empty()) continue;
    if (word.front() != '@') {
      add(word, all);
      continue;
    }
    const auto set = sets_.find(word);
    if (set == sets_.end()) throw std::invalid_argument("no set " + word);
    for (const std::string& w : split(set->second, ' ')) add(w, all);
  }
  Case out{scenes_("axis_" + name, all.fields), {}};
  if (!all.model.empty()) apply_model(out.scene, all.model);
  if (!all.wall.empty()) {
    core::WallParameters w;
    w.name = "wall";
    w.normal = core::Vec3(-1.0, 0.0, 0.0);
    const auto [stiffness, damping] = pair_of(all.wall);
    w.gain = {stiffness, damping};
    w.attached = true;
    out.scene.walls.push_back(w);
  }
  out.network.set_round_trip(packets, out.scene.ticks_per_packet());
  if (!all.links.empty()) {
    const auto [there, back] = pair_of(all.links);
    out.network.link[0][1].delay_ticks = there;
    out.network.link[1][0].delay_ticks = back;
  }
  return out;
}

void apply_model(core::Scene& scene, const std::string& model) {
  if (model == "alone") {
    scene = with_one_hand(scene, scene.users[0].name);
  } else if (model == "remote") {
    scene = with_one_hand(scene, scene.users[drag_user(scene)].name);
  } else if (model == "both" || model == "one") {
    std::erase_if(scene.couplers, [](const auto& c) { return !c.user.empty(); });
  } else if (model != "free" && model != "own timer") {  // the timer is the network's
    throw std::invalid_argument("no model " + model);
  }
}

Pushed pushed(Case c, const std::string& model) {
  apply_model(c.scene, model);
  Pushed out{why_not_resampled(c.scene, c.network).empty() ? resampled_system(c.scene, c.network)
                                                           : measured_system(c.scene, c.network),
             {}};
  if (model == "remote")
    out.port = out.system.ports.at(static_cast<std::size_t>(drag_user(c.scene)));
  else if (model == "one")
    out.port = port_named(out.system, "box@1");
  else if (model == "both")
    out.port = joined(port_named(out.system, "box@1"), port_named(out.system, "box@2"));
  else
    out.port = out.system.ports.at(0);
  return out;
}

}  // namespace tandem::analysis::reference
