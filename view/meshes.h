#pragma once

#include <vector>

#include "view/drawing.h"

#include <glm/vec3.hpp>

namespace tandem::view {

struct Vertex {
  glm::vec3 position{0.0f};
  glm::vec3 normal{0.0f};
};

/// Triangles of a unit mesh, three vertices each.
[[nodiscard]] std::vector<Vertex> triangles_of(Mesh mesh);

}  // namespace tandem::view
