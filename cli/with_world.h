#pragma once

#include <stdexcept>

#include "core/axis_world.h"
#include "core/plane_world.h"
#include "core/scene.h"
#include "core/space_world.h"

namespace tandem::cli {

/// Calls `work(World{})` with the world of the scene's space.
template <typename Work>
auto with_world(const core::Scene& scene, Work&& work) {
  switch (scene.space) {
    case core::Space::kAxis:
      return work(core::AxisWorld{});
    case core::Space::kPlane:
      return work(core::PlaneWorld{});
    case core::Space::kSpace:
      return work(core::SpaceWorld{});
  }
  throw std::invalid_argument("a scene of no known space");
}

}  // namespace tandem::cli
