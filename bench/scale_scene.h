#pragma once

#include "core/scene.h"

namespace tandem::bench {

struct ScaleSize {
  int users = 2;    ///< >= 2
  int objects = 1;  ///< >= 1
};

/// A shipped planar scene of two users and one box, grown: further boxes beside the first, 12 cm
/// apart; further users like the second one, each at a box of its own as long as there are boxes,
/// then together, spread over its height. Every hand can touch every box. A box carries the shipped
/// mass once for every user beyond the first, so that coupler over mass, hence stability, stays.
/// Two users and one object: the scene as it is. Throws std::invalid_argument for another scene.
[[nodiscard]] core::Scene grown_scene(const core::Scene& given, const ScaleSize& size);

}  // namespace tandem::bench
