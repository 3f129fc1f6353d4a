#include "analysis/coupler_limits.h"

#include <limits>

#include "analysis/stability.h"

namespace tandem::analysis {

namespace {

constexpr double kTop = 1e8;  // [N/m]; a steel bar is no stiffer

core::Scene scene_of(const LocalCoupler& c, const PassiveHand& hand) {
  core::Scene scene;
  scene.architecture = core::Architecture::kSingle;
  scene.rates.local_hz = scene.rates.packet_hz = 1.0 / c.T;
  scene.rates.latency_ticks = c.latency_ticks;
  scene.integrator = c.integrator;
  core::UserParameters user;
  user.name = "1";
  user.mass = hand.mass;
  core::FingerParameters finger;
  finger.name = "a";
  finger.hand = {hand.stiffness, hand.damping};
  finger.damping = c.device_damping;
  user.fingers.push_back(finger);
  scene.users.push_back(user);
  return scene;
}

/// Where the interval that begins at no spring ends. Scanned by decades, for how far is not known.
double end_of_first(const core::Scene& scene, const std::string& field) {
  StabilityJudge judge(scene, {});
  const Knob knob(scene, field);
  IntervalOptions options;
  options.samples = 40;
  options.tolerance = 1e-9;
  for (double low = 1e-3; low < kTop; low *= 100.0) {
    const auto stable = stable_intervals(judge, scene, knob, low, 100.0 * low, options);
    if (stable.empty() || stable.front().low > low) return low > 1e-3 ? low : 0.0;
    if (stable.front().high < 100.0 * low) return stable.front().high;
  }
  return std::numeric_limits<double>::infinity();
}

}  // namespace

std::vector<PassiveHand> sampled_hands() {
  std::vector<PassiveHand> hands;
  for (const double mass : {0.01, 0.1, 1.0, 10.0})
    for (const double stiffness : {0.0, 300.0, 30000.0})
      for (const double damping : {0.0, 10.0, 100.0}) hands.push_back({mass, stiffness, damping});
  return hands;
}

double stable_wall_stiffness(const LocalCoupler& c, const PassiveHand& hand) {
  core::Scene scene = scene_of(c, hand);
  core::WallParameters wall;
  wall.name = "w";
  wall.normal = core::Vec3(-1.0, 0.0, 0.0);
  wall.gain = {c.stiffness, c.damping};
  wall.attached = true;
  wall.touches_objects = false;
  wall.touches_fingers = true;
  scene.walls.push_back(wall);
  return end_of_first(scene, "wall.w.stiffness");
}

double stable_coupler_stiffness(const LocalCoupler& c, const PassiveHand& hand) {
  core::Scene scene = scene_of(c, hand);
  core::ObjectParameters object;
  object.name = "o";
  object.mass = c.object_mass;
  scene.objects.push_back(object);
  core::CouplerParameters coupler;
  coupler.name = "k";
  coupler.object = "o";
  coupler.user = "1";
  coupler.gain = {c.stiffness, c.damping};
  scene.couplers.push_back(coupler);
  return end_of_first(scene, "coupler.k.stiffness");
}

WorstHand worst_wall_stiffness(const LocalCoupler& c) {
  WorstHand worst{std::numeric_limits<double>::infinity(), {}};
  for (const PassiveHand& hand : sampled_hands())
    if (const double k = stable_wall_stiffness(c, hand); k < worst.stiffness) worst = {k, hand};
  return worst;
}

WorstHand worst_coupler_stiffness(LocalCoupler c) {
  WorstHand worst = worst_wall_stiffness(c);
  for (const double mass : {0.03, 3.0, 300.0}) {
    c.object_mass = mass;
    for (const PassiveHand& hand : sampled_hands())
      if (const double k = stable_coupler_stiffness(c, hand); k < worst.stiffness)
        worst = {k, hand};
  }
  return worst;
}

}  // namespace tandem::analysis
