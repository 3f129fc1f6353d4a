#include "bench/cost.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "analysis/with_loop.h"
#include "bench/processor_time.h"
#include "bench/report.h"
#include "scene/load_scene.h"

namespace tandem::bench {
namespace {

using core::Scene;
using nlohmann::ordered_json;

constexpr double kFrom = 4.0;  // [s] into the session: box held and carried
constexpr int kTicks = 2048;

/// Processor time of one tick of the whole session, from the same instant each call.
using Timer = std::function<double()>;

Timer timer_of(const Scene& scene) {
  return analysis::with_loop(scene, {}, [&](auto& loop) -> Timer {
    while (loop.time() < kFrom) loop.tick();
    return [start = loop]() mutable {
      auto run = start;
      const double before = core_ns();
      for (int k = 0; k < kTicks; ++k) run.tick();
      return (core_ns() - before) / kTicks;
    };
  });
}

struct Feature {
  std::string name;
  int base = -1;  ///< index of the row it is added to
  Scene scene;
  Timer time;
  std::vector<double> tick_ns{}, added_ns{};
};

Scene shipped(const std::string& name, const std::vector<std::string>& sets = {}) {
  return scene::load_scene(name, sets);
}

/// N users on a line, a copy each, every hand on every copy, as axis_distributed has it for two.
Scene mesh(int users) {
  Scene scene = shipped("axis_distributed");
  scene.users.clear();
  scene.couplers.clear();
  for (int i = 1; i <= users; ++i) {
    core::UserParameters user;
    user.name = std::to_string(i);
    user.fingers.resize(1);
    user.fingers[0].name = "a";
    scene.users.push_back(user);
  }
  for (const auto& copy : scene.users) {
    for (const auto& user : scene.users) {
      core::CouplerParameters c;
      c.name = "k" + copy.name + user.name;
      c.object = "box", c.user = user.name, c.copy = copy.name;
      c.gain = user.name == copy.name ? core::Gain{3000.0, 20.0} : core::Gain{400.0, 2.0};
      scene.couplers.push_back(c);
    }
    core::CouplerParameters c;
    c.name = "ko" + copy.name, c.object = "box", c.copy = copy.name, c.gain = {100.0, 5.0};
    scene.couplers.push_back(c);
  }
  return scene;
}

class Features {
 public:
  /// Returns the row's index.
  int add(const std::string& name, int base, const Scene& scene) {
    rows.push_back({name, base, scene, timer_of(scene)});
    return static_cast<int>(rows.size()) - 1;
  }
  /// The same with one thing more declared.
  int add(const std::string& name, int base, const std::function<void(Scene&)>& declare) {
    Scene scene = rows[static_cast<std::size_t>(base)].scene;
    declare(scene);
    return add(name, base, scene);
  }
  std::vector<Feature> rows;
};

core::DeviceParameters device_named(const std::string& name) {
  core::DeviceParameters device;
  device.name = name;
  device.max_force = 10.0;
  device.max_slew = 10240.0;
  device.encoder_step = 30e-6;
  device.velocity_cutoff_hz = 100.0;
  return device;
}

void add_axis_rows(Features& f) {
  const int one = f.add("axis: one hand on one mass", -1, shipped("axis_single"));
  f.add("a wall", one, [](Scene& s) {
    core::WallParameters wall;
    wall.name = "wall", wall.normal = {1.0, 0.0, 0.0}, wall.gain = {1000.0, 10.0};
    wall.attached = true;
    s.walls.push_back(wall);
  });
  f.add("computation delay of a tick", one, [](Scene& s) { s.rates.latency_ticks = 1; });
  f.add("device: encoder, velocity estimate, force and slew limits", one, [](Scene& s) {
    s.devices.push_back(device_named("d"));
    s.users[0].fingers[0].device = "d";
  });
  const int two = f.add("a second user, a copy at each, packets", one, mesh(2));
  f.add("compensation", two, [](Scene& s) { s.objects[0].compensation = 0.5; });
  f.add("extrapolation in place of hold", two,
        [](Scene& s) { s.reconstruction.kind = core::ReconstructionKind::kExtrapolate; });
  int last = two;
  for (const int users : {3, 4, 8}) last = f.add(fmt::format("{} users", users), last, mesh(users));
  f.add("axis: two users at a server", -1, shipped("axis_central"));
}

void add_plane_rows(Features& f) {
  Scene bare = shipped("plane_single");
  bare.contact = {};
  bare.walls.clear();
  bare.devices.clear();
  for (auto& finger : bare.users[0].fingers) finger.device.clear();
  bare.objects[0].ground_friction = bare.objects[0].ground_friction_rotation = 0.0;
  const int held = f.add("plane: two fingers attached to a box", -1, bare);
  const int touch = f.add("contact test in place of attachment", held,
                          [](Scene& s) { s.contact.attached = false; });
  const int friction = f.add("finger friction", touch, [](Scene& s) {
    s.contact.friction = {0.6, 0.6, 0.005};
  });
  const int pulses = f.add("moment cancellation", friction, [](Scene& s) {
    s.contact.moment_cancellation = true;
    s.contact.pulse_force = 10.0;
  });
  const int ground = f.add("ground friction", pulses, [](Scene& s) {
    s.objects[0].ground_friction = 0.05;
    s.objects[0].ground_friction_rotation = 0.15;
  });
  const int wall = f.add("a wall, not touched", ground,
                         [](Scene& s) { s.walls = shipped("plane_single").walls; });
  f.add("the same wall, touched", wall, [](Scene& s) { s.walls[0].point.y = 0.029; });
  f.add("devices: encoder, velocity estimate, force and slew limits", wall, [](Scene& s) {
    for (auto& finger : s.users[0].fingers) {
      finger.device = "1" + finger.name;
      s.devices.push_back(device_named(finger.device));
    }
  });
  const int two = f.add("plane: box_distributed, whole", -1, shipped("box_distributed"));
  f.add("compensation, linear and rotation", two, [](Scene& s) {
    s.objects[0].compensation = 0.88;
    s.objects[0].compensation_rotation = 0.025;
  });
  f.add("extrapolation in place of hold", two,
        [](Scene& s) { s.reconstruction.kind = core::ReconstructionKind::kExtrapolate; });
  f.add("plane: box_central, whole", -1, shipped("box_central"));
  f.add("space: space_box, whole", -1, shipped("space_box"));
}

/// What axis_single asks for, by hand: two masses and a coupler, and nothing else.
double plain_axis_ns() {
  const double T = 1.0 / 1024.0;
  volatile double kick = 0.1;  // or the compiler works it all out before
  double xh = 0.0, vh = kick, xo = 0.0, vo = 0.0;
  const double before = core_ns();
  for (int i = 0; i < kTicks; ++i) {
    const double force = 1000.0 * (xh - xo) + 10.0 * (vh - vo);
    const double ah = -force / 0.1, ao = force / 0.4;
    xh += T * (vh + 0.5 * T * ah), vh += T * ah;
    xo += T * (vo + 0.5 * T * ao), vo += T * ao;
  }
  const double took = (core_ns() - before) / kTicks;
  kick = xh + xo;
  return took;
}

/// What the program bench_lacking beside this one printed: a replica's law as shipped, and compiled
/// without each feature that its scene does not declare. Null: it is not built.
ordered_json lacking(int rounds) {
  std::error_code error;
  const auto self = std::filesystem::read_symlink("/proc/self/exe", error);
  const auto program = self.parent_path() / "bench_lacking";
  if (error || !std::filesystem::exists(program, error)) return nullptr;
  const std::string command = fmt::format("'{}' {}", program.string(), rounds);
  const std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen(command.c_str(), "r"), pclose);
  std::string said;
  std::array<char, 4096> part{};
  for (std::size_t n; pipe && (n = fread(part.data(), 1, part.size(), pipe.get())) > 0;)
    said.append(part.data(), n);
  const ordered_json json = ordered_json::parse(said, nullptr, false);
  if (json.is_discarded()) throw std::runtime_error("it printed no result: " + program.string());
  return json["rows"];
}

/// The table of `lacking`, and whether a feature that is not declared costs anything: more than two
/// compilations of the same source differ by, and more than a hundredth of the tick.
std::string undeclared(const ordered_json& rows, ordered_json& json) {
  if (rows.is_null())
    return "What a feature costs that is not declared: not measured, build the target "
           "bench_peers\n";
  std::string text = fmt::format(
      "One tick of a replica whose scene declares nothing, beside the same law compiled without a "
      "feature\n{:>10} {:>10} {:>8} {:>13} {:>8}  {}\n",
      "tick [ns]", "costs [ns]", "+- [ns]", "instructions", "costs", "not declared, left out");
  bool nothing = true;
  std::map<std::string, double> noise;  // of each space
  for (const ordered_json& row : rows) {
    const std::string lacks = row["lacks"];
    const double tick = row["tick_ns"], cost = row["cost_ns"], spread = row["spread_ns"];
    text += fmt::format("{:10.1f} {:10.1f} {:8.1f} {:13.1f} {:8.1f}  {}: {}{}\n", tick, cost,
                        spread, row["instructions"].get<double>(),
                        row["cost_instructions"].get<double>(), row["space"].get<std::string>(),
                        lacks, row["same_bits"].get<bool>() ? "" : " (OTHER BITS)");
    if (lacks == "again") noise[row["space"]] = std::abs(cost) + spread;
    nothing = nothing && row["same_bits"].get<bool>();
  }
  double most = 0.0, of = 0.0;
  std::string most_by;
  for (const ordered_json& row : rows) {
    if (row["lacks"] == "all") continue;
    const double tick = row["tick_ns"], cost = row["cost_ns"], spread = row["spread_ns"];
    if (cost - spread > std::max(noise[row["space"]], 0.01 * tick)) nothing = false;
    if (const double more = row["cost_instructions"]; more > most) {
      most = more, of = more + row["instructions"].get<double>();
      most_by = row["space"].get<std::string>() + ", " + row["lacks"].get<std::string>();
    }
  }
  json["undeclared"] = rows;
  json["undeclared_noise_ns"] = noise;
  json["undeclared_most_instructions"] = {{"by", most_by}, {"costs", most}, {"of", of}};
  json["undeclared_costs_nothing"] = nothing;
  return text +
         fmt::format(
             "`again` is the shipped law compiled once more: {:.1f} ns (axis) and {:.1f} (plane) "
             "are where code lies.\n"
             "Most instructions: {:.0f} of {:.0f} ({}). No feature that is not declared takes "
             "more\n"
             "time than that and a hundredth of the tick: {}\n",
             noise["axis"], noise["plane"], most, of, most_by, nothing ? "so it is" : "NOT SO");
}

void run(int rounds, const std::string& json_file, const std::string& csv_file) {
  Features f;
  add_axis_rows(f);
  add_plane_rows(f);
  std::vector<double> plain;
  for (int round = -2; round < rounds; ++round) {  // interleaved; two rounds to warm up
    std::vector<double> now;
    for (Feature& row : f.rows) now.push_back(row.time());
    const double by_hand = plain_axis_ns();
    if (round < 0) continue;
    plain.push_back(by_hand);
    for (std::size_t i = 0; i < now.size(); ++i) {
      f.rows[i].tick_ns.push_back(now[i]);
      if (f.rows[i].base >= 0)
        f.rows[i].added_ns.push_back(now[i] - now[static_cast<std::size_t>(f.rows[i].base)]);
    }
  }

  std::string text = fmt::format(
      "One tick of the whole session (users, hands, modelled links), processor time, medians of "
      "{}\n"
      "rounds; added: to the row it is declared on top of; +-: half the middle half of the rounds\n"
      "{:>10} {:>10} {:>8}  {}\n",
      rounds, "tick [ns]", "added [ns]", "+- [ns]", "declared");
  std::string csv = "feature,added_to,users,tick_ns,added_ns,spread_ns\n";
  ordered_json json;
  json["rows"] = ordered_json::array();
  double axis = 0.0, plane = 0.0;
  for (Feature& row : f.rows) {
    const double tick = median(row.tick_ns);
    if (row.name.starts_with("axis: one")) axis = tick;
    if (row.name.starts_with("plane: two")) plane = tick;
    ordered_json one;
    one["feature"] = row.name;
    one["users"] = row.scene.users.size();
    one["tick_ns"] = tick;
    if (row.base < 0) {
      one["added_to"] = nullptr;
      one["added_ns"] = nullptr;
      text += fmt::format("{:10.1f} {:>10} {:>8}  {}\n", tick, "", "", row.name);
      csv += fmt::format("\"{}\",,{},{},,\n", row.name, row.scene.users.size(), tick);
    } else {
      const std::string& base = f.rows[static_cast<std::size_t>(row.base)].name;
      std::vector<double>& d = row.added_ns;
      const double added = median(d);
      std::sort(d.begin(), d.end());
      const double spread = 0.5 * (d[3 * d.size() / 4] - d[d.size() / 4]);
      one["added_to"] = base;
      one["added_ns"] = added;
      one["spread_ns"] = spread;
      text += fmt::format("{:10.1f} {:10.1f} {:8.1f}    + {}\n", tick, added, spread, row.name);
      csv += fmt::format("\"{}\",\"{}\",{},{},{},{}\n", row.name, base, row.scene.users.size(),
                         tick, added, spread);
    }
    json["rows"].push_back(one);
  }
  const double by_hand = median(plain);
  json["plain_axis_ns"] = by_hand;
  json["axis_over_plain"] = axis / by_hand;
  json["axis_below_plane"] = axis < plane;
  text += fmt::format(
      "{:10.1f} {:>10} {:>8}  two masses and a coupler in plain doubles: the axis scene takes "
      "{:.1f}\n"
      "                                times that, for hand, packets' slots, faults and outputs\n"
      "An axis tick costs {:.2f} of a planar one.\n",
      by_hand, "", "", axis / by_hand, axis / plane);
  text += undeclared(lacking(rounds), json);
  write_csv(csv_file, csv);
  report(json_file, text, json);
}

}  // namespace

void add_bench_cost(CLI::App& bench) {
  struct Options {
    int rounds = 25;
    std::string json, csv;
  };
  auto o = std::make_shared<Options>();
  CLI::App* command =
      bench.add_subcommand("cost", "what each declared feature of a scene adds to a tick [ns]");
  command->add_option("--rounds", o->rounds, "interleaved rounds")
      ->check(CLI::Range(3, 10000))
      ->capture_default_str();
  command->add_option("--json", o->json, "write the figures here; - prints JSON only");
  command->add_option("--csv", o->csv, "write the table here");
  command->callback([o] { run(o->rounds, o->json, o->csv); });
}

}  // namespace tandem::bench
