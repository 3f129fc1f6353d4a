#pragma once

#include <string>

#include "core/scene.h"

namespace tandem::tests {

/// An axis scene of n users with their copies of one mass, made in code because the shipped scenes
/// have two. Split: m/n each, joined by couplers only; else every hand acts on every copy.
inline core::Scene axis_users(int n, bool split, core::Gain grasp, core::Gain remote,
                              core::Gain coordination, double mass = 0.8) {
  core::Scene scene;
  scene.name = "users";
  scene.architecture =
      split ? core::Architecture::kDistributedSplit : core::Architecture::kDistributed;
  core::ObjectParameters object;
  object.name = "box";
  object.mass = mass;
  scene.objects.push_back(object);
  const auto add = [&](const std::string& user, const std::string& copy, core::Gain gain) {
    core::CouplerParameters coupler;
    coupler.name = "k" + user + "_" + copy;
    coupler.object = "box";
    coupler.user = user;
    coupler.copy = copy;
    coupler.gain = gain;
    scene.couplers.push_back(coupler);
  };
  for (int i = 1; i <= n; ++i) {
    core::UserParameters user;
    user.name = std::to_string(i);
    user.fingers.resize(1);
    user.fingers[0].name = "a";
    scene.users.push_back(user);
    add(user.name, user.name, grasp);
    add("", user.name, coordination);
    for (int j = 1; j <= n && !split; ++j)
      if (j != i) add(std::to_string(j), user.name, remote);
  }
  return scene;
}

}  // namespace tandem::tests
