#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/scene.h"

namespace tandem::analysis {

/// Sets one or several numbers of a scene alike: "coupler.k12.stiffness,coupler.k21.stiffness".
/// Fields: coupler.NAME.stiffness|damping and, in a plane, their normal., tangential. and rotation.
/// kinds (normal. and linear. are the first), object.NAME.mass|inertia|compensation|
/// compensation_rotation, user.NAME.mass, wall.NAME.stiffness|damping. coupler.*.stiffness|damping
/// is a factor on all of them, in every direction.
class Knob {
 public:
  /// Throws std::invalid_argument naming the field and what there is.
  Knob(const core::Scene& scene, const std::string& fields);
  void set(core::Scene& scene, double value) const {
    for (const Place& place : places_) *place.at(scene) = value * place.unit;
  }
  [[nodiscard]] double value(core::Scene& scene) const {
    return *places_.front().at(scene) / places_.front().unit;
  }
  [[nodiscard]] const std::string& name() const { return name_; }

 private:
  struct Place {
    std::function<double*(core::Scene&)> at;
    double unit = 1.0;
  };
  void add_coupler(const core::Scene& scene, const std::string& field, const std::string& name,
                   const std::string& what);
  std::string name_;
  std::vector<Place> places_;
};

}  // namespace tandem::analysis
