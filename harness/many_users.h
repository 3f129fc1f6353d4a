#pragma once

#include "core/scene.h"

namespace tandem::harness {

/// The axis scene with `users` of them, more made like the second: a hand, a copy, a coupler for
/// every pair that the second has with the first. The mass stays that of the whole object. Throws
/// SweepError where the scene has not two users on an axis.
[[nodiscard]] core::Scene with_users(const core::Scene& scene, int users);

}  // namespace tandem::harness
