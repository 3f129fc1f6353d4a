#pragma once

#include <stdexcept>
#include <utility>

#include "arch_central/central_loop.h"
#include "arch_distributed/distributed_loop.h"
#include "core/axis_world.h"
#include "core/plane_world.h"
#include "core/space_world.h"

namespace tandem::analysis {

[[nodiscard]] inline bool is_central(const core::Scene& scene) {
  return scene.architecture == core::Architecture::kCentral ||
         scene.architecture == core::Architecture::kSingle;
}

/// Builds the loop of the scene's architecture over one world and calls `use(loop)` with it.
template <typename World, typename Use>
decltype(auto) with_loop_of(const core::Scene& scene, const core::NetworkModel& network,
                            Use&& use) {
  if (is_central(scene)) {
    central::CentralLoop<World> loop(scene, network);
    return std::forward<Use>(use)(loop);
  }
  distributed::DistributedLoop<World> loop(scene, network);
  return std::forward<Use>(use)(loop);
}

/// Builds the loop that the scene declares, whatever its space, and calls `use(loop)` with it. All
/// calls must return the same type.
template <typename Use>
decltype(auto) with_loop(const core::Scene& scene, const core::NetworkModel& network, Use&& use) {
  switch (scene.space) {
    case core::Space::kAxis:
      return with_loop_of<core::AxisWorld>(scene, network, use);
    case core::Space::kPlane:
      return with_loop_of<core::PlaneWorld>(scene, network, use);
    case core::Space::kSpace:
      return with_loop_of<core::SpaceWorld>(scene, network, use);
  }
  throw std::invalid_argument("a scene of no known space");
}

}  // namespace tandem::analysis
