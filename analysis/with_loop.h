#pragma once

#include <utility>

#include "arch_central/central_loop.h"
#include "arch_distributed/distributed_loop.h"
#include "core/with_world.h"

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
  return core::with_world(scene, [&]<typename World>(World) -> decltype(auto) {
    return with_loop_of<World>(scene, network, use);
  });
}

}  // namespace tandem::analysis
