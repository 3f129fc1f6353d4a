#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/scene.h"

namespace tandem::analysis {

/// Sets one or several numbers of a scene alike: "coupler.k12.stiffness,coupler.k21.stiffness".
/// Fields: coupler.NAME.stiffness|damping, object.NAME.mass|compensation, user.NAME.mass,
/// wall.NAME.stiffness|damping.
class Knob {
 public:
  /// Throws std::invalid_argument naming the field and what there is.
  Knob(const core::Scene& scene, const std::string& fields);
  void set(core::Scene& scene, double value) const {
    for (const Place& place : places_) *place(scene) = value;
  }
  [[nodiscard]] double value(core::Scene& scene) const { return *places_.front()(scene); }
  [[nodiscard]] const std::string& name() const { return name_; }

 private:
  using Place = std::function<double*(core::Scene&)>;
  std::string name_;
  std::vector<Place> places_;
};

}  // namespace tandem::analysis
