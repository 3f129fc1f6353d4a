#include "harness/tasks.h"

#include <algorithm>
#include <cmath>

#include "analysis/drag.h"
#include "analysis/linearised_grasp.h"

namespace tandem::harness {

namespace {

constexpr double kTwoPi = 6.283185307179586;

void quiet(core::Scene& scene, const core::Gain& muscle) {
  for (auto& user : scene.users)
    for (auto& finger : user.fingers) {
      finger.intent = {};
      finger.hand = muscle;
      finger.damping = 0.0;
    }
}

constexpr core::Gain kStiffMuscle{20000.0, 90.0};  // damping ratio 1 with 0.1 kg

}  // namespace

core::Scene kicked(const core::Scene& given) {
  core::Scene scene = analysis::linearised_at_grasp(given);
  scene.silence.reset();
  quiet(scene, {});
  double start = kKickStart;
  double sign = 1.0;
  for (auto& user : scene.users)
    for (auto& finger : user.fingers) {
      core::SinePart push;
      push.start = start;
      push.end = start + 1.0 / kKickHz;
      push.amplitude = sign;
      push.omega = kTwoPi * kKickHz;
      push.direction = core::Vec3(1.0, 0.0, 0.0);
      finger.intent.force_sines.push_back(push);
      if (scene.space != core::Space::kAxis) {
        push.start += 0.03;
        push.end += 0.03;
        push.direction = core::Vec3(0.0, 1.0, 0.0);
        finger.intent.force_sines.push_back(push);
      }
      start += 0.02;
      sign = -sign;
    }
  // A motion of millimetres stays linear in the plane.
  if (scene.space != core::Space::kAxis)
    for (auto& user : scene.users)
      for (auto& finger : user.fingers)
        for (auto& push : finger.intent.force_sines) push.amplitude *= 0.01;
  return scene;
}

core::Scene pushed(const core::Scene& given, int user, double force) {
  core::Scene scene = analysis::with_one_hand(given, given.users[user].name);
  quiet(scene, {});
  scene.users[user].fingers[0].intent.force = core::Vec3(force, 0.0, 0.0);
  return scene;
}

core::Scene carried(const core::Scene& given) {
  core::Scene scene = given;
  if (scene.space != core::Space::kAxis) return scene;
  quiet(scene, {100.0, 2.0});
  core::SinePart path;
  path.amplitude = 0.05;
  path.omega = 2.0;
  path.direction = core::Vec3(1.0, 0.0, 0.0);
  scene.users[0].fingers[0].intent.path_sines.push_back(path);
  return scene;
}

core::Scene touched(const core::Scene& given, int user) {
  core::Scene scene = given;
  quiet(scene, kStiffMuscle);
  auto& step = scene.users[0].fingers[0].intent.path;
  step.push_back({kStepStart, core::Vec3(0.0)});
  step.push_back({kStepStart + 0.02, core::Vec3(0.005, 0.0, 0.0)});
  core::SinePart press;
  press.start = kPressStart;
  press.amplitude = 0.005;
  press.omega = kTwoPi / kPressPeriod;
  press.direction = core::Vec3(1.0, 0.0, 0.0);
  scene.users[user].fingers[0].intent.path_sines.push_back(press);
  return scene;
}

void measure_touch(Trajectory session, int user, Measures& measures) {
  if (has_blown_up(session)) return;
  measures.rendered_stiffness = measure_stiffness(session, user, kPressPeriod);
  session.first_slot =
      std::max(session.first_slot, std::int64_t{std::llround(0.9 * kStepStart / session.tick)});
  if (session.sites.size() > 1)
    measures.motion_to_force = motion_to_force(session, 0, 1, kStepMotion, kStepForce);
}

}  // namespace tandem::harness
