#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <ctime>

#include <fmt/format.h>

#include "analysis/drag.h"
#include "analysis/experiments.h"
#include "analysis/growth.h"
#include "analysis/linearised_grasp.h"
#include "analysis/with_loop.h"
#include "cli/commands.h"
#include "cli/link_options.h"
#include "cli/options.h"
#include "cli/picture.h"
#include "scene/load_scene.h"

namespace tandem::cli {

namespace {

using nlohmann::ordered_json;

struct SimulateOptions {
  SceneOption scene;
  JsonOption json;
  std::string experiment, csv, picture;
  double seconds = 20.0;
  double delay_packets = 0.0;
  LinkOptions link;
  double duplicate = 0.0;
  std::uint64_t seed = 1;
  bool no_growth = false;
};

/// What does not fit in a modelled link would be dropped silently, all of it.
void demand_room_in_flight(const SimulateOptions& o, const core::Scene& scene) {
  constexpr double kRoom = 60.0;  // packets; a link holds 64
  const double longest_s = 1e-3 * (o.link.delay_ms + 2.0 * o.link.jitter_ms);
  const double in_flight = longest_s * scene.rates.packet_hz;
  if (in_flight <= kRoom) return;
  throw CLI::ValidationError(
      "--link-delay-ms",
      fmt::format(
          "delay {:g} ms and twice the jitter {:g} ms keep {:.0f} packets in flight at {:g} "
          "packets a second; a modelled link holds {:.0f}: together at most {:.0f} ms, or "
          "lower rates.packet_hz",
          o.link.delay_ms, o.link.jitter_ms, in_flight, scene.rates.packet_hz, kRoom,
          std::floor(1e3 * kRoom / scene.rates.packet_hz)));
}

core::NetworkModel network_of(const SimulateOptions& o, const core::Scene& scene) {
  demand_room_in_flight(o, scene);
  core::LinkModelParameters link = o.link.model(scene.rates.local_hz);
  link.duplicate = o.duplicate;
  link.seed = o.seed;
  core::NetworkModel network;
  network.set_all(link);
  if (o.delay_packets > 0.0) network.set_round_trip(o.delay_packets, scene.ticks_per_packet());
  return network;
}

/// The same network with its delays alone: growth and drag are those of a steady map.
core::NetworkModel delays_only(core::NetworkModel network) {
  for (auto& row : network.link)
    for (core::LinkModelParameters& link : row) {
      core::LinkModelParameters steady;
      steady.delay_ticks = link.delay_ticks;
      link = steady;
    }
  return network;
}

/// Position of an object for people and files: x, or x, y, angle.
std::vector<double> pose(const core::AxisState& b) { return {b.p}; }
std::vector<double> pose(const core::PlaneBody& b) { return {b.p.x, b.p.y, b.angle}; }
std::vector<double> pose(const core::SpaceBody& b) {
  return {b.p.x, b.p.y, b.p.z, b.q.w, b.q.x, b.q.y, b.q.z};
}
double distance(const core::AxisState& a, const core::AxisState& b) { return std::abs(a.p - b.p); }
template <typename Body>
double distance(const Body& a, const Body& b) {
  const auto d = a.p - b.p;
  return std::sqrt(core::inner(d, d));
}

/// Processor time of this thread: seconds on one core, whatever else the machine is doing [s].
double core_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

struct Run {
  double wall_s = 0.0;
  double speedup = 0.0;  ///< virtual time over time on one core, median of the run's parts
  double gap_rms = 0.0, gap_max = 0.0;  ///< between the copies of the first object [m]
  std::int64_t sent = 0, accepted = 0;
  std::vector<std::vector<double>> poses;  ///< first object at each user
  analysis::Table trajectory;
};

template <typename Loop>
double widest_gap(const Loop& loop) {
  double widest = 0.0;
  for (int i = 1; i < loop.user_count(); ++i)
    widest = std::max(widest, distance(loop.object(0, 0), loop.object(i, 0)));
  return widest;
}

/// Runs the session for its own sake: first as fast as it goes and timed, then, if wanted, once
/// more from the start with everything written down.
template <typename Loop>
Run run_session(const Loop& start, double seconds, bool record, bool has_object) {
  Run run;
  {
    // In parts, and the median of their speeds: other programs on the machine come and go.
    constexpr int kParts = 15;
    std::vector<double> speeds;
    Loop loop = start;
    for (int part = 1; part <= kParts; ++part) {
      const double from = loop.time();
      const auto before = std::chrono::steady_clock::now();
      const double core_before = core_seconds();
      while (loop.time() < seconds * part / kParts) loop.advance_packet_period();
      if (loop.time() > from)
        speeds.push_back((loop.time() - from) / (core_seconds() - core_before));
      run.wall_s +=
          std::chrono::duration<double>(std::chrono::steady_clock::now() - before).count();
    }
    std::nth_element(speeds.begin(), speeds.begin() + speeds.size() / 2, speeds.end());
    run.speedup = speeds[speeds.size() / 2];
    run.sent = loop.packets_sent();
    run.accepted = loop.packets_accepted();
    if (has_object)
      for (int u = 0; u < loop.user_count(); ++u) run.poses.push_back(pose(loop.object(u, 0)));
  }
  Loop loop = start;
  double sum = 0.0;
  std::int64_t n = 0;
  run.trajectory.columns = {"t_s"};
  for (int u = 0; u < loop.user_count(); ++u) {
    const std::string user = "user" + std::to_string(u + 1);
    if (has_object) {
      const std::size_t width = pose(loop.object(u, 0)).size();
      const char* const plane[] = {"x", "y", "angle"};
      const char* const space[] = {"x", "y", "z", "qw", "qx", "qy", "qz"};
      for (std::size_t i = 0; i < width; ++i)
        run.trajectory.columns.push_back(user + "_object_" + (width <= 3 ? plane[i] : space[i]));
    }
    for (int f = 0; f < loop.hands().count(u); ++f)
      for (const char* what : {"p", "f"})
        for (int i = 0; i < core::kComponents<typename Loop::Vector>; ++i)
          run.trajectory.columns.push_back(user + "_finger" + std::to_string(f) + "_" + what +
                                           "xyz"[i]);
  }
  while (loop.time() < seconds) {
    loop.advance_packet_period();
    if (has_object) {
      const double gap = widest_gap(loop);
      sum += gap * gap;
      ++n;
      run.gap_max = std::max(run.gap_max, gap);
    }
    if (!record) continue;
    std::vector<double> row{loop.time()};
    for (int u = 0; u < loop.user_count(); ++u) {
      if (has_object)
        for (const double x : pose(loop.object(u, 0))) row.push_back(x);
      for (int f = 0; f < loop.hands().count(u); ++f)
        for (const auto& v : {loop.hands().finger(u, f).position(), loop.output(u).forces[f]})
          for (int i = 0; i < core::kComponents<typename Loop::Vector>; ++i)
            row.push_back(core::component(v, i));
    }
    run.trajectory.rows.push_back(std::move(row));
  }
  if (n > 0) run.gap_rms = std::sqrt(sum / static_cast<double>(n));
  return run;
}

/// Growth slower than that of a free drift cannot be told from it (drift_growth). Decay by 1e-6 a
/// period takes half a percent off over the fitted periods: the phase of a slow swing does as much.
const char* verdict(double growth, double drift) {
  if (!std::isfinite(growth)) return "not stable, one period leaves all numbers";
  if (growth < 1.0 - 1e-6) return "stable";
  return growth > drift ? "not stable" : "free motion goes on, neither grows nor dies out";
}

void simulate_scene(const SimulateOptions& o) {
  const core::Scene scene = o.scene.load();
  const core::NetworkModel network = network_of(o, scene);
  const core::NetworkModel steady = delays_only(network);
  const bool has_object = !scene.objects.empty();
  const Run run = analysis::with_loop(scene, network, [&](auto& loop) {
    return run_session(loop, o.seconds, !o.csv.empty() || !o.picture.empty(), has_object);
  });

  ordered_json json;
  json["scene"] = scene.name;
  json["hash"] = fmt::format("{:016x}", scene::shared_hash(scene));
  json["users"] = scene.users.size();
  json["delay_packets"] = o.delay_packets;
  json["seconds"] = o.seconds;
  json["wall_s"] = run.wall_s;
  json["speedup"] = run.speedup;
  json["packets"] = {{"sent", run.sent}, {"accepted", run.accepted}};
  json["replica_gap_m"] = {{"rms", number(run.gap_rms)}, {"max", number(run.gap_max)}};
  json["object_pose"] = ordered_json::array();
  for (const auto& p : run.poses) {
    ordered_json values = ordered_json::array();
    for (const double x : p) values.push_back(number(x));
    json["object_pose"].push_back(values);
  }

  std::string text = fmt::format("{}: {:.6g} s in {:.3g} s; {:.0f} times real time on one core\n",
                                 scene.name, o.seconds, run.wall_s, run.speedup);
  text += fmt::format("  packets sent {}, accepted {}", run.sent, run.accepted);
  text += analysis::is_central(scene)
              ? "\n"
              : fmt::format("; gap between copies rms {:.3g} m, max {:.3g} m\n", run.gap_rms,
                            run.gap_max);

  const std::int64_t repeat = scene.packet_slots().packets;
  const bool can_grow = has_object && scene.space != core::Space::kSpace && !o.no_growth &&
                        repeat <= analysis::kMostPackets;
  if (repeat > analysis::kMostPackets && !o.no_growth)
    text += fmt::format(
        "  growth is not measured: packet ticks repeat only after {} packets; choose rates with a "
        "simpler ratio\n",
        repeat);
  if (can_grow) {
    const core::Scene linear = analysis::linearised_at_grasp(scene);
    analysis::GrowthOptions options;
    options.seed = o.seed;
    if (scene.space != core::Space::kAxis) options.amplitude = 1e-6;
    const analysis::Growth growth = analysis::measure_growth(linear, steady, options);
    json["growth_per_packet"] = number(growth.per_packet);
    json["growth_is"] = std::isfinite(growth.per_packet) ? "measured" : "beyond all numbers";
    json["states"] = growth.states;
    json["removed"] = growth.removed;
    text += fmt::format("  growth per packet period {:.7f} ({}){}\n", growth.per_packet,
                        verdict(growth.per_packet, analysis::drift_growth(options)),
                        scene.space == core::Space::kAxis
                            ? ""
                            : ", linearised at the grasp: fingers attached, no ground friction");
  } else {
    json["growth_per_packet"] = nullptr;
    json["growth_is"] = o.no_growth   ? "not measured: --no-growth"
                        : !has_object ? "not measured: no object"
                                      : "not measured: only axis and planar scenes are linearised";
  }

  if (has_object && scene.space == core::Space::kAxis) {
    const int user = analysis::drag_user(scene);
    const core::Scene alone = analysis::with_one_hand(scene, scene.users[user].name);
    const analysis::Drag drag = analysis::measure_drag(alone, steady, user);
    json["drag_n_s_per_m"] = drag.n_s_per_m ? number(*drag.n_s_per_m) : nullptr;
    json["drag_user"] = scene.users[user].name;
    json["drag_motion_prescribed"] = drag.prescribed;
    if (drag.n_s_per_m)
      text +=
          fmt::format("  drag felt by user {} in free motion {:.10f} N s/m{}\n",
                      scene.users[user].name, *drag.n_s_per_m,
                      drag.prescribed ? " (motion prescribed: no steady state under force)" : "");
    else
      text += fmt::format("  drag felt by user {}: no steady state\n", scene.users[user].name);
  }

  if (!o.csv.empty()) write_text(o.csv, to_csv(run.trajectory));
  if (!o.picture.empty()) draw(o.picture, "trajectory", run.trajectory);
  if (!o.json.to_stdout()) fmt::print("{}", text);
  o.json.write(json);
}

ordered_json columns_of(const analysis::Table& table) {
  ordered_json out;
  for (std::size_t c = 0; c < table.columns.size(); ++c) {
    ordered_json column = ordered_json::array();
    for (const auto& row : table.rows) column.push_back(number(row[c]));
    out[table.columns[c]] = std::move(column);
  }
  return out;
}

double root_mean_square(const analysis::Table& table, std::size_t column) {
  double sum = 0.0;
  for (const auto& row : table.rows) sum += row[column] * row[column];
  return std::sqrt(sum / static_cast<double>(table.rows.size()));
}

void run_experiment(const SimulateOptions& o) {
  const analysis::SceneSource scenes = [&](const std::string& name,
                                           const std::vector<std::string>& sets) {
    std::vector<std::string> all = sets;
    all.insert(all.end(), o.scene.sets.begin(), o.scene.sets.end());
    return scene::load_scene(name, all);
  };
  ordered_json json;
  std::string text;
  std::vector<std::pair<std::string, analysis::Table>> tables;
  if (o.experiment == "fig8.1") {
    const auto r = analysis::run_fig_8_1(scenes);
    json["central_growth_per_packet"] = number(r.central_growth_per_packet);
    json["distributed_growth_per_packet"] = number(r.distributed_growth_per_packet);
    json["contact_force_rms_n"] = {
        {"central_user2_a_x", root_mean_square(r.central_run, 8)},
        {"distributed_user2_a_x", root_mean_square(r.distributed_run, 8)}};
    text = fmt::format(
        "Fig 8.1, round trip one packet period, linearised at the grasp\n"
        "  centralized, Table 8.1:  grows {:.5f} times a packet period ({})\n"
        "  distributed, Table 8.2:  grows {:.5f} times a packet period ({})\n"
        "The thesis says the first is unstable and the second can be used. Masses and size of the\n"
        "box are ours (see box_distributed.scene): the thesis gives none.\n",
        r.central_growth_per_packet, r.central_growth_per_packet < 1 ? "stable" : "not stable",
        r.distributed_growth_per_packet,
        r.distributed_growth_per_packet < 1 ? "stable" : "not stable");
    tables = {{"fig8.1_central", r.central_run}, {"fig8.1_distributed", r.distributed_run}};
  } else if (o.experiment == "fig8.3") {
    const auto r = analysis::run_fig_8_3(scenes);
    json["net_force_rms_n"] = {{"ideal", r.ideal},
                               {"hold", r.hold},
                               {"compensated", r.compensated},
                               {"extrapolated", r.extrapolated},
                               {"central_local", r.central_local}};
    text = fmt::format(
        "Fig 8.3, net force on the user's own copy along 0.05 sin(2 t) m, RMS over four cycles\n"
        "  ideal m a               {:.4f} N\n  hold                    {:.4f} N\n"
        "  hold, compensated       {:.4f} N   (0.88 N s/m, 0.025 N m s/rad)\n"
        "  extrapolated            {:.4f} N\n  centralized, local user {:.4f} N\n"
        "The thesis reports a noticeably larger force without compensation and a significant\n"
        "improvement with 0.88 N s/m. 0.88 fits N = 2, not the N = 8 of the experiment, so here "
        "it\n"
        "gives back only part of the drag. Ground friction is left out: it would bury m a.\n",
        r.ideal, r.hold, r.compensated, r.extrapolated, r.central_local);
    tables = {{"fig8.3", r.forces}};
  } else {
    const auto r = analysis::run_fig_8_4(scenes);
    json["penetration_m"] = {{"central_local", r.central_local},
                             {"central_remote", r.central_remote},
                             {"distributed", r.distributed}};
    text = fmt::format(
        "Fig 8.4, peak travel of the finger while it presses the box against the wall\n"
        "  centralized, local user    {:.3f} mm\n  centralized, remote user   {:.3f} mm   "
        "(reduced gains 170/3, 270/5)\n  distributed                {:.3f} mm\n"
        "The thesis pushes with 1.5 sin 3t; a free finger would fly off in the negative half, so\n"
        "only the positive half pushes, and a damper of 2 N s/m stands for the person.\n",
        1e3 * r.central_local, 1e3 * r.central_remote, 1e3 * r.distributed);
    tables = {{"fig8.4", r.travel}};
  }
  json["experiment"] = o.experiment;
  for (const auto& [name, table] : tables) {
    if (!o.csv.empty())
      write_text(tables.size() == 1 ? o.csv : with_suffix(o.csv, name), to_csv(table));
    if (!o.picture.empty())
      draw(tables.size() == 1 ? o.picture : with_suffix(o.picture, name), name, table);
  }
  if (o.json.wanted()) {
    ordered_json series;
    for (const auto& [name, table] : tables) series[name] = columns_of(table);
    json["series"] = std::move(series);
  }
  if (!o.json.to_stdout()) fmt::print("{}", text);
  o.json.write(json);
}

}  // namespace

void add_simulate(CLI::App& app) {
  auto o = std::make_shared<SimulateOptions>();
  CLI::App* command = app.add_subcommand(
      "simulate",
      "run a scene in virtual time, as fast as the processor goes; never refuses an unstable one");
  o->scene.add(*command, "box_distributed");
  o->json.add(*command);
  CLI::Option* experiment =
      command
          ->add_option("--experiment", o->experiment,
                       "a figure of the thesis instead of a scene, over its own network")
          ->check(CLI::IsMember({"fig8.1", "fig8.3", "fig8.4"}));
  command->add_option("--seconds", o->seconds, "virtual time [s]")
      ->check(between(0.001, 1e6))
      ->capture_default_str();
  command
      ->add_option("--delay-packets", o->delay_packets,
                   "round trip in packet periods, all on link 1 to 2 (central: on the force)")
      ->check(between(0.0, 60.0))
      ->capture_default_str();
  o->link.add(*command);
  command->add_option("--duplicate", o->duplicate, "share of packets doubled")
      ->check(between(0.0, 1.0));
  command->add_option("--seed", o->seed, "of the network's fates and of the random state")
      ->check(seed_number, "", "seed");
  command->add_flag("--no-growth", o->no_growth, "leave out the growth measurement");
  command->add_option("--csv", o->csv, "trajectory, one row a packet period")
      ->check(writable_file, "", "writable");
  command->add_option("--picture", o->picture, "draw it: .png or .svg (needs python3-matplotlib)")
      ->check(picture_file, "", "a picture");
  for (const char* own : {"--scene", "--seconds", "--delay-packets", "--link-delay-ms",
                          "--jitter-ms", "--jitter-kind", "--loss", "--duplicate", "--burst-enter",
                          "--burst-leave", "--fifo", "--seed", "--no-growth"})
    experiment->excludes(command->get_option(own));
  command->callback([o] { o->experiment.empty() ? simulate_scene(*o) : run_experiment(*o); });
}

}  // namespace tandem::cli
