#pragma once

#include "core/scene.h"

namespace tandem::analysis {

/// The planar scene as it is near a grasp: every finger attached at the point of the box's surface
/// nearest to its first target inside or at the box, couplers bilateral, no preload; no ground
/// friction, walls, hand springs, encoders, limits or fades. What is left is linear for small
/// motions, so its growth says whether the grasp is stable. Axis scenes are such already but for
/// what their devices do: encoders, friction and limits go, velocity filters stay. Throws
/// std::invalid_argument for spaces it does not know.
[[nodiscard]] core::Scene linearised_at_grasp(core::Scene scene);

}  // namespace tandem::analysis
