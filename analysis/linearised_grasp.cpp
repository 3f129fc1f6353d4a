#include "analysis/linearised_grasp.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "core/trigonometry.h"

namespace tandem::analysis {

namespace {

/// The point on the surface of a box, centred at `object`, straight in from the side that the
/// finger is off.
core::Vec3 on_surface(const core::ObjectParameters& object, const core::Vec3& finger) {
  const core::SinCos turn = core::sin_cos(object.angle);
  const core::Vec3 arm = finger - object.position;
  core::Vec2 r(turn.cos * arm.x + turn.sin * arm.y, -turn.sin * arm.x + turn.cos * arm.y);
  const core::Vec2 half(0.5 * object.size.x, 0.5 * object.size.y);
  const int side = std::abs(r.x) - half.x > std::abs(r.y) - half.y ? 0 : 1;
  r[side] = r[side] < 0.0 ? -half[side] : half[side];
  r[1 - side] = std::clamp(r[1 - side], -half[1 - side], half[1 - side]);
  return object.position +
         core::Vec3(turn.cos * r.x - turn.sin * r.y, turn.sin * r.x + turn.cos * r.y, 0.0);
}

}  // namespace

core::Scene linearised_at_grasp(core::Scene scene) {
  for (auto& device : scene.devices) {
    device.encoder_step = device.friction = 0.0;
    device.max_force = device.max_slew = 0.0;
  }
  if (scene.space == core::Space::kAxis) return scene;
  if (scene.space != core::Space::kPlane || scene.objects.empty())
    throw std::invalid_argument("only a scene in the plane with an object has a linearised grasp");
  scene.contact = {};
  scene.contact.attached = true;
  scene.walls.clear();
  scene.silence.reset();
  for (auto& object : scene.objects) object.ground_friction = object.ground_friction_rotation = 0.0;
  for (auto& device : scene.devices) device.velocity_cutoff_hz = 0.0;
  for (auto& user : scene.users)
    for (auto& finger : user.fingers) {
      finger.position = on_surface(scene.objects.front(), finger.position);
      finger.hand = {};
      finger.damping = 0.0;
      finger.intent = {};
    }
  return scene;
}

}  // namespace tandem::analysis
