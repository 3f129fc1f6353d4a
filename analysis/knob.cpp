#include "analysis/knob.h"

#include <algorithm>
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
  throw std::invalid_argument(field + ": no entry named " + name +
                              "; there are: " + (known.empty() ? "none" : known));
}

using GainOf = core::Gain core::CouplerParameters::*;

}  // namespace

void Knob::add_coupler(const core::Scene& scene, const std::string& field, const std::string& name,
                       const std::string& what) {
  const bool plane = scene.space == core::Space::kPlane;
  const std::size_t dot = what.find('.');
  const std::string number = dot == std::string::npos ? what : what.substr(dot + 1);
  std::string kind = dot == std::string::npos ? "" : what.substr(0, dot);
  if (plane && kind == "linear") kind = "normal";
  const bool stiffness = number == "stiffness";
  if ((!stiffness && number != "damping") ||
      (!kind.empty() &&
       !(plane && (kind == "normal" || kind == "tangential" || kind == "rotation"))))
    throw std::invalid_argument(field + ": coupler has no number " + what + "; it has stiffness, " +
                                "damping" +
                                (plane ? ", each also as normal., tangential., linear. and "
                                         "rotation. (tangential.stiffness)"
                                       : ""));
  const auto place = [&](int i, GainOf gain, double unit) {
    places_.push_back({[=](core::Scene& s) {
                         core::Gain& g = s.couplers[i].*gain;
                         return stiffness ? &g.stiffness : &g.damping;
                       },
                       unit});
  };
  if (name != "*") {
    place(place_of(scene.couplers, name, field),
          kind == "tangential" ? &core::CouplerParameters::tangential
          : kind == "rotation" ? &core::CouplerParameters::rotation
                               : &core::CouplerParameters::gain,
          1.0);
    return;
  }
  const std::size_t before = places_.size();
  for (std::size_t i = 0; i < scene.couplers.size(); ++i)
    for (const auto& [gain, called] :
         {std::pair<GainOf, const char*>{&core::CouplerParameters::gain, "normal"},
          {&core::CouplerParameters::tangential, "tangential"},
          {&core::CouplerParameters::rotation, "rotation"}}) {
      const core::Gain& g = scene.couplers[i].*gain;
      const double now = stiffness ? g.stiffness : g.damping;
      if (now > 0.0 && (kind.empty() || kind == called)) place(static_cast<int>(i), gain, now);
    }
  if (places_.size() == before)
    throw std::invalid_argument(field + ": every coupler has 0 there, a factor changes nothing");
}

Knob::Knob(const core::Scene& scene, const std::string& fields) : name_(fields) {
  std::stringstream list(fields);
  for (std::string field; std::getline(list, field, ',');) {
    const std::size_t first = field.find('.'),
                      last = first == std::string::npos ? first : field.find('.', first + 1);
    if (last == std::string::npos)
      throw std::invalid_argument(field + ": a field to vary is KIND.NAME.NUMBER, for example " +
                                  "coupler.k11.stiffness");
    const std::string kind = field.substr(0, first), what = field.substr(last + 1),
                      name = field.substr(first + 1, last - first - 1);
    const auto unknown = [&](const char* numbers) {
      throw std::invalid_argument(field + ": " + kind + " has no number " + what + "; it has " +
                                  numbers);
    };
    const auto place = [&](auto at) { places_.push_back({at, 1.0}); };
    if (kind == "coupler") {
      add_coupler(scene, field, name, what);
    } else if (kind == "wall") {
      if (what != "stiffness" && what != "damping") unknown("stiffness, damping");
      const bool stiffness = what == "stiffness";
      const int i = place_of(scene.walls, name, field);
      place([=](core::Scene& s) {
        core::Gain& g = s.walls[i].gain;
        return stiffness ? &g.stiffness : &g.damping;
      });
    } else if (kind == "object") {
      const int i = place_of(scene.objects, name, field);
      const bool plane = scene.space == core::Space::kPlane;
      if (what == "mass")
        place([=](core::Scene& s) { return &s.objects[i].mass; });
      else if (what == "compensation")
        place([=](core::Scene& s) { return &s.objects[i].compensation; });
      else if (plane && what == "compensation_rotation")
        place([=](core::Scene& s) { return &s.objects[i].compensation_rotation; });
      else if (plane && what == "inertia")
        place([=](core::Scene& s) { return &s.objects[i].inertia.z; });
      else
        unknown(plane ? "mass, inertia, compensation, compensation_rotation"
                      : "mass, compensation");
    } else if (kind == "user") {
      if (what != "mass") unknown("mass");
      const int i = place_of(scene.users, name, field);
      place([=](core::Scene& s) { return &s.users[i].mass; });
    } else {
      throw std::invalid_argument(field + ": " + kind + " is not coupler, object, user or wall");
    }
  }
  if (places_.empty()) throw std::invalid_argument("no field to vary");
}

}  // namespace tandem::analysis
