#pragma once

#include <stdexcept>

#include "core/axis_world.h"
#include "core/plane_world.h"
#include "core/scene.h"
#include "core/space_world.h"

namespace tandem::core {

/// Calls `work(World{})` with the world of the scene's space; all calls must return the same type.
template <typename Work>
decltype(auto) with_world(const Scene& scene, Work&& work) {
  switch (scene.space) {
    case Space::kAxis:
      return work(AxisWorld{});
    case Space::kPlane:
      return work(PlaneWorld{});
    case Space::kSpace:
      return work(SpaceWorld{});
  }
  throw std::invalid_argument("a scene of no known space");
}

}  // namespace tandem::core
