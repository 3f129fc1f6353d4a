#pragma once

#include <span>
#include <string>

#include "core/scene.h"
#include "scene/find_scene.h"
#include "scene/scene_error.h"
#include "scene/scene_text.h"
#include "scene/shared_hash.h"

namespace tandem::scene {

/// Reads a scene by name (axis_distributed) or file, applies edits ("coupler.k11.stiffness=800",
/// see scene/apply_set.h) in order, validates. Throws SceneError with every problem found: file and
/// line, field, value, what is allowed. What comes back is complete and consistent; wall normals
/// and orientations have unit length.
[[nodiscard]] core::Scene load_scene(const std::string& name_or_file,
                                     std::span<const std::string> sets = {});

/// The same from text; `origin` stands for the file in messages.
[[nodiscard]] core::Scene load_scene_text(const std::string& text, const std::string& origin,
                                          std::span<const std::string> sets = {});

}  // namespace tandem::scene
