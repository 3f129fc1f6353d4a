#include "bench/tick.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "arch_distributed/distributed_loop.h"
#include "arch_distributed/replica_law.h"
#include "bench/plain_tick.h"
#include "bench/processor_time.h"
#include "bench/report.h"
#include "core/axis_world.h"
#include "core/plane_world.h"
#include "scene/load_scene.h"

namespace tandem::bench {
namespace {

using Law = distributed::ReplicaLaw<core::PlaneWorld>;

constexpr int kFingers = 4;  // two users with two each
constexpr int kWalls = 2;
constexpr int kTicksPerPacket = 8;
constexpr int kTicks = 4096;  // 4 s: approach, grasp, carry along y into the floor, back

/// The scene and the prescribed motion of the hands and of the other copy, in both spellings. The
/// plain side is given the peer's samples already held over a packet period.
struct Session {
  core::Scene scene;
  PlainScene plain{};
  std::vector<std::array<PlainFinger, kFingers>> plain_fingers;
  std::vector<PlainBody> plain_other;
  std::vector<core::HandSample<core::Vec2>> own_hand;
  std::vector<core::SiteState<core::PlaneWorld>> packets;  // one a packet period
};

core::Scene make_scene() {
  core::Scene scene;
  scene.name = "bench_tick";
  scene.space = core::Space::kPlane;
  scene.contact.attached = false;
  scene.contact.friction = {0.6, 0.5, 0.005};

  core::ObjectParameters box;
  box.name = "box";
  box.shape = core::Shape::kBox;
  box.size = {0.1, 0.1, 0.0};
  box.mass = 0.7;
  box.ground_friction = 0.05;
  box.ground_friction_rotation = 0.15;
  scene.objects.push_back(box);

  core::WallParameters wall;
  wall.gain = {4000.0, 30.0};
  wall.tangential = {7000.0, 50.0};
  wall.friction = {0.3, 0.25, 0.005};
  wall.name = "floor", wall.point = {0.0, -0.06, 0.0}, wall.normal = {0.0, 1.0, 0.0};
  scene.walls.push_back(wall);
  wall.name = "right", wall.point = {0.06, 0.0, 0.0}, wall.normal = {-1.0, 0.0, 0.0};
  scene.walls.push_back(wall);

  for (const char* name : {"1", "2"}) {
    core::UserParameters user;
    user.name = name;
    user.mass = 0.07;
    user.fingers.resize(2);
    scene.users.push_back(user);
    core::CouplerParameters hand;
    hand.object = "box", hand.user = name, hand.copy = "1";
    hand.gain = {800.0, 3.0}, hand.tangential = {1200.0, 10.0};
    scene.couplers.push_back(hand);
  }
  core::CouplerParameters copies;
  copies.object = "box", copies.copy = "1";
  copies.gain = {400.0, 8.0}, copies.rotation = {10.0, 0.1};
  scene.couplers.push_back(copies);
  return scene;
}

/// The same numbers, written down once more.
PlainScene make_plain_scene() {
  const double half = 0.05, mass = 0.7, weight = mass * 9.81;
  const double mean_radius = half * (std::sqrt(2.0) + std::asinh(1.0)) / 3.0;  // of a square
  PlainScene p{};
  p.T = 1.0 / 1024.0, p.mass = mass, p.inertia = mass * (4 * half * half) * 2 / 12;
  p.half_x = p.half_y = half;
  p.kn = 800, p.bn = 3, p.kt = 1200, p.bt = 10, p.mu_s = 0.6, p.mu_k = 0.5, p.v_tr = 0.005;
  p.wkn = 4000, p.wbn = 30, p.wkt = 7000, p.wbt = 50;
  p.wmu_s = 0.3, p.wmu_k = 0.25, p.wv_tr = 0.005;
  p.wall_x[0] = 0, p.wall_y[0] = -0.06, p.wall_nx[0] = 0, p.wall_ny[0] = 1;
  p.wall_x[1] = 0.06, p.wall_y[1] = 0, p.wall_nx[1] = -1, p.wall_ny[1] = 0;
  p.ko = 400, p.bo = 8, p.kr = 10, p.br = 0.1;
  p.friction_force = 0.05 * weight, p.friction_torque = 0.15 * weight * mean_radius;
  return p;
}

Session make_session() {
  Session s;
  s.scene = make_scene();
  s.plain = make_plain_scene();
  // Fingers close on the left and right faces in 0.25 s, then go down and up with a slow swing to
  // the right, so that floor and right wall are met at corners, now one, now two.
  for (int k = 0; k < kTicks; ++k) {
    const double t = k * s.plain.T;
    const double ramp = std::min(t / 0.25, 1.0);
    const double x = 0.008 * std::sin(1.7 * t), vx = 0.008 * 1.7 * std::cos(1.7 * t);
    const double y = -0.014 * std::sin(2.0 * t), vy = -0.014 * 2.0 * std::cos(2.0 * t);
    const double gap = 0.006 * (1.0 - ramp) - 0.003 * ramp, v_gap = ramp < 1.0 ? -0.036 : 0.0;
    std::array<PlainFinger, kFingers> f{};
    for (int i = 0; i < kFingers; ++i) {
      const double sign = i % 2 == 0 ? -1.0 : 1.0;
      const double high = i < 2 ? 0.012 : -0.015;
      f[i] = {x + sign * (0.05 + gap), y + high, vx + sign * v_gap, vy};
    }
    PlainBody o{0.5 * x, 0.5 * y, 0.05 * std::sin(t), 0.5 * vx, 0.5 * vy, 0.05 * std::cos(t)};

    core::HandSample<core::Vec2> own;
    core::SiteState<core::PlaneWorld> peer;
    for (int i = 0; i < 2; ++i) {
      own[i] = {{f[i].x, f[i].y}, {f[i].vx, f[i].vy}};
      peer.fingers[i] = {{f[i + 2].x, f[i + 2].y}, {f[i + 2].vx, f[i + 2].vy}};
    }
    peer.objects[0] = {{o.x, o.y}, o.angle, {o.vx, o.vy}, o.omega};
    s.own_hand.push_back(own);
    if (k % kTicksPerPacket == 0) s.packets.push_back(peer);

    if (k % kTicksPerPacket != 0) {
      f[2] = s.plain_fingers.back()[2];
      f[3] = s.plain_fingers.back()[3];
      o = s.plain_other.back();
    }
    s.plain_fingers.push_back(f);
    s.plain_other.push_back(o);
  }
  return s;
}

/// One slot of the law: the hand's sample in, a packet every eighth, forces out.
core::Fault law_slot(const Session& s, Law& law, int k) noexcept {
  Law::Inputs inputs;
  if (k % kTicksPerPacket == 0) inputs.fresh[1] = &s.packets[k / kTicksPerPacket];
  inputs.age[1] = (k % kTicksPerPacket) * s.plain.T;
  (void)law.observe(s.own_hand[k]);
  return law.tick(k, inputs).faults;
}

/// Nanoseconds a tick over one session from rest.
double time_law(const Session& s, Law& law) {
  law = Law(s.scene, 0);
  const auto start = std::chrono::steady_clock::now();
  for (int k = 0; k < kTicks; ++k) (void)law_slot(s, law, k);
  return std::chrono::duration<double, std::nano>(std::chrono::steady_clock::now() - start)
             .count() /
         kTicks;
}

double time_plain(const Session& s, PlainState& z) {
  z = PlainState{};
  const auto start = std::chrono::steady_clock::now();
  for (int k = 0; k < kTicks; ++k)
    plain_tick(s.plain, z, s.plain_fingers[k].data(), s.plain_other[k]);
  return std::chrono::duration<double, std::nano>(std::chrono::steady_clock::now() - start)
             .count() /
         kTicks;
}

/// Both run the same session; how far the two boxes part over it [m], and how busy it was.
struct Comparison {
  double path_difference = 0.0;
  double busy_fingers = 0.0, busy_corners = 0.0;  // mean number in contact
};

Comparison compare(const Session& s) {
  Comparison out;
  Law a(s.scene, 0);
  PlainState b{};
  for (int k = 0; k < kTicks; ++k) {
    (void)law_slot(s, a, k);
    plain_tick(s.plain, b, s.plain_fingers[k].data(), s.plain_other[k]);
    const core::Vec2 p = a.object(0).p;
    out.path_difference = std::max(out.path_difference, std::hypot(p.x - b.body.x, p.y - b.body.y));
    for (const PlainContact& c : b.finger) out.busy_fingers += c.state != 0 ? 1.0 / kTicks : 0.0;
    for (const auto& wall : b.corner)
      for (const PlainContact& c : wall) out.busy_corners += c.state != 0 ? 1.0 / kTicks : 0.0;
  }
  return out;
}

/// Seconds of virtual time a second of processor for a shipped scene of two users, with hands,
/// laws and links in one loop.
template <typename World>
double virtual_speed(const core::Scene& scene) {
  distributed::DistributedLoop<World> loop(scene);
  constexpr int kSlots = 4096;
  const double start = core_ns();
  for (int k = 0; k < kSlots; ++k) loop.tick();
  return kSlots * scene.tick() / ((core_ns() - start) * 1e-9);
}

void run(int rounds, const std::string& json_file) {
  const Session s = make_session();
  const Comparison comparison = compare(s);
  const core::Scene plane = scene::load_scene("box_distributed");
  const core::Scene axis = scene::load_scene("axis_distributed");
  std::vector<double> tick_ns, plain_ns, plane_speed, axis_speed;
  Law a;
  PlainState b{};
  for (int r = 0; r < rounds + 2; ++r) {  // interleaved, so that both see the same machine
    const double tick = time_law(s, a), plain = time_plain(s, b);
    if (r < 2) continue;  // warm-up
    tick_ns.push_back(tick);
    plain_ns.push_back(plain);
    if (r % 8 != 2) continue;
    plane_speed.push_back(virtual_speed<core::PlaneWorld>(plane));
    axis_speed.push_back(virtual_speed<core::AxisWorld>(axis));
  }
  const double tick = median(tick_ns), plain = median(plain_ns);
  const std::string text = fmt::format(
      "one planar tick, {} fingers, box, {} walls, ground friction, other copy\n"
      "(in contact on average: {:.2f} fingers, {:.2f} corners)\n"
      "  Tandem          {:7.1f} ns\n  plain doubles   {:7.1f} ns\n  ratio           {:7.2f}"
      "  (at most 2)\n  largest distance of the two boxes {:.2e} m\n"
      "virtual time on one core, two users, hands, laws and links\n"
      "  box_distributed  {:8.0f} times real time  (at least 1000)\n"
      "  axis_distributed {:8.0f} times real time  (at least 3000)\n",
      kFingers, kWalls, comparison.busy_fingers, comparison.busy_corners, tick, plain, tick / plain,
      comparison.path_difference, median(plane_speed), median(axis_speed));
  report(json_file, text,
         {{"tick_ns", tick},
          {"plain_tick_ns", plain},
          {"ratio", tick / plain},
          {"fingers", kFingers},
          {"walls", kWalls},
          {"mean_fingers_in_contact", comparison.busy_fingers},
          {"mean_corners_in_contact", comparison.busy_corners},
          {"path_difference_m", comparison.path_difference},
          {"virtual_speed_box_distributed", median(plane_speed)},
          {"virtual_speed_axis_distributed", median(axis_speed)},
          {"ticks_per_round", kTicks},
          {"rounds", rounds}});
}

}  // namespace

void add_bench_tick(CLI::App& bench) {
  CLI::App* app = bench.add_subcommand("tick", "one planar tick beside plain doubles");
  auto rounds = std::make_shared<int>(101);
  auto json_file = std::make_shared<std::string>();
  app->add_option("--rounds", *rounds, "timed sessions of each, interleaved; the median counts")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  app->add_option("--json", *json_file, "write the result as JSON to this file; - is the output");
  app->callback([rounds, json_file] { run(*rounds, *json_file); });
}

}  // namespace tandem::bench
