#include "analysis/knob.h"

#include <sstream>
#include <stdexcept>

namespace tandem::analysis {

namespace {

template <typename Entry>
int place_of(const std::vector<Entry>& entries, const std::string& name, const std::string& field) {
  std::string known;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    if (entries[i].name == name) return static_cast<int>(i);
    known += (known.empty() ? "" : ", ") + entries[i].name;
  }
  throw std::invalid_argument(field + ": no entry named " + name + "; there are: " + known);
}

}  // namespace

Knob::Knob(const core::Scene& scene, const std::string& fields) : name_(fields) {
  std::stringstream list(fields);
  for (std::string field; std::getline(list, field, ',');) {
    const std::size_t first = field.find('.'), last = field.rfind('.');
    if (first == std::string::npos || last == first)
      throw std::invalid_argument(field + ": a field to vary is KIND.NAME.NUMBER, for example " +
                                  "coupler.k11.stiffness");
    const std::string kind = field.substr(0, first), what = field.substr(last + 1),
                      name = field.substr(first + 1, last - first - 1);
    const auto unknown = [&](const char* numbers) {
      throw std::invalid_argument(field + ": " + kind + " has no number " + what + "; it has " +
                                  numbers);
    };
    if (kind == "coupler" || kind == "wall") {
      if (what != "stiffness" && what != "damping") unknown("stiffness, damping");
      const bool stiffness = what == "stiffness", wall = kind == "wall";
      const int i =
          wall ? place_of(scene.walls, name, field) : place_of(scene.couplers, name, field);
      places_.push_back([=](core::Scene& s) {
        core::Gain& g = wall ? s.walls[i].gain : s.couplers[i].gain;
        return stiffness ? &g.stiffness : &g.damping;
      });
    } else if (kind == "object") {
      if (what != "mass" && what != "compensation") unknown("mass, compensation");
      const int i = place_of(scene.objects, name, field);
      const bool mass = what == "mass";
      places_.push_back(
          [=](core::Scene& s) { return mass ? &s.objects[i].mass : &s.objects[i].compensation; });
    } else if (kind == "user") {
      if (what != "mass") unknown("mass");
      const int i = place_of(scene.users, name, field);
      places_.push_back([=](core::Scene& s) { return &s.users[i].mass; });
    } else {
      throw std::invalid_argument(field + ": " + kind + " is not coupler, object, user or wall");
    }
  }
  if (places_.empty()) throw std::invalid_argument("no field to vary");
}

}  // namespace tandem::analysis
