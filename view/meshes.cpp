#include "view/meshes.h"

#include <cmath>

#include <glm/geometric.hpp>

namespace tandem::view {
namespace {

constexpr float kTurn = 6.28318530717958647692f;

void add_quad(std::vector<Vertex>& out, const Vertex& a, const Vertex& b, const Vertex& c,
              const Vertex& d) {
  for (const Vertex* v : {&a, &b, &c, &a, &c, &d}) out.push_back(*v);
}

std::vector<Vertex> box() {
  std::vector<Vertex> out;
  for (int axis = 0; axis < 3; ++axis)
    for (const float sign : {-1.0f, 1.0f}) {
      glm::vec3 n{0.0f}, u{0.0f}, v{0.0f};
      n[axis] = sign;
      u[(axis + 1) % 3] = 0.5f;
      v[(axis + 2) % 3] = 0.5f * sign;
      const glm::vec3 c = n * 0.5f;
      add_quad(out, {c - u - v, n}, {c + u - v, n}, {c + u + v, n}, {c - u + v, n});
    }
  return out;
}

/// A surface of two angles, in pieces.
template <typename At>
std::vector<Vertex> surface(int around, int along, At&& at) {
  std::vector<Vertex> out;
  for (int i = 0; i < around; ++i)
    for (int j = 0; j < along; ++j) {
      const auto point = [&](int a, int b) {
        return at(static_cast<float>(a) / static_cast<float>(around),
                  static_cast<float>(b) / static_cast<float>(along));
      };
      add_quad(out, point(i, j), point(i + 1, j), point(i + 1, j + 1), point(i, j + 1));
    }
  return out;
}

std::vector<Vertex> sphere() {
  return surface(28, 16, [](float u, float v) {
    const float a = kTurn * u, b = 0.5f * kTurn * (v - 0.5f);
    const glm::vec3 p{std::cos(a) * std::cos(b), std::sin(a) * std::cos(b), std::sin(b)};
    return Vertex{p, p};
  });
}

/// From radius 1 at z = 0 to `top` at z = 1, with a floor.
std::vector<Vertex> cone(float top) {
  const float rise = 1.0f - top;
  auto out = surface(20, 1, [&](float u, float v) {
    const float a = kTurn * u, r = 1.0f - rise * v;
    return Vertex{{r * std::cos(a), r * std::sin(a), v},
                  glm::normalize(glm::vec3{std::cos(a), std::sin(a), rise})};
  });
  for (const float z : {0.0f, 1.0f}) {
    const float r = z > 0.5f ? top : 1.0f;
    if (r <= 0.0f) continue;
    const auto cap = surface(20, 1, [&](float u, float v) {
      const float a = kTurn * u;
      return Vertex{{r * v * std::cos(a), r * v * std::sin(a), z}, {0, 0, z > 0.5f ? 1.0f : -1.0f}};
    });
    out.insert(out.end(), cap.begin(), cap.end());
  }
  return out;
}

std::vector<Vertex> ring() {
  constexpr float kThick = 0.085f;
  return surface(32, 8, [](float u, float v) {
    const float a = kTurn * u, b = kTurn * v;
    const glm::vec3 out{std::cos(a), std::sin(a), 0.0f};
    const glm::vec3 n = out * std::cos(b) + glm::vec3{0, 0, std::sin(b)};
    return Vertex{out * (1.0f - kThick) + n * kThick, n};
  });
}

}  // namespace

std::vector<Vertex> triangles_of(Mesh mesh) {
  switch (mesh) {
    case Mesh::kBox:
      return box();
    case Mesh::kSphere:
      return sphere();
    case Mesh::kCylinder:
      return cone(1.0f);
    case Mesh::kCone:
      return cone(0.0f);
    case Mesh::kRing:
      return ring();
  }
  return {};
}

}  // namespace tandem::view
