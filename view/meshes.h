#pragma once

#include <vector>

#include <glm/vec3.hpp>

#include "view/drawing.h"

namespace tandem::view {

struct Vertex {
  glm::vec3 position{0.0f};
  glm::vec3 normal{0.0f};
};

/// Triangles of a unit mesh, three vertices each.
[[nodiscard]] std::vector<Vertex> triangles_of(Mesh mesh);

}  // namespace tandem::view
