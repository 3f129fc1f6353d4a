#include "bench/tick.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "bench/plain_tick.h"
#include "core/coordination.h"
#include "core/plane_body.h"
#include "core/plane_contact.h"

namespace tandem::bench {
namespace {

constexpr int kFingers = 4;
constexpr int kWalls = 2;
constexpr int kTicks = 4096;  // 4 s: approach, grasp, carry along y into the floor, back

/// The scene and the prescribed motion of fingers and of the other copy, in both spellings.
struct Session {
  PlainScene plain{};
  core::PlaneBodyParameters body;
  core::PlaneBox box;
  core::ContactGains grasp;
  std::array<core::PlaneWall, kWalls> walls;
  core::Gain coordination, coordination_rotation;
  std::vector<std::array<PlainFinger, kFingers>> plain_fingers;
  std::vector<std::array<core::PlanePoint, kFingers>> fingers;
  std::vector<PlainBody> plain_other;
  std::vector<core::PlaneBody> other;
};

struct ReplicaState {
  core::PlaneBody body;
  std::array<core::FingerBoxContact, kFingers> contacts;
  std::array<core::WallContacts, kWalls> walls;
  std::array<core::Vec2, kFingers> forces{core::Vec2{0.0}, core::Vec2{0.0}, core::Vec2{0.0},
                                          core::Vec2{0.0}};
};

Session make_session() {
  Session s;
  const double T = 1.0 / 1024.0, mass = 0.7, half = 0.05;
  core::ObjectParameters object;
  object.mass = mass;
  object.size = {2 * half, 2 * half, 0.0};
  object.ground_friction = 0.05;
  object.ground_friction_rotation = 0.15;
  s.body = core::plane_body_parameters(object, 9.81);
  s.box = {{half, half}, 0.0};
  s.grasp.normal = {800.0, 3.0};
  s.grasp.tangential = {1200.0, 10.0};
  s.grasp.friction = {0.6, 0.5, 0.005};
  core::ContactGains wall;
  wall.normal = {4000.0, 30.0};
  wall.tangential = {7000.0, 50.0};
  wall.friction = {0.3, 0.25, 0.005};
  s.walls[0] = {{0.0, -0.06}, {0.0, 1.0}, wall};
  s.walls[1] = {{0.06, 0.0}, {-1.0, 0.0}, wall};
  s.coordination = {400.0, 8.0};
  s.coordination_rotation = {10.0, 0.1};

  PlainScene& p = s.plain;
  p.T = T, p.mass = mass, p.inertia = 1.0 / s.body.inverse_inertia;
  p.half_x = p.half_y = half;
  p.kn = 800, p.bn = 3, p.kt = 1200, p.bt = 10, p.mu_s = 0.6, p.mu_k = 0.5, p.v_tr = 0.005;
  p.wkn = 4000, p.wbn = 30, p.wkt = 7000, p.wbt = 50;
  p.wmu_s = 0.3, p.wmu_k = 0.25, p.wv_tr = 0.005;
  p.wall_x[0] = 0, p.wall_y[0] = -0.06, p.wall_nx[0] = 0, p.wall_ny[0] = 1;
  p.wall_x[1] = 0.06, p.wall_y[1] = 0, p.wall_nx[1] = -1, p.wall_ny[1] = 0;
  p.ko = 400, p.bo = 8, p.kr = 10, p.br = 0.1;
  p.friction_force = s.body.ground.force, p.friction_torque = s.body.ground.torque;

  // Fingers close on the left and right faces in 0.25 s, then go down and up with a slow swing to
  // the right, so that floor and right wall are met at corners, now one, now two.
  for (int k = 0; k < kTicks; ++k) {
    const double t = k * T;
    const double ramp = std::min(t / 0.25, 1.0);
    const double x = 0.008 * std::sin(1.7 * t), vx = 0.008 * 1.7 * std::cos(1.7 * t);
    const double y = -0.014 * std::sin(2.0 * t), vy = -0.014 * 2.0 * std::cos(2.0 * t);
    const double gap = 0.006 * (1.0 - ramp) - 0.003 * ramp, v_gap = ramp < 1.0 ? -0.036 : 0.0;
    std::array<PlainFinger, kFingers> f{};
    for (int i = 0; i < kFingers; ++i) {
      const double sign = i % 2 == 0 ? -1.0 : 1.0;
      const double high = i < 2 ? 0.012 : -0.015;
      f[i] = {x + sign * (half + gap), y + high, vx + sign * v_gap, vy};
    }
    s.plain_fingers.push_back(f);
    std::array<core::PlanePoint, kFingers> points;
    for (int i = 0; i < kFingers; ++i) points[i] = {{f[i].x, f[i].y}, {f[i].vx, f[i].vy}};
    s.fingers.push_back(points);
    const PlainBody o{0.5 * x, 0.5 * y, 0.05 * std::sin(t), 0.5 * vx, 0.5 * vy, 0.05 * std::cos(t)};
    s.plain_other.push_back(o);
    s.other.push_back({{o.x, o.y}, o.angle, {o.vx, o.vy}, o.omega});
  }
  return s;
}

/// The planar tick of a replica, of the pieces in core/.
[[gnu::noinline]] void replica_tick(const Session& s, ReplicaState& z,
                                    const std::array<core::PlanePoint, kFingers>& fingers,
                                    const core::PlaneBody& other) noexcept {
  const core::PlacedBody placed(z.body);
  const double T = s.plain.T;
  core::PlaneWrench wrench;
  for (int i = 0; i < kFingers; ++i) {
    const core::ContactForces f = touch(z.contacts[i], s.grasp, s.box, placed, fingers[i], T);
    z.forces[i] = f.on_finger_W;
    wrench += f.on_body;
  }
  for (int w = 0; w < kWalls; ++w) wrench += hold_back(z.walls[w], s.walls[w], s.box, placed, T);
  wrench += coordinate(s.coordination, s.coordination_rotation, z.body, other);
  z.body = step(s.body, core::Integrator::kZeroOrderHold, T, z.body, wrench);
}

/// Nanoseconds a tick over one session from rest.
double time_replica(const Session& s, ReplicaState& z) {
  z = ReplicaState{};
  const auto start = std::chrono::steady_clock::now();
  for (int k = 0; k < kTicks; ++k) replica_tick(s, z, s.fingers[k], s.other[k]);
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

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
  return values[values.size() / 2];
}

/// Both run the same session; how far the two boxes part over it [m], and how busy it was.
struct Comparison {
  double path_difference = 0.0;
  double busy_fingers = 0.0, busy_corners = 0.0;  // mean number in contact
};

Comparison compare(const Session& s) {
  Comparison out;
  ReplicaState a;
  PlainState b{};
  for (int k = 0; k < kTicks; ++k) {
    replica_tick(s, a, s.fingers[k], s.other[k]);
    plain_tick(s.plain, b, s.plain_fingers[k].data(), s.plain_other[k]);
    out.path_difference =
        std::max(out.path_difference, std::hypot(a.body.p.x - b.body.x, a.body.p.y - b.body.y));
    for (const auto& c : a.contacts)
      out.busy_fingers += c.memory.state != core::ContactState::kFree ? 1.0 / kTicks : 0.0;
    for (const auto& w : a.walls)
      for (const auto& c : w.corner)
        out.busy_corners += c.state != core::ContactState::kFree ? 1.0 / kTicks : 0.0;
  }
  return out;
}

void run(int rounds, const std::string& json_file) {
  const Session s = make_session();
  const Comparison comparison = compare(s);
  std::vector<double> tick_ns, plain_ns;
  ReplicaState a;
  PlainState b{};
  for (int r = 0; r < rounds + 2; ++r) {  // interleaved, so that both see the same machine
    const double tick = time_replica(s, a), plain = time_plain(s, b);
    if (r < 2) continue;  // warm-up
    tick_ns.push_back(tick);
    plain_ns.push_back(plain);
  }
  const double tick = median(tick_ns), plain = median(plain_ns);
  if (json_file.empty()) {
    fmt::print("one planar tick, {} fingers, box, {} walls, ground friction, other copy\n",
               kFingers, kWalls);
    fmt::print("(in contact on average: {:.2f} fingers, {:.2f} corners)\n", comparison.busy_fingers,
               comparison.busy_corners);
    fmt::print(
        "  Tandem          {:7.1f} ns\n  plain doubles   {:7.1f} ns\n  ratio           {:7.2f}"
        "  (at most 2)\n",
        tick, plain, tick / plain);
    fmt::print("  largest distance of the two boxes {:.2e} m\n", comparison.path_difference);
    return;
  }
  const nlohmann::json result{{"tick_ns", tick},
                              {"plain_tick_ns", plain},
                              {"ratio", tick / plain},
                              {"fingers", kFingers},
                              {"walls", kWalls},
                              {"mean_fingers_in_contact", comparison.busy_fingers},
                              {"mean_corners_in_contact", comparison.busy_corners},
                              {"path_difference_m", comparison.path_difference},
                              {"ticks_per_round", kTicks},
                              {"rounds", rounds}};
  if (json_file == "-") {
    fmt::print("{}\n", result.dump(2));
    return;
  }
  std::ofstream file(json_file);
  file << result.dump(2) << "\n";
  if (!file.flush()) throw std::runtime_error("cannot write " + json_file);
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
