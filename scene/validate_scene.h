#pragma once

#include <vector>

#include "core/scene.h"
#include "scene/scene_error.h"

namespace tandem::scene {

/// The version of scene files this program reads.
inline constexpr int kSceneVersion = 1;

/// Everything wrong with a scene, in the order of its fields; empty: the laws may run it. Checks
/// range and finiteness of every number, names, cross-references, that the architecture has the
/// couplers it needs, and the initial geometry.
[[nodiscard]] std::vector<Problem> validate_scene(const core::Scene& scene);

/// The part of it that is geometry: sizes, shapes, who starts inside what.
void validate_geometry(const core::Scene& scene, std::vector<Problem>& problems);

/// Gives wall normals and orientations unit length; those within 1e-12 of it keep their bits, so
/// that a scene sent as text stays the same. Precondition: validated.
void normalise(core::Scene& scene);

}  // namespace tandem::scene
