#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <memory>
#include <optional>
#include <thread>
#include <unistd.h>
#include <utility>

#include <fmt/format.h>

#include "bench/cyclictest.h"
#include "cli/commands.h"
#include "cli/demo_nodes.h"
#include "cli/demo_script.h"
#include "cli/demo_trace.h"
#include "cli/options.h"
#include "cli/picture.h"
#include "cli/script_path.h"
#include "core/clock.h"
#include "devices/load_recorded_path.h"
#include "harness/node_plan.h"
#include "scene/load_scene.h"

namespace tandem::cli {

namespace {

using nlohmann::ordered_json;

/// What section 8.2 of the thesis adds to each copy: linear [N s/m], rotation [N m s/rad].
constexpr double kThesisCompensation = 0.88, kThesisCompensationRotation = 0.025;

struct DemoArguments {
  std::string arch, scene, hands = "simulated", hand_file, hand_columns;
  std::vector<std::string> sets;
  double seconds = 20.0;
  bool compensation = false, no_cyclictest = false, no_view = false;
  int priority = 80;
  std::string reconstruction, on_unstable = "refuse";
  std::string out = "tandem-demo", picture;
  JsonOption json;
};

/// One session of the demo and what is known of it afterwards.
struct Session {
  std::string key;  ///< "central", "distributed", "compensated"
  core::Scene scene;
  ScriptTimes times;
  int rounds = 1;
  std::vector<DemoNode> nodes;
  std::vector<DemoTrace> traces;
  Command command;
  DemoFigures figures;
  /// Net force RMS in virtual time [N]: as it is, compensated, extrapolated; recorded hands: none.
  std::optional<double> virtual_plain, virtual_compensated, virtual_extrapolated;
  bench::CyclictestRun cyclictest;
};

void compensate(core::Scene& scene, bool on) {
  for (core::ObjectParameters& object : scene.objects) {
    object.compensation = on ? kThesisCompensation : 0.0;
    object.compensation_rotation = on ? kThesisCompensationRotation : 0.0;
  }
}

core::Scene scene_of(const DemoArguments& a, const std::string& key) {
  const std::string name = !a.scene.empty()   ? a.scene
                           : key == "central" ? "box_central"
                                              : "box_distributed";
  core::Scene scene = scene::load_scene(name, a.sets);
  if (key == "compensated" || a.compensation) compensate(scene, true);
  if (a.reconstruction == "hold") scene.reconstruction.kind = core::ReconstructionKind::kHold;
  if (a.reconstruction == "extrapolate")
    scene.reconstruction.kind = core::ReconstructionKind::kExtrapolate;
  return scene;
}

/// Displacement of the recorded hand along the carry, as the led fingers follow it.
Command recorded_command(const DemoArguments& a, const Session& s) {
  const devices::RecordedPath path =
      devices::load_recorded_path(a.hand_file, devices::parse_column_mapping(a.hand_columns));
  const core::Vec3 first = path.at(0.0).position;
  Command command(static_cast<std::size_t>(std::llround(a.seconds * s.scene.rates.local_hz)), 0.0);
  for (std::size_t k = 0; k < command.size(); ++k) {
    const double t = static_cast<double>(k) * s.scene.tick() - s.times.carry_start;
    if (t >= 0.0) command[k] = glm::dot(path.at(t).position - first, s.times.direction);
  }
  return command;
}

void prepare(const DemoArguments& a, Session& s) {
  s.scene = scene_of(a, s.key);
  const bool central = s.scene.architecture == core::Architecture::kCentral ||
                       s.scene.architecture == core::Architecture::kSingle;
  if (central != (s.key == "central"))
    throw CLI::ValidationError("--arch", s.key + ", but scene " + s.scene.name + " is " +
                                             (central ? "a central one" : "a distributed one"));
  if (s.scene.objects.empty())
    throw CLI::ValidationError("--scene", "scene " + s.scene.name + " has no object to carry");
  if (a.hands == "recorded") {
    const ScriptTimes times = script_times(s.scene);
    leave_carry_to_recording(s.scene, a.seconds);
    s.times = times;
    s.times.carry_end += a.seconds - times.length;
    s.command = recorded_command(a, s);
  } else {
    s.rounds = fit_script(s.scene, a.seconds);
    s.times = script_times(s.scene);
    s.command = scripted_command(s.scene, a.seconds);
  }
}

std::string view_picture(const DemoArguments& a, const Session& s) {
  return a.out + "/" + s.key + "_view.png";
}

DemoRun run_of(const DemoArguments& a, const Session& s) {
  DemoRun run;
  run.scene = s.scene;
  run.folder = a.out;
  run.prefix = s.key;
  run.scene_file = a.out + "/" + s.key + ".scene";
  run.seconds = a.seconds;
  if (!a.no_view) run.view_picture = view_picture(a, s);
  if (a.hands == "recorded")
    run.node_arguments = {"--hands",        "recorded",     "--hand-file",
                          a.hand_file,      "--hand-after", fmt::format("{}", s.times.carry_start),
                          "--hand-columns", a.hand_columns};
  run.node_arguments.insert(run.node_arguments.end(), {"--priority", std::to_string(a.priority),
                                                       "--on-unstable", a.on_unstable});
  return run;
}

/// Runs the session and reads what its nodes recorded.
void perform(const DemoArguments& a, Session& s) {
  std::fprintf(
      stderr, "-- %s: scene %s for %g s%s\n", s.key.c_str(), s.scene.name.c_str(), a.seconds,
      s.rounds > 1 ? fmt::format(", {} rounds of the hands' script", s.rounds).c_str() : "");
  DemoRun run = run_of(a, s);
  std::error_code none_before;
  std::filesystem::remove(view_picture(a, s), none_before);
  // Time to load the scene, lock memory and meet.
  constexpr std::int64_t kTimeToStart_ns = 2'000'000'000;
  run.start_ns = core::monotonic_ns() + kTimeToStart_ns;
  std::jthread beside;
  if (!a.no_cyclictest && a.priority > 0)
    beside = std::jthread([&](const std::stop_token& stop) {
      while (!stop.stop_requested() && core::monotonic_ns() < run.start_ns)
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
      // As many threads as force loops, with their priority and period, while they run.
      s.cyclictest =
          bench::run_cyclictest({.priority = a.priority,
                                 .interval_us = std::lround(1e6 * s.scene.tick()),
                                 .wakeups = std::lround(a.seconds * s.scene.rates.local_hz),
                                 .threads = harness::node_count(s.scene),
                                 .nanoseconds = false},
                                stop);
    });
  s.nodes = run_nodes(run);
  if (beside.joinable()) beside.join();
  std::vector<const DemoTrace*> copies;
  std::vector<std::string> names;
  for (const DemoNode& node : s.nodes)
    s.traces.push_back(trace_recording(node.recording, a.seconds));
  for (std::size_t i = 0; i < s.nodes.size(); ++i) {
    if (s.nodes[i].name.starts_with("client")) continue;  // has no copy of its own
    copies.push_back(&s.traces[i]);
    names.push_back(s.nodes[i].user == "server" ? "server" : "user" + s.nodes[i].user);
  }
  s.figures = demo_figures(s.scene, s.times, copies, s.command);
  const std::string csv = a.out + "/" + s.key + ".csv";
  write_text(csv, to_csv(demo_table(s.scene, s.times, copies, names, s.command)));
  if (a.hands != "recorded") {
    const auto in_virtual_time = [&](bool compensated, core::ReconstructionKind kind) {
      core::Scene scene = s.scene;
      compensate(scene, compensated);
      scene.reconstruction.kind = kind;
      const auto traces = trace_in_virtual_time(scene, a.seconds);
      std::vector<const DemoTrace*> all;
      for (const DemoTrace& t : traces) all.push_back(&t);
      return demo_figures(scene, s.times, all, s.command).net_force_rms;
    };
    s.virtual_plain = in_virtual_time(false, core::ReconstructionKind::kHold);
    s.virtual_compensated = in_virtual_time(true, core::ReconstructionKind::kHold);
    s.virtual_extrapolated = in_virtual_time(false, core::ReconstructionKind::kExtrapolate);
  }
}

template <typename Number>
Number sum_of(const Session& s, const char* key) {
  Number sum = 0;
  for (const DemoNode& node : s.nodes)
    if (node.report.contains(key) && node.report[key].is_number())
      sum += node.report[key].get<Number>();
  return sum;
}

std::string why_no_cyclictest(const Session& s) {
  return s.cyclictest.why_not.empty() ? "not asked for" : s.cyclictest.why_not;
}

/// The demand on missed ticks: not more than cyclictest's threads missed beside the loops, and
/// 0.01 % of the slots.
struct Punctuality {
  std::int64_t missed = 0, allowed = 0;
  [[nodiscard]] bool met() const { return missed <= allowed; }
};
std::optional<Punctuality> punctuality(const Session& s) {
  if (!s.cyclictest.lateness) return std::nullopt;
  constexpr double kOfAll = 1e-4;
  Punctuality p;
  p.missed = sum_of<std::int64_t>(s, "missed_ticks");
  const auto slots = static_cast<double>(p.missed + sum_of<std::int64_t>(s, "ticks"));
  p.allowed = s.cyclictest.periods_missed + std::llround(std::floor(kOfAll * slots));
  return p;
}

ordered_json json_of(const DemoArguments& a, const Session& s) {
  ordered_json j;
  const DemoFigures& f = s.figures;
  // Every pair of sites that talk sends one packet each way in every packet period.
  std::int64_t directions = 0;
  for (const DemoNode& node : s.nodes)
    directions += static_cast<std::int64_t>(node.report["peers"].size());
  j["scene"] = s.scene.name;
  j["seconds"] = a.seconds;
  j["rounds"] = s.rounds;
  j["hands"] = a.hands;
  j["packets"] = {
      {"demanded",
       static_cast<std::int64_t>(std::llround(a.seconds * s.scene.rates.packet_hz)) * directions},
      {"sent", sum_of<std::int64_t>(s, "packets_sent")},
      {"received", sum_of<std::int64_t>(s, "packets_received")}};
  j["box_travel_m"] = {{"measured", f.travel_measured}, {"commanded", f.travel_commanded}};
  j["sequence_errors"] = sum_of<std::int64_t>(s, "sequence_errors");
  j["replica_gap_after_release_m"] = f.gap_after_release;
  j["replica_gap_in_carry_max_m"] = f.gap_in_carry_max;
  j["missed_ticks"] = sum_of<std::int64_t>(s, "missed_ticks");
  j["late_wakeups"] = sum_of<std::int64_t>(s, "late_wakeups");
  const auto demand = punctuality(s);
  j["cyclictest_late"] = demand ? ordered_json(s.cyclictest.periods_missed) : nullptr;
  j["cyclictest_late_wakeups"] = demand ? ordered_json(s.cyclictest.late_wakeups) : nullptr;
  j["missed_ticks_allowed"] = demand ? ordered_json(demand->allowed) : nullptr;
  j["missed_ticks_within_allowed"] = demand ? ordered_json(demand->met()) : nullptr;
  if (demand)
    j["cyclictest"] = s.cyclictest.command;
  else
    j["cyclictest_why_not"] = why_no_cyclictest(s);
  j["allocations_in_force_loop"] = sum_of<std::int64_t>(s, "allocations_in_force_loop");
  j["net_force_rms_n"] = {
      {"measured", number(f.net_force_rms)},
      {"inertial", number(f.inertial_force_rms)},
      {"virtual_uncompensated", s.virtual_plain ? number(*s.virtual_plain) : nullptr},
      {"virtual_compensated", s.virtual_compensated ? number(*s.virtual_compensated) : nullptr},
      {"virtual_extrapolated", s.virtual_extrapolated ? number(*s.virtual_extrapolated) : nullptr}};
  j["compensation"] = {{"linear", s.scene.objects.front().compensation},
                       {"rotation", s.scene.objects.front().compensation_rotation}};
  j["nodes"] = ordered_json::object();
  for (const DemoNode& node : s.nodes) j["nodes"][node.name] = node.report;
  return j;
}

std::string table_of(const std::vector<Session>& sessions) {
  std::string text =
      fmt::format("\n{:<26}{:>9}{:>22}{:>8}{:>18}{:>8}{:>9}{:>9}\n", "node", "loop Hz",
                  "woke p50/99/99.9 us", "missed", "packets out/in", "loss %", "rtt us", "alloc");
  for (const Session& s : sessions)
    for (const DemoNode& node : s.nodes) {
      const ordered_json& r = node.report;
      double loss = 0.0, rtt = 0.0;
      for (const ordered_json& peer : r["peers"]) {
        loss = std::max(loss, 100.0 * peer["loss"].get<double>());
        rtt = std::max(rtt, peer["rtt_us"]["p50"].get<double>());
      }
      const ordered_json& w = r["wakeup_us"];
      text += fmt::format("{:<26}{:>9.2f}{:>22}{:>8}{:>18}{:>8.3f}{:>9.0f}{:>9}\n",
                          s.key + " " + node.name, r["loop_hz"].get<double>(),
                          fmt::format("{:.1f}/{:.1f}/{:.1f}", w["p50"].get<double>(),
                                      w["p99"].get<double>(), w["p99.9"].get<double>()),
                          r["missed_ticks"].get<std::int64_t>(),
                          fmt::format("{}/{}", r["packets_sent"].get<std::int64_t>(),
                                      r["packets_received"].get<std::int64_t>()),
                          loss, rtt, r["allocations_in_force_loop"].dump());
    }
  text += fmt::format("\n{:<26}{:>14}{:>14}{:>14}{:>14}{:>14}\n", "session", "travel mm",
                      "commanded mm", "gap mm", "net force N", "ideal m a N");
  for (const Session& s : sessions) {
    const DemoFigures& f = s.figures;
    text += fmt::format("{:<26}{:>14.2f}{:>14.2f}{:>14.3f}{:>14.4f}{:>14.4f}\n",
                        s.key + (s.scene.objects.front().compensation > 0.0 ? " *" : ""),
                        1e3 * f.travel_measured, 1e3 * f.travel_commanded,
                        1e3 * f.gap_after_release, f.net_force_rms, f.inertial_force_rms);
  }
  text +=
      "  woke: how late after a tick was due; missed: ticks that did not run; alloc: memory taken "
      "in\n"
      "  the force loop\n"
      "  travel: peak to peak in the carry; gap: of the copies' centres after the release;\n"
      "  net force: RMS of all hands along the carry less ground friction; ideal: mass times the\n"
      "  acceleration of the box as it moved (nan: it did not); * with 0.88 N s/m and 0.025 N m "
      "s/rad of negative\n"
      "  damping (thesis 8.2)\n";
  for (const Session& s : sessions) {
    if (s.virtual_plain)
      text += fmt::format(
          "  {}: the same carry in virtual time: {:.4f} N without compensation, {:.4f} N with it, "
          "{:.4f} N with extrapolation instead\n",
          s.key, *s.virtual_plain, *s.virtual_compensated, *s.virtual_extrapolated);
  }
  for (const Session& s : sessions) {
    if (const auto demand = punctuality(s))
      text += fmt::format(
          "  {}: {} force loops missed {} ticks in {} late wake-ups; as many threads of cyclictest "
          "beside\n  them missed {} in {}; allowed: these and 0.01 % of all ticks, {}: {}\n",
          s.key, s.nodes.size(), demand->missed, sum_of<std::int64_t>(s, "late_wakeups"),
          s.cyclictest.periods_missed, s.cyclictest.late_wakeups, demand->allowed,
          demand->met() ? "met" : "NOT met");
    else
      text += fmt::format("  {}: missed ticks not compared with cyclictest: {}\n", s.key,
                          why_no_cyclictest(s));
  }
  return text;
}

void demo(const DemoArguments& a) {
  if (a.hands == "recorded" && a.hand_file.empty())
    throw CLI::ValidationError("--hands recorded", "needs --hand-file FILE to play");
  std::error_code no_folder;
  std::filesystem::create_directories(a.out, no_folder);
  if (no_folder || access(a.out.c_str(), W_OK) != 0)
    throw CLI::ValidationError(
        "--out", "cannot write in folder " + a.out + ": " +
                     (no_folder ? no_folder.message() : std::string(std::strerror(errno))) +
                     "; choose one that is yours");
  for (const auto& [option, file] :
       {std::pair{"--json", a.json.file}, std::pair{"--picture", a.picture}})
    if (const std::string why = file.empty() ? "" : writable_file(file); !why.empty())
      throw CLI::ValidationError(option, why);
  if (!a.scene.empty() && a.arch.empty())
    throw CLI::ValidationError("--scene", "needs --arch central or --arch distributed");
  std::vector<Session> sessions;
  if (a.arch.empty() || a.arch == "central") sessions.emplace_back().key = "central";
  if (a.arch.empty() || a.arch == "distributed") sessions.emplace_back().key = "distributed";
  if (a.arch.empty() && !a.compensation) sessions.emplace_back().key = "compensated";
  for (Session& s : sessions) prepare(a, s);
  for (Session& s : sessions) perform(a, s);

  if (!a.json.to_stdout()) std::fputs(table_of(sessions).c_str(), stdout);
  std::vector<std::string> drawing{a.picture.empty() ? a.out + "/demo.png" : a.picture};
  for (const Session& s : sessions) drawing.push_back(a.out + "/" + s.key + ".csv");
  const int drawn = run_script("plot_demo.py", drawing);
  if (!a.json.to_stdout()) {
    constexpr int kNoMatplotlib = 3, kNoPython = 127;
    fmt::print("recordings, and force and path as CSV, in {}/; {}\n", a.out,
               drawn == 0 ? "picture " + drawing[0]
               : drawn == kNoMatplotlib || drawn == kNoPython || drawn < 0
                   ? "no picture: it needs python3 with matplotlib (apt install python3-matplotlib)"
                   : "no picture: see above");
  }
  for (const Session& s : sessions)
    if (!a.json.to_stdout() && std::filesystem::exists(view_picture(a, s)))
      fmt::print("seen by a spectator: {}\n", view_picture(a, s));
  if (!a.json.wanted()) return;
  ordered_json json;
  if (sessions.size() == 1)
    json = json_of(a, sessions.front());
  else
    for (const Session& s : sessions) json[s.key] = json_of(a, s);
  a.json.write(json);
}

}  // namespace

void add_demo(CLI::App& app) {
  auto a = std::make_shared<DemoArguments>();
  CLI::App* command = app.add_subcommand(
      "demo",
      "two users grasp a box, carry it, press it against a wall and let go, as separate processes\n"
      "over UDP on this machine; without --arch: central, distributed, and distributed with\n"
      "damping compensation");
  command->add_option("--arch", a->arch, "only this architecture")
      ->check(CLI::IsMember({"central", "distributed"}));
  command->add_option("--scene", a->scene,
                      "another scene, with --arch (default: box_central, box_distributed)");
  command->add_option("--set", a->sets, "change one field, PATH=VALUE")
      ->take_all()
      ->allow_extra_args(false);
  command
      ->add_option("--seconds", a->seconds,
                   "length of each session [s]; shorter than the hands' script: everything is that "
                   "much faster; longer: whole rounds of it, then rest")
      ->check(between(1.0, 1e6))
      ->capture_default_str();
  command->add_flag("--compensation", a->compensation,
                    "compensate the drag of the packet rate with the thesis's 0.88 N s/m and 0.025 "
                    "N m s/rad");
  command->add_option("--reconstruction", a->reconstruction, "of remote samples")
      ->check(CLI::IsMember({"hold", "extrapolate"}));
  command->add_option("--hands", a->hands, "recorded: a recording leads the carry")
      ->check(CLI::IsMember({"simulated", "recorded"}))
      ->capture_default_str();
  command->add_option("--hand-file", a->hand_file, "recorded hands: CSV or Tandem recording");
  command->add_option("--hand-columns", a->hand_columns,
                      "recorded hands: which columns, for example "
                      "time=t_s,y=x_master_rad:rad@0.075");
  command->add_option("--priority", a->priority, "SCHED_FIFO priority of the force loops; 0: none")
      ->check(CLI::Range(0, 99))
      ->capture_default_str();
  command
      ->add_option("--on-unstable", a->on_unstable,
                   "of the nodes: refuse or warn where the scene, at the delay they measure, is "
                   "predicted to be unstable")
      ->check(CLI::IsMember({"refuse", "warn"}))
      ->capture_default_str();
  command->add_flag("--no-cyclictest", a->no_cyclictest, "do not run cyclictest beside it");
  command->add_flag("--no-view", a->no_view,
                    "no window on the sessions (without a display: no picture from it)");
  command->add_option("--out", a->out, "folder for recordings, CSV and picture")
      ->capture_default_str();
  command->add_option("--picture", a->picture, "file of the picture (default: OUT/demo.png)");
  a->json.add(*command);
  // Looked at when OUT has been made: it may be in there.
  command->get_option("--json")->get_validator("writable")->active(false);
  command->callback([a] { demo(*a); });
}

}  // namespace tandem::cli
