#include "analysis/experiments.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "analysis/growth.h"
#include "analysis/linearised_grasp.h"
#include "analysis/with_loop.h"

namespace tandem::analysis {

namespace {

using core::PlaneWorld;
using core::Scene;
using core::Vec3;

/// All three figures were taken over a LAN with one packet period of round trip.
core::NetworkModel one_packet_round_trip(const Scene& scene) {
  core::NetworkModel network;
  network.set_round_trip(1.0, scene.ticks_per_packet());
  return network;
}

double growth_at_grasp(const Scene& scene) {
  const Scene grasp = linearised_at_grasp(scene);
  GrowthOptions options;
  options.amplitude = 1e-6;  // the turning of the box is linear only for small angles
  return measure_growth(grasp, one_packet_round_trip(grasp), options).per_packet;
}

Table run_both_users(const Scene& scene, double seconds) {
  Table table{
      {"t_s", "box_x_m", "box_y_m", "box_angle_rad", "user1_a_fx_N", "user1_a_fy_N", "user1_b_fx_N",
       "user1_b_fy_N", "user2_a_fx_N", "user2_a_fy_N", "user2_b_fx_N", "user2_b_fy_N"},
      {}};
  with_loop_of<PlaneWorld>(scene, one_packet_round_trip(scene), [&](auto& loop) {
    while (loop.time() < seconds) {
      loop.advance_packet_period();
      const core::PlaneBody& box = loop.object(1, 0);
      std::vector<double> row{loop.time(), box.p.x, box.p.y, box.angle};
      for (int u = 0; u < 2; ++u)
        for (int f = 0; f < 2; ++f) {
          const core::Vec2& force = loop.output(u).forces[f];
          row.insert(row.end(), {force.x, force.y});
        }
      table.rows.push_back(std::move(row));
    }
    return 0;
  });
  return table;
}

void keep_only_hand(Scene& scene, const std::string& user) {
  std::erase_if(scene.couplers, [&](const core::CouplerParameters& c) {
    return !c.user.empty() && c.user != user;
  });
}

constexpr double kAmplitude = 0.05;  // [m], thesis 8.2
constexpr double kOmega = 2.0;       // [rad/s]

/// One user's fingers at the two faces across the motion, ready to carry the box along y.
Scene carrying_scene(Scene scene) {
  keep_only_hand(scene, scene.users[0].name);
  scene.walls.clear();
  core::ObjectParameters& box = scene.objects[0];
  box.ground_friction = box.ground_friction_rotation = 0.0;
  const double half = 0.5 * box.size.y;
  auto& fingers = scene.users[0].fingers;
  for (int f = 0; f < 2; ++f) {
    fingers[f].position = box.position + Vec3(0.0, f == 0 ? -half : half, 0.0);
    fingers[f].damping = 0.0;
    fingers[f].intent = {};
    core::SinePart path;
    path.amplitude = kAmplitude;
    path.omega = kOmega;
    path.direction = Vec3(0.0, 1.0, 0.0);
    fingers[f].intent.path_sines.push_back(path);
  }
  fingers[0].hand = {2000.0, 20.0};  // the proportional-derivative controller of the pantograph
  // The second pantograph presses with a constant force. A soft spring to the same path keeps it
  // from toppling sideways: a constant push on a free finger is a column that buckles.
  fingers[1].hand = {100.0, 5.0};
  fingers[1].intent.force = Vec3(0.0, -2.0, 0.0);
  return scene;
}

struct NetForce {
  double rms = 0.0;
  std::vector<double> samples;  ///< one a packet period
};

/// Net y force of user 1's fingers on its copy over whole cycles after 5 s.
NetForce carry(const Scene& scene) {
  constexpr int kCycles = 4;
  const double end = 5.0 + kCycles * 2.0 * std::numbers::pi / kOmega;
  return with_loop_of<PlaneWorld>(scene, one_packet_round_trip(scene), [&](auto& loop) {
    NetForce net;
    double sum = 0.0;
    std::int64_t n = 0;
    while (loop.time() < end) {
      loop.tick();
      const double force = loop.user_wrench(0, 0).force.y;
      if (loop.packet_slots().sends(loop.slot())) net.samples.push_back(force);
      if (loop.time() < 5.0) continue;
      sum += force * force;
      ++n;
    }
    net.rms = std::sqrt(sum / static_cast<double>(n));
    return net;
  });
}

constexpr double kJoined = 1.0;  // [s]; before it the peers' forces are still ramping in

/// One free finger behind the box, the box at the wall, everything just touching.
Scene pressing_scene(Scene scene, int user) {
  keep_only_hand(scene, scene.users[user].name);
  core::ObjectParameters& box = scene.objects[0];
  const core::WallParameters& wall = scene.walls.at(0);
  const double half = 0.5 * box.size.y;
  box.position = Vec3(0.0, wall.point.y - half, 0.0);
  for (std::size_t u = 0; u < scene.users.size(); ++u) {
    auto& fingers = scene.users[u].fingers;
    for (auto& finger : fingers) finger.intent = {};
    if (static_cast<int>(u) != user) continue;
    fingers.resize(1);
    fingers[0].position = box.position - Vec3(0.0, half, 0.0);
    fingers[0].hand = {};
    fingers[0].damping = 2.0;
    core::SinePart push;
    push.amplitude = 1.5;
    push.omega = 3.0;
    push.start = kJoined;
    push.direction = Vec3(0.0, 1.0, 0.0);
    push.positive_part_only = true;
    fingers[0].intent.force_sines.push_back(push);
  }
  return scene;
}

std::vector<double> press(const Scene& scene, int user, double seconds) {
  return with_loop_of<PlaneWorld>(scene, one_packet_round_trip(scene), [&](auto& loop) {
    const double start = loop.hands().finger(user, 0).position().y;
    std::vector<double> travel;
    while (loop.time() < seconds) {
      loop.advance_packet_period();
      travel.push_back(loop.hands().finger(user, 0).position().y - start);
    }
    return travel;
  });
}

}  // namespace

Fig81 run_fig_8_1(const SceneSource& scenes, double seconds) {
  const Scene central = scenes("box_central_table_8_1", {});
  const Scene distributed = scenes("box_distributed", {});
  Fig81 out;
  out.central_growth_per_packet = growth_at_grasp(central);
  out.distributed_growth_per_packet = growth_at_grasp(distributed);
  out.central_run = run_both_users(central, seconds);
  out.distributed_run = run_both_users(distributed, seconds);
  return out;
}

Fig83 run_fig_8_3(const SceneSource& scenes) {
  const Scene hold = carrying_scene(scenes("box_distributed", {}));
  const Scene compensated =
      carrying_scene(scenes("box_distributed", {"object.box.compensation=0.88",
                                                "object.box.compensation_rotation=0.025"}));
  const Scene extrapolated =
      carrying_scene(scenes("box_distributed", {"reconstruction.kind=EXTRAPOLATE"}));
  const Scene central = carrying_scene(scenes("box_central", {}));

  const double peak = hold.objects[0].mass * kOmega * kOmega * kAmplitude;
  const NetForce runs[] = {carry(hold), carry(compensated), carry(extrapolated), carry(central)};
  Fig83 out;
  out.ideal = peak / std::sqrt(2.0);
  out.hold = runs[0].rms;
  out.compensated = runs[1].rms;
  out.extrapolated = runs[2].rms;
  out.central_local = runs[3].rms;
  out.forces.columns = {"t_s",           "ideal_N",        "hold_N",
                        "compensated_N", "extrapolated_N", "central_local_N"};
  for (std::size_t i = 0; i < runs[0].samples.size(); ++i) {
    const double t = static_cast<double>(i + 1) / hold.rates.packet_hz;
    out.forces.rows.push_back({t, -peak * std::sin(kOmega * t), runs[0].samples[i],
                               runs[1].samples[i], runs[2].samples[i], runs[3].samples[i]});
  }
  return out;
}

Fig84 run_fig_8_4(const SceneSource& scenes) {
  constexpr double kSeconds = kJoined + 6.5;  // three pushes
  const Scene central = scenes("box_central", {});
  const int local = central.users[0].local ? 0 : 1;
  const auto at_server = press(pressing_scene(central, local), local, kSeconds);
  const auto remote = press(pressing_scene(central, 1 - local), 1 - local, kSeconds);
  const auto distributed = press(pressing_scene(scenes("box_distributed", {}), 0), 0, kSeconds);
  Fig84 out;
  out.central_local = *std::max_element(at_server.begin(), at_server.end());
  out.central_remote = *std::max_element(remote.begin(), remote.end());
  out.distributed = *std::max_element(distributed.begin(), distributed.end());
  out.travel.columns = {"t_s", "push_N", "central_local_m", "central_remote_m", "distributed_m"};
  for (std::size_t i = 0; i < at_server.size(); ++i) {
    const double t = static_cast<double>(i + 1) / central.rates.packet_hz;
    out.travel.rows.push_back(
        {t, t < kJoined ? 0.0 : std::max(0.0, 1.5 * std::sin(3.0 * (t - kJoined))), at_server[i],
         remote[i], distributed[i]});
  }
  return out;
}

}  // namespace tandem::analysis
