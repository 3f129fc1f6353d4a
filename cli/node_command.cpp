#include "cli/node_command.h"

#include <cmath>
#include <cstdio>

#include "cli/commands.h"
#include "cli/stability_guard.h"
#include "node/site_name.h"
#include "view/room.h"

namespace tandem::cli {

void NodeArguments::add(CLI::App& command) {
  command.add_option("--seconds", seconds, "run this long [s]; 0: until Ctrl-C")
      ->check(not_negative);
  command.add_option("--record", record, "record every tick and packet into this HDF5 file");
  command
      .add_option("--hands", hands,
                  "who moves this user's fingers; pointer: the mouse in the window of --view")
      ->check(CLI::IsMember({"simulated", "recorded", "pointer"}))
      ->capture_default_str();
  command.add_option("--hand-file", hand_file, "recorded hands: CSV or Tandem recording to play");
  command.add_option("--hand-columns", hand_columns, "recorded hands: which column drives what");
  command
      .add_option("--hand-after", hand_after,
                  "recorded hands: the scene's script goes on, and the recording's displacement is "
                  "added to it from this time on [s]")
      ->check(not_negative);
  auto* room_option = command.add_option(
      "--room", room,
      "JSON file with the frames of devices, scene, tracker, screen (docs/viewer.md): recorded "
      "hands are brought into the scene's frame, and --view draws for a head before the screen");
  auto* window = command.add_option_group("window");
  window->add_flag("--view", view, "open a window on this node; it never holds up the force loop");
  window->add_option("--view-size", view_size, "WIDTHxHEIGHT")->capture_default_str();
  window->add_option("--view-fps", view_fps, "pictures a second, at most")
      ->check(between(1.0, 1000.0))
      ->capture_default_str();
  window->add_option("--view-screenshot", view_screenshot, "write the last picture here, PNG");
  window->add_flag("--view-hidden", view_hidden, "a window nobody sees");
  window
      ->add_option("--head-udp", head_udp,
                   "[ADDRESS:]PORT where a head tracker sends \"X Y Z\" (docs/viewer.md)")
      ->needs(room_option);
  auto* realtime = command.add_option_group("real time");
  realtime
      ->add_option("--priority", priority,
                   "SCHED_FIFO priority of the force loop; 0: stay an ordinary thread")
      ->check(CLI::Range(0, 99))
      ->capture_default_str();
  realtime->add_option("--cpu", cpu, "run the force loop on this processor only")
      ->check(not_negative);
  realtime
      ->add_option("--spin-us", spin_us,
                   "ask the clock instead of sleeping for the last so many microseconds of each "
                   "wait; costs that share of a processor (default: 50 where deep sleep is off, "
                   "else 120)")
      ->check(between(0.0, 1e6));
  realtime->add_flag("--no-memory-lock", no_memory_lock, "do not lock memory");
  realtime->add_flag("--no-dma-latency", no_dma_latency,
                     "let processors fall into deep sleep (saves power, wakes later)");
  command
      .add_option("--status-every", status_every,
                  "a status line every so many seconds [s] (default: live on a terminal, else "
                  "every 5 s)")
      ->check(not_negative);
  command.add_flag("--quiet", quiet, "no status");
  command
      .add_option("--on-unstable", on_unstable,
                  "when the measured delay leaves the region where the scene is predicted to be "
                  "stable: refuse (let go of the others, end), warn, or ignore (nothing is "
                  "predicted)")
      ->check(CLI::IsMember({"refuse", "warn", "ignore"}))
      ->capture_default_str();
  command.add_flag("--without-silence", without_silence,
                   "run a scene without `silence` too: the force of a peer that dies stays on");
  command
      .add_option("--start-ns", start_ns,
                  "when slot 0 is due on this computer's monotonic clock [ns]; 0: at once")
      ->group("");  // for the demo, whose nodes start together
  json.add(command);
}

node::NodeOptions NodeArguments::options(const std::string& bind) const {
  node::NodeOptions o;
  o.bind = bind;
  o.seconds = seconds;
  o.start_ns = start_ns;
  o.record_file = record;
  o.hands = {hands == "recorded", hand_file, hand_columns, nullptr, {}, {}};
  if (hand_after >= 0.0) o.hands.after = hand_after;
  if (!room.empty()) o.hands.frames = view::load_room(room).scene_from_devices();
  if (o.hands.recorded && hand_file.empty())
    throw CLI::ValidationError("--hands recorded", "needs --hand-file FILE to play");
  if (!o.hands.recorded && !hand_file.empty())
    throw CLI::ValidationError("--hand-file", "is only used with --hands recorded");
  o.realtime.priority = priority;
  o.realtime.lock_memory = !no_memory_lock;
  o.realtime.hold_cpu_dma_latency = !no_dma_latency;
  if (cpu >= 0) o.realtime.cpu = cpu;
  if (spin_us >= 0.0) o.spin_ns = std::llround(1e3 * spin_us);
  o.status_every = status_every;
  o.quiet = quiet;
  o.without_silence = without_silence;
  o.program_version = version_text();
  o.git_revision = revision_text();
  return o;
}

node::GuardMaker NodeArguments::guard(const core::Scene* scene) const {
  if (on_unstable == "ignore") return {};
  return guard_maker(on_unstable == "refuse", scene);
}

void finish(const node::NodeReport& report, const JsonOption& json,
            const nlohmann::ordered_json& window) {
  if (!json.to_stdout()) std::fputs(node::to_text(report).c_str(), stdout);
  std::fflush(stdout);
  nlohmann::ordered_json all = node::to_json(report);
  if (!window.is_null()) all["window"] = window;
  json.write(all);
  if (!report.failure.empty())
    throw Failed(node::site_name(report.role, report.user) + ": " + report.failure);
}

}  // namespace tandem::cli
