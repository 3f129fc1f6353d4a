#include "view/drawing.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/quaternion.hpp>

namespace tandem::view {
namespace {

const Colour kBoxColour{0.93f, 0.78f, 0.47f, 1.0f};
const Colour kBoxEdge{0.42f, 0.29f, 0.10f, 1.0f};
const Colour kWallColour{0.50f, 0.55f, 0.62f, 1.0f};
const Colour kForceColour{0.84f, 0.10f, 0.28f, 1.0f};
const Colour kRail{0.62f, 0.66f, 0.71f, 1.0f};

[[nodiscard]] glm::dmat4 placed(const Vec3& p, const Quat& q, const Vec3& size) {
  return glm::translate(glm::dmat4(1.0), p) * glm::mat4_cast(q) * glm::scale(glm::dmat4(1.0), size);
}

/// Turns z to the direction.
[[nodiscard]] Quat turned_to(const Vec3& direction) {
  const Vec3 d = glm::normalize(direction);
  const double c = d.z;
  if (c < -0.999999) return Quat(0.0, 1.0, 0.0, 0.0);
  const Vec3 axis = glm::cross(Vec3{0, 0, 1}, d);
  return glm::normalize(Quat(1.0 + c, axis.x, axis.y, axis.z));
}

[[nodiscard]] Colour with_opacity(Colour c, float a) {
  c.w = a;
  return c;
}

void add_edges(Drawing& out, const Vec3& p, const Quat& q, const Vec3& size, const Colour& colour,
               float width) {
  const auto corner = [&](int i) {
    return p + q * (Vec3{(i & 1) ? 0.5 : -0.5, (i & 2) ? 0.5 : -0.5, (i & 4) ? 0.5 : -0.5} * size);
  };
  for (int i = 0; i < 8; ++i)
    for (const int bit : {1, 2, 4})
      if ((i & bit) == 0)
        out.lines.push_back(
            {.a = corner(i), .b = corner(i | bit), .colour = colour, .width = width});
}

void add_arrow(Drawing& out, const Vec3& from, const Vec3& way, double thickness,
               const Colour& colour) {
  const double length = glm::length(way);
  if (length < 0.5 * thickness) return;
  const Quat q = turned_to(way);
  const double head = std::min(0.45 * length, 4.0 * thickness);
  const double wide = std::min(2.2 * thickness, 0.6 * head);
  const double shaft = length - head;
  out.items.push_back({.mesh = Mesh::kCylinder,
                       .model = placed(from, q, {0.45 * wide, 0.45 * wide, shaft}),
                       .colour = colour});
  out.items.push_back({.mesh = Mesh::kCone,
                       .model = placed(from + way * (shaft / length), q, {wide, wide, head}),
                       .colour = colour});
}

void add_object(Drawing& out, const Layout& l, int o, const Body& body, const Colour& colour,
                const Colour& edge, bool ghost) {
  const core::ObjectParameters& object = l.scene.objects[static_cast<std::size_t>(o)];
  const Vec3 size = l.object_size(o) * (ghost ? 1.004 : 1.0);
  const Vec3 p = l.place(body.p, -1);
  if (object.shape == core::Shape::kSphere) {
    out.items.push_back({.mesh = Mesh::kSphere,
                         .model = placed(p, body.q, 0.5 * size),
                         .colour = colour,
                         .casts_shadow = !ghost});
    // Two great circles: a ball that turns must be seen to turn.
    for (int ring = 0; ring < 2; ++ring) {
      const Quat turn = ring == 0 ? body.q : body.q * Quat(0.70710678, 0.70710678, 0, 0);
      constexpr int kPieces = 48;
      for (int i = 0; i < kPieces; ++i) {
        const auto at = [&](int k) {
          const double a = 2.0 * std::numbers::pi * k / kPieces;
          return p + turn * Vec3{0.502 * size.x * std::cos(a), 0.502 * size.x * std::sin(a), 0.0};
        };
        out.lines.push_back({.a = at(i), .b = at(i + 1), .colour = edge, .width = 1.5f});
      }
    }
    return;
  }
  out.items.push_back({.mesh = Mesh::kBox,
                       .model = placed(p, body.q, size),
                       .colour = colour,
                       .casts_shadow = !ghost});
  add_edges(out, p, body.q, size, edge, ghost ? 1.8f : 1.3f);
}

void add_walls(Drawing& out, const Layout& l) {
  const Vec3 middle = 0.5 * (l.low + l.high);
  const double reach = 0.75 * std::max(l.high.x - l.low.x, l.high.y - l.low.y);
  const double thick = 0.12 * l.unit;
  for (const core::WallParameters& w : l.scene.walls) {
    const Vec3 n = glm::normalize(w.normal);
    if (l.scene.space == core::Space::kSpace && n.z > 0.9) continue;  // it is the ground
    const double height = l.scene.space == core::Space::kSpace ? 2.0 * reach : 0.62 * l.unit;
    Vec3 foot = middle - n * glm::dot(middle - w.point, n);
    foot.z = l.scene.space == core::Space::kSpace ? foot.z : 0.5 * height;
    // Box with x along the normal, its front face in the wall's surface.
    const double angle = std::atan2(n.y, n.x);
    const bool upright = std::abs(n.z) < 0.1;
    const Quat q = upright ? Quat(std::cos(0.5 * angle), 0, 0, std::sin(0.5 * angle))
                           : turned_to(n) * Quat(0.70710678, 0, 0.70710678, 0);
    const Vec3 size{thick, 2.0 * reach, height};
    const Vec3 centre = foot - n * (0.5 * thick);
    out.items.push_back(
        {.mesh = Mesh::kBox, .model = placed(centre, q, size), .colour = kWallColour});
    add_edges(out, centre, q, size, {0.25f, 0.29f, 0.35f, 1.0f}, 1.2f);
  }
}

/// The user's hand above its fingers: a bow from finger to finger, or a stem.
Vec3 add_hand(Drawing& out, const Layout& l, const std::vector<Vec3>& fingers,
              const Colour& colour) {
  Vec3 middle{0.0};
  for (const Vec3& p : fingers) middle += p / static_cast<double>(fingers.size());
  Vec3 apex = middle + Vec3{0, 0, 0.75 * l.unit};
  constexpr int kPieces = 14;
  for (const Vec3& p : fingers) {
    // Quadratic curve that leaves the finger upwards and ends at the apex.
    const Vec3 knee = p * 0.8 + middle * 0.2 + Vec3{0, 0, 0.75 * l.unit};
    Vec3 before = p;
    for (int i = 1; i <= kPieces; ++i) {
      const double t = static_cast<double>(i) / kPieces;
      const Vec3 now = p * ((1 - t) * (1 - t)) + knee * (2 * t * (1 - t)) + apex * (t * t);
      out.lines.push_back({.a = before, .b = now, .colour = colour, .width = 3.0f});
      before = now;
    }
  }
  return apex;
}

void add_finger(Drawing& out, const Layout& l, const Site& site, int user, int f,
                const DrawnFinger& at, bool own, const DrawOptions& options) {
  const Colour colour = colour_of_site(user);
  const double r = l.finger_radius(user, f);
  const Finger& finger = site.fingers[static_cast<std::size_t>(f)];
  out.items.push_back({.mesh = Mesh::kSphere,
                       .model = placed(at.proxy, Quat(1, 0, 0, 0), Vec3{r}),
                       .colour = colour});
  const bool touches = glm::length(at.normal) > 0.0;
  if (touches) {
    // How far the hand has sunk in behind the drawn finger.
    out.items.push_back({.mesh = Mesh::kSphere,
                         .model = placed(at.hip, Quat(1, 0, 0, 0), Vec3{0.35 * r}),
                         .colour = with_opacity(colour, 0.85f),
                         .casts_shadow = false,
                         .xray = true});
    out.lines.push_back({.a = at.proxy,
                         .b = at.hip,
                         .colour = with_opacity(colour, 0.8f),
                         .width = 1.6f,
                         .xray = true});
    // Contact: a ring on the surface; green holds, amber slides, white is being braked.
    const Colour ring = finger.contact == core::ContactState::kSlide
                            ? Colour{0.97f, 0.65f, 0.10f, 1}
                        : finger.contact == core::ContactState::kMomentCancellation
                            ? Colour{1, 1, 1, 1}
                            : Colour{0.20f, 0.65f, 0.33f, 1};
    out.items.push_back({.mesh = Mesh::kRing,
                         .model = placed(at.proxy - at.normal * (0.85 * r), turned_to(at.normal),
                                         {1.35 * r, 1.35 * r, 1.35 * r}),
                         .colour = ring,
                         .casts_shadow = false});
  }
  if (!own && site.age > 0.0) {
    // Thesis ref 102: the delay is seen at the hand it belongs to.
    const double wide = r * (1.7 + 1.8 * std::min(1.0, site.age / 0.150));
    out.items.push_back(
        {.mesh = Mesh::kRing,
         .model = placed(at.proxy + Vec3{0, 0, 0.2 * r}, Quat(1, 0, 0, 0), {wide, wide, wide}),
         .colour = colour_of_delay(site.age),
         .casts_shadow = false});
  }
  if (options.forces && site.forces_known) {
    const Vec3 way = finger.force * l.metres_per_newton;
    if (glm::length(way) > 0.02 * l.unit) {
      const Vec3 start = at.proxy + glm::normalize(way) * (0.6 * r);
      add_arrow(out, start, way, 0.035 * l.unit, kForceColour);
    }
  }
}

void add_user(Drawing& out, const Layout& l, const Snapshot& seen, int user,
              const DrawOptions& options) {
  const Site& site = seen.sites[static_cast<std::size_t>(user)];
  const core::UserParameters& parameters = l.scene.users[static_cast<std::size_t>(user)];
  const bool own = user == seen.own || site.age <= 0.0;
  std::vector<Vec3> drawn;
  for (std::size_t f = 0; f < parameters.fingers.size(); ++f) {
    const DrawnFinger at = drawn_finger(l, seen, user, static_cast<int>(f));
    add_finger(out, l, site, user, static_cast<int>(f), at, own, options);
    drawn.push_back(at.proxy);
  }
  if (drawn.empty()) return;
  const Colour colour = colour_of_site(user);
  const Vec3 apex = add_hand(out, l, drawn, colour);
  if (l.scene.space == core::Space::kAxis && !l.scene.objects.empty()) {
    // The coupler, which on an axis always holds.
    const Site& copy = site.has_objects ? site : seen.sites[static_cast<std::size_t>(seen.own)];
    out.lines.push_back({.a = drawn.front(),
                         .b = l.place(copy.objects[0].p, -1),
                         .colour = with_opacity(colour, 0.7f),
                         .width = 2.0f});
  }
  if (!options.labels) return;
  std::string text = "user " + parameters.name;
  if (!own) text += fmt::format("  {:.0f} ms", 1e3 * site.age);
  if (site.gain < 0.995) text += fmt::format("  force {:.0f} %", 100.0 * site.gain);
  out.labels.push_back({apex + Vec3{0, 0, 0.12 * l.unit}, text, colour});
}

}  // namespace

Colour colour_of_site(int site) {
  // Told apart by people who see fewer colours, too (after Okabe and Ito).
  static constexpr std::array<std::array<float, 3>, 8> kUsers{{{0.00f, 0.40f, 0.74f},
                                                               {0.88f, 0.36f, 0.05f},
                                                               {0.00f, 0.60f, 0.45f},
                                                               {0.62f, 0.30f, 0.68f},
                                                               {0.34f, 0.68f, 0.92f},
                                                               {0.78f, 0.20f, 0.36f},
                                                               {0.55f, 0.55f, 0.10f},
                                                               {0.35f, 0.35f, 0.40f}}};
  if (site < 0 || site >= kServerSite) return {0.25f, 0.27f, 0.32f, 1.0f};
  const auto& c = kUsers[static_cast<std::size_t>(site)];
  return {c[0], c[1], c[2], 1.0f};
}

Colour colour_of_delay(double delay) {
  const auto x = static_cast<float>(std::clamp(delay / 0.150, 0.0, 1.0));
  const Colour green{0.18f, 0.68f, 0.34f, 1}, amber{0.96f, 0.70f, 0.12f, 1},
      red{0.86f, 0.12f, 0.14f, 1};
  return x < 0.5f ? green + (amber - green) * (2.0f * x)
                  : amber + (red - amber) * (2.0f * x - 1.0f);
}

Drawing draw(const Layout& l, const Snapshot& seen, const DrawOptions& options) {
  Drawing out;
  out.ground = l.ground;
  out.grid = l.unit > 0.04 ? 0.02 : l.unit > 0.015 ? 0.01 : 0.002;
  out.middle = 0.5 * (l.low + l.high);
  out.reach = 0.5 * glm::length(l.high - l.low);
  add_walls(out, l);
  if (l.scene.space == core::Space::kAxis)
    out.items.push_back({.mesh = Mesh::kBox,
                         .model = placed({out.middle.x, 0.0, 0.02 * l.unit}, Quat(1, 0, 0, 0),
                                         {3.0 * out.reach, 0.10 * l.unit, 0.04 * l.unit}),
                         .colour = kRail});

  const int users = static_cast<int>(l.scene.users.size());
  const int objects = static_cast<int>(l.scene.objects.size());
  const Site& own = seen.sites[static_cast<std::size_t>(seen.own)];
  if (own.has_objects)
    for (int o = 0; o < objects; ++o)
      add_object(out, l, o, own.objects[static_cast<std::size_t>(o)], kBoxColour, kBoxEdge, false);
  for (int u = 0; u < users; ++u)
    if (seen.sites[static_cast<std::size_t>(u)].has_hand) add_user(out, l, seen, u, options);
  if (options.ghosts)
    for (int s = 0; s < kSites; ++s) {
      const Site& site = seen.sites[static_cast<std::size_t>(s)];
      if (s == seen.own || !site.has_objects) continue;
      for (int o = 0; o < objects; ++o)
        add_object(out, l, o, site.objects[static_cast<std::size_t>(o)],
                   with_opacity(colour_of_site(s), 0.12f), with_opacity(colour_of_site(s), 0.85f),
                   true);
    }
  return out;
}

}  // namespace tandem::view
