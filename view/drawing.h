#pragma once

#include <string>
#include <vector>

#include <glm/vec4.hpp>

#include "core/scene.h"
#include "view/camera.h"
#include "view/snapshot.h"

/// What is drawn of a session, without a word of OpenGL: shapes, lines and words in W.
namespace tandem::view {

using Colour = glm::vec4;  ///< red, green, blue, opacity; 0 .. 1, as on the screen (sRGB)

enum class Mesh { kBox, kSphere, kCylinder, kCone, kRing };

/// A unit mesh (box of edge 1, sphere of radius 1, cylinder, cone and ring of radius 1 around z,
/// from z = 0 to 1) with its place.
struct Item {
  Mesh mesh = Mesh::kBox;
  glm::dmat4 model{1.0};
  Colour colour{1.0f};
  bool casts_shadow = true;
  bool xray = false;  ///< seen through what is in front of it
};

struct Line {
  Vec3 a{0.0}, b{0.0};
  Colour colour{1.0f};
  float width = 1.5f;  ///< at 96 dots an inch [pixel]
  bool xray = false;
};

struct Label {
  Vec3 at{0.0};
  std::string text;
  Colour colour{1.0f};
};

struct Drawing {
  std::vector<Item> items;  ///< opaque ones, then ghosts
  std::vector<Line> lines;
  std::vector<Label> labels;
  double ground = 0.0;  ///< height of the ground [m]
  double grid = 0.01;   ///< spacing of its lines [m]
  Vec3 middle{0.0};     ///< of the scene, and
  double reach = 0.1;   ///< how far it goes around there [m]
};

/// Colour of a user (by index) or of the server.
[[nodiscard]] Colour colour_of_site(int site);
/// Colour of a delay [s]: green at none, amber at 75 ms, red from 150 ms on.
[[nodiscard]] Colour colour_of_delay(double delay);

/// How a scene is laid out: sizes that a scene does not have (thickness of a planar box, radius of
/// a point finger) and where everything will happen.
struct Layout {
  explicit Layout(const core::Scene& scene);

  /// Where a point of this user's hand, or of an object (user -1), is drawn.
  [[nodiscard]] Vec3 place(const Vec3& p, int user) const;
  [[nodiscard]] Vec3 object_size(int o) const;  ///< edges of its box as drawn [m]
  [[nodiscard]] double finger_radius(int user, int f) const;
  [[nodiscard]] Camera camera(double aspect) const;

  core::Scene scene;
  Vec3 low{0.0}, high{0.0};  ///< of what moves, as drawn [m]
  double unit = 0.05;        ///< a typical size [m]
  double ground = 0.0;
  double metres_per_newton = 0.005;
};

/// Where the finger is drawn: the haptic interface point, or in contact the proxy on the surface it
/// has sunk through.
struct DrawnFinger {
  Vec3 hip{0.0}, proxy{0.0};  ///< as drawn [m]
  Vec3 normal{0.0};           ///< out of the surface; 0: nothing is touched
};
[[nodiscard]] DrawnFinger drawn_finger(const Layout& layout, const Snapshot& seen, int user, int f);

struct DrawOptions {
  bool ghosts = true, forces = true, labels = true;
};

[[nodiscard]] Drawing draw(const Layout& layout, const Snapshot& seen, const DrawOptions& options);

}  // namespace tandem::view
