#pragma once

#include <algorithm>
#include <initializer_list>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "core/scene.h"
#include "scene/load_scene.h"

namespace tandem::hard {

/// plane_single, held: fingers close, squeeze, and stay; no encoder, so that rest is rest.
inline core::Scene held_grasp() {
  core::Scene scene = scene::load_scene("plane_single", std::vector<std::string>{});
  for (auto& device : scene.devices) device.encoder_step = device.velocity_cutoff_hz = 0.0;
  for (auto& finger : scene.users[0].fingers) {
    finger.intent.path.resize(3);
    finger.intent.path_sines.clear();
  }
  return scene;
}

/// The stiffness along the normal of some of the scene's couplers [N/m].
inline void set_stiffness(core::Scene& scene, std::initializer_list<std::string_view> names,
                          double stiffness) {
  std::size_t set = 0;
  for (auto& coupler : scene.couplers)
    if (std::find(names.begin(), names.end(), coupler.name) != names.end()) {
      coupler.gain.stiffness = stiffness;
      ++set;
    }
  if (set != names.size()) throw std::invalid_argument("no such coupler");
}

// Largest stable stiffnesses [N/m]. Numbers, because sanitizer builds have no analysis: where there
// is one, grasp_limit_test.cpp finds them again.
inline constexpr double kGraspLimit = 6144.0305800940368;  ///< of the coupler of held_grasp()
inline constexpr double kCoordinationLimit =
    619.1205119638455;  ///< of box_distributed, round trip of one packet

}  // namespace tandem::hard
