#pragma once

#include <map>
#include <string>
#include <vector>

#include "analysis/experiments.h"
#include "analysis/response.h"
#include "core/network_model.h"
#include "core/scene.h"

/// The language of the files of expected values: how one line says which scene it is about.
namespace tandem::analysis::reference {

[[nodiscard]] std::vector<std::string> split(const std::string& text, char by);
/// A number that fills the whole text; throws std::invalid_argument.
[[nodiscard]] double to_number(const std::string& text);

/// "k11,k22:k" as the scene's fields "coupler.k11.stiffness,coupler.k22.stiffness"; others
/// unchanged.
[[nodiscard]] std::string long_field(const std::string& field);

struct Case {
  core::Scene scene;
  core::NetworkModel network;
};

/// Named sets of edits ("@T6.1") and the scenes they are applied to.
class Cases {
 public:
  explicit Cases(const SceneSource& scenes) : scenes_(scenes) {}
  void name_set(const std::string& name, const std::string& edits) { sets_[name] = edits; }
  /// Scene axis_`name` with `edits`: FIELD=VALUE, @SET, wall=k:b (holds the object), links=a:b
  /// (ticks from user 1 to 2 and back instead of `packets` of round trip), analysis=MODEL.
  [[nodiscard]] Case build(const std::string& name, double packets, const std::string& edits) const;

 private:
  const SceneSource& scenes_;
  std::map<std::string, std::string> sets_;
};

/// Who pushes and who is there: "free" (all as it is), "alone" (first hand only), "remote" (the
/// hand across the network only), "both" and "one" (no hands, force on both copies or on one).
void apply_model(core::Scene& scene, const std::string& model);

/// The map of a model, and the port its force goes in at. Resampled, or measured on the loop where
/// that does not apply.
struct Pushed {
  LiftedSystem system;
  ForcePort port;
};
[[nodiscard]] Pushed pushed(Case c, const std::string& model);

}  // namespace tandem::analysis::reference
