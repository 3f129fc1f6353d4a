#pragma once

#include <cmath>
#include <string>

#include "core/network_model.h"
#include "core/random.h"
#include "core/scene.h"

namespace tandem::tests {

struct RandomScene {
  core::Scene scene;
  core::NetworkModel network;
  std::string about;
};

/// A linear axis scene of any architecture: two to `max_users` users, random gains and masses, 1 to
/// 12 ticks a packet, delays of whole packets or of any number of ticks on each link.
inline RandomScene random_scene(core::Random& random, int max_users, bool two_site_form = false) {
  using core::Architecture;
  RandomScene out;
  core::Scene& scene = out.scene;
  const auto pick = [&](int n) { return static_cast<int>(random.uniform() * n); };
  const auto gain = [&](double k_max) {
    return core::Gain{random.uniform(20.0, k_max), random.uniform(1.0, 15.0)};
  };
  const int users = max_users <= 2 ? 2 : 2 + pick(max_users - 1);
  const int kind = pick(3);
  scene.architecture = kind == 0   ? Architecture::kCentral
                       : kind == 1 ? Architecture::kDistributed
                                   : Architecture::kDistributedSplit;
  const int N = 1 + pick(12);
  scene.rates.packet_hz = scene.rates.local_hz / N;
  scene.objects.resize(1);
  scene.objects[0].name = "box";
  scene.objects[0].mass = random.uniform(0.2, 1.0);
  if (pick(4) == 0) scene.objects[0].compensation = random.uniform(0.0, 2.0);
  if (pick(5) == 0) {
    core::WallParameters wall;
    wall.name = "wall";
    wall.normal = core::Vec3(-1, 0, 0);
    wall.gain = gain(4000.0);
    wall.attached = true;
    scene.walls.push_back(wall);
  }
  for (int u = 0; u < users; ++u) {
    core::UserParameters user;
    user.name = std::to_string(u + 1);
    user.mass = random.uniform(0.05, 0.3);
    user.local = u == 0;
    user.fingers.resize(1);
    user.fingers[0].name = "a";
    if (!two_site_form && pick(6) == 0) user.fingers[0].damping = random.uniform(0.1, 2.0);
    if (!two_site_form && pick(8) == 0) user.fingers[0].hand = {random.uniform(50, 500), 2.0};
    scene.users.push_back(user);
  }
  const auto couple = [&](const std::string& user, const std::string& copy, core::Gain g) {
    core::CouplerParameters c;
    c.name = "c" + std::to_string(scene.couplers.size());
    c.object = "box";
    c.user = user;
    c.copy = copy;
    c.gain = g;
    scene.couplers.push_back(c);
  };
  for (int u = 0; u < users; ++u) {
    const std::string name = scene.users[u].name;
    if (kind == 0) {
      couple(name, "", u == 0 ? gain(3000.0) : gain(400.0));
      continue;
    }
    couple(name, name, gain(3000.0));
    couple("", name, gain(800.0));
    for (int j = 0; kind == 1 && j < users; ++j)
      if (j != u) couple(scene.users[j].name, name, gain(800.0));
  }
  const bool whole = two_site_form || pick(2) == 0;
  for (auto& row : out.network.link)
    for (auto& link : row) link.delay_ticks = whole ? N * pick(3) : pick(3 * N);
  out.about = "kind " + std::to_string(kind) + " users " + std::to_string(users) + " N " +
              std::to_string(N) + (whole ? " whole" : " ticks");
  return out;
}

}  // namespace tandem::tests
