#include "cli/view.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <memory>
#include <vector>

#include <fmt/format.h>

#include "analysis/lifted.h"
#include "analysis/resampled.h"
#include "cli/analyze.h"
#include "cli/commands.h"
#include "cli/node_command.h"
#include "core/network_model.h"
#include "view/gl_window.h"
#include "view/paced_session.h"
#include "view/recording_source.h"
#include "view/spectator.h"

namespace tandem::cli {

using nlohmann::ordered_json;

namespace {

struct ViewArguments {
  SceneOption scene;
  WindowArguments window;
  JsonOption json;
  std::string user, pointer, recording, connect;
  double delay_packets = 0.0, loss = 0.0, jitter_ms = 0.0, speed = 1.0, start = 0.0;
  bool no_margin = false;
};

core::NetworkModel network_of(const ViewArguments& a, const core::Scene& scene) {
  core::NetworkModel network;
  core::LinkModelParameters link;
  link.loss = a.loss / 100.0;
  link.jitter = a.jitter_ms > 0.0 ? core::JitterKind::kUniform : core::JitterKind::kNone;
  link.jitter_ticks = 1e-3 * a.jitter_ms * scene.rates.local_hz;
  link.seed = 1;
  network.set_all(link);
  network.set_round_trip(a.delay_packets, scene.ticks_per_packet());
  return network;
}

int user_of(const core::Scene& scene, const std::string& name, const std::string& option) {
  if (name.empty()) return 0;
  const int u = core::index_of(scene.users, name);
  if (u >= 0) return u;
  std::string known;
  for (const core::UserParameters& user : scene.users)
    known += (known.empty() ? "" : ", ") + user.name;
  throw CLI::ValidationError(
      option, "scene " + scene.name + " has no user \"" + name + "\"; it has " + known);
}

void tell(const ViewArguments& a, const core::Scene& scene, const view::ViewerReport& report) {
  if (!a.json.to_stdout())
    fmt::print("{}: {} pictures in {:.1f} s; {}\n", scene.name, report.pictures, report.seconds,
               report.ended);
  a.json.write(to_json(scene, report));
}

void watch_scene(const ViewArguments& a) {
  const core::Scene scene = a.scene.load();
  view::ViewerOptions options = a.window.options();
  view::PacedSession::Options session;
  session.network = network_of(a, scene);
  session.seconds = a.window.seconds;
  devices::PointerFeed feed;
  if (!a.pointer.empty()) {
    session.own = user_of(scene, a.pointer, "--pointer");
    for (const core::FingerParameters& f :
         scene.users[static_cast<std::size_t>(session.own)].fingers)
      if (f.hand.stiffness <= 0.0)
        throw CLI::ValidationError("--pointer",
                                   "finger \"" + f.name + "\" of user " + a.pointer +
                                       " has hand.stiffness 0: a pointer leads a hand by "
                                       "its spring; give it one, for example 300 N/m");
    session.pointer = &feed;
    options.pointer = &feed;
    options.pointer_user = session.own;
  } else {
    session.own = user_of(scene, a.user, "--user");
  }
  // A picture or a film is made at the session's own pace; a window is for people.
  options.own_time = !options.screenshot.empty() || !options.frames.empty();
  if (options.own_time && options.seconds <= 0.0)
    throw CLI::ValidationError("--seconds",
                               "is needed with --screenshot and --frames: when the last "
                               "picture is taken");
  if (options.own_time) options.visible = false;
  session.speed = options.own_time ? 0.0 : a.speed;
  if (session.speed != 1.0) session.seconds = 0.0;  // then the pictures say when it ends
  options.text.title = scene.name + (scene.description.empty() ? "" : ": " + scene.description);
  options.text.legend = legend_of(scene, session.pointer != nullptr);
  if (!a.no_margin) options.text.margin = margin_of(scene, a.delay_packets);

  view::PacedSession paced(scene, session);
  view::Source source;
  source.newest = [&](view::Snapshot& out) { return paced.fetch(out); };
  source.ended = [&] { return paced.ended(); };
  source.advance_to = [&](double time) { paced.advance_to(a.start + time); };
  tell(a, scene, view::run_viewer(scene, source, options));
}

void watch_recording(const ViewArguments& a) {
  view::RecordingSource recording(a.recording);
  const core::Scene& scene = recording.scene();
  view::ViewerOptions options = a.window.options();
  options.own_time = !options.screenshot.empty() || !options.frames.empty();
  if (options.own_time) options.visible = false;
  const double length = recording.end() - recording.begin();
  if (a.start > length)
    throw CLI::ValidationError("--start",
                               fmt::format("{} s: the recording has {:.3f} s", a.start, length));
  if (options.own_time && options.seconds <= 0.0) options.seconds = length - a.start;
  options.text.title =
      fmt::format("{}, recorded at {}{}", scene.name,
                  recording.user() == "server" ? "the server" : "user " + recording.user(),
                  recording.complete() ? "" : " (not closed in order)");
  options.text.legend =
      legend_of(scene, false) + "\nspace: pause; , and .: back, on; [ and ]: speed";
  if (!a.no_margin) options.text.margin = margin_of(scene, a.delay_packets);

  view::Playback playback{.length = length, .time = a.start, .speed = a.speed};
  view::Source source;
  double shown = -1.0;
  auto last = std::chrono::steady_clock::now();
  source.newest = [&](view::Snapshot& out) {
    const auto now = std::chrono::steady_clock::now();
    if (!options.own_time && !playback.paused)
      playback.time += playback.speed * std::chrono::duration<double>(now - last).count();
    last = now;
    playback.time = std::clamp(playback.time, 0.0, length);
    if (playback.time == shown) return false;
    shown = playback.time;
    out = recording.at(recording.begin() + playback.time);
    return true;
  };
  source.advance_to = [&](double time) { playback.time = a.start + a.speed * time; };
  source.playback = &playback;
  tell(a, scene, view::run_viewer(scene, source, options));
}

void watch_session(const ViewArguments& a) {
  view::Spectator spectator(a.connect, version_text(), 6.0);
  const core::Scene& scene = spectator.scene();
  view::ViewerOptions options = a.window.options();
  if (!options.screenshot.empty()) {
    options.visible = false;
    if (options.seconds <= 0.0)
      throw CLI::ValidationError("--seconds", "is needed with --screenshot: when it is taken");
  }
  options.text.title = scene.name + " at " + a.connect;
  options.text.legend = legend_of(scene, false);
  if (!a.no_margin) options.text.margin = margin_of(scene, a.delay_packets);
  view::Source source;
  source.newest = [&](view::Snapshot& out) { return spectator.at_now(out); };
  source.messages = [&] {
    const std::vector<std::string> news = spectator.take_messages();
    for (const std::string& text : news) std::fprintf(stderr, "view: %s\n", text.c_str());
    return news;
  };
  tell(a, scene, view::run_viewer(scene, source, options));
}

}  // namespace

std::string legend_of(const core::Scene& scene, bool pointer) {
  const view::Layout layout(scene);
  std::string text = fmt::format(
      "red arrow: force on a finger, 1 N = {:.1f} mm\n"
      "ring on a surface: green holds, amber slides\n"
      "small dot: where the hand is, behind the surface\n",
      1e3 * layout.metres_per_newton);
  if (scene.architecture == core::Architecture::kDistributed ||
      scene.architecture == core::Architecture::kDistributedSplit)
    text += "tinted box: the copy of that user\n";
  if (scene.users.size() > 1) text += "ring round a finger: its delay, green 0, red 150 ms\n";
  text += pointer ? "mouse: your hand; left button or space: pinch\n"
                    "arrow keys: second finger; right button: look around\n"
                  : "mouse: look around; wheel: nearer; H plots, G copies, F forces\n";
  text += "R: all in sight; T: from above";
  return text;
}

std::string margin_of(const core::Scene& given, double delay_packets) {
  try {
    if (given.objects.empty()) return "";
    const analysis::LinearScene linear = analysis::linear_scene(given);
    const core::Scene& scene = linear.scene;
    core::NetworkModel network;
    const double N = scene.ticks_per_packet();
    const auto radius_at = [&](double packets) {
      network.set_round_trip(packets, N);
      return analysis::judge(analysis::why_not_resampled(scene, network).empty()
                                 ? analysis::resampled_system(scene, network)
                                 : analysis::measured_system(scene, network))
          .radius;
    };
    const double radius = radius_at(delay_packets);
    if (!(radius < 1.0))
      return fmt::format("predicted: NOT stable, grows {:.3g}-fold a packet period", radius);
    std::string text = fmt::format("predicted: stable,\nspectral radius {:.5f}", radius);
    if (scene.architecture == core::Architecture::kSingle) return text;
    constexpr int kMost = 12;
    for (int more = 1; more <= kMost; ++more)
      if (!(radius_at(delay_packets + more) < 1.0))
        return text + fmt::format(";\nbears {} more packet periods\nof round trip, not {}",
                                  more - 1, more);
    return text + fmt::format(";\nbears {} more packet periods\nof round trip", kMost);
  } catch (const std::exception& e) {
    return std::string("stability not predicted: ") + e.what();
  }
}

ordered_json to_json(const core::Scene& scene, const view::ViewerReport& r) {
  ordered_json j;
  j["scene"] = scene.name;
  j["pictures"] = r.pictures;
  j["seconds"] = r.seconds;
  j["pictures_a_second"] = r.pictures_a_second();
  j["picture_ms"] = {{"mean", r.picture_ms_mean}, {"p99", r.picture_ms_p99}};
  j["interval_ms_p99"] = r.interval_ms_p99;
  j["renderer"] = r.renderer;
  j["ended"] = r.ended;
  j["size"] = {r.width, r.height};
  const core::Vec3 eye = r.camera.eye(), target = r.camera.target;
  j["camera"] = {{"eye", {eye.x, eye.y, eye.z}},
                 {"target", {target.x, target.y, target.z}},
                 {"fov_y", r.camera.fov_y}};
  if (r.eye_in_screen)
    j["eye_in_screen"] = {r.eye_in_screen->x, r.eye_in_screen->y, r.eye_in_screen->z};
  if (!r.head_status.empty()) j["head_status"] = r.head_status;
  j["time"] = r.last.time;
  j["slot"] = r.last.slot;
  const view::Site& own = r.last.sites[static_cast<std::size_t>(r.last.own)];
  j["objects"] = ordered_json::array();
  for (std::size_t o = 0; own.has_objects && o < scene.objects.size(); ++o)
    j["objects"].push_back({own.objects[o].p.x, own.objects[o].p.y, own.objects[o].p.z});
  const view::Layout layout(scene);
  j["users"] = ordered_json::array();
  for (std::size_t u = 0; u < scene.users.size(); ++u) {
    const view::Site& site = r.last.sites[u];
    if (!site.has_hand) continue;
    ordered_json fingers = ordered_json::array();
    for (std::size_t f = 0; f < scene.users[u].fingers.size(); ++f) {
      const view::DrawnFinger at =
          view::drawn_finger(layout, r.last, static_cast<int>(u), static_cast<int>(f));
      const core::Vec3 p = site.fingers[f].p, force = site.fingers[f].force;
      fingers.push_back({{"position", {p.x, p.y, p.z}},
                         {"drawn", {at.proxy.x, at.proxy.y, at.proxy.z}},
                         {"force", {force.x, force.y, force.z}},
                         {"contact", static_cast<int>(site.fingers[f].contact)}});
    }
    j["users"].push_back({{"name", scene.users[u].name},
                          {"age_ms", 1e3 * site.age},
                          {"loss", site.loss},
                          {"fingers", fingers}});
  }
  return j;
}

void add_view(CLI::App& app) {
  auto a = std::make_shared<ViewArguments>();
  CLI::App* command = app.add_subcommand(
      "view",
      "a window on a session: the object, the hands, forces, delays.\n"
      "  tandem view --scene box_distributed               the scene by itself, simulated hands\n"
      "  tandem view --scene box_distributed --pointer 1   your mouse is user 1\n"
      "  tandem view --connect HOST:PORT                   a running server or replica\n"
      "  tandem view --recording FILE.h5                   what a node recorded\n"
      "  tandem view --scene space_box --seconds 5 --screenshot box.png      needs no display");
  a->scene.add(*command, "box_distributed");
  auto* recording = command->add_option(
      "--recording", a->recording,
      "play a recording (.h5): space pauses, the bar or , and . scrub, [ and ] change speed");
  auto* connect =
      command
          ->add_option("--connect", a->connect,
                       "HOST:PORT of a running server or replica: look on, over the network")
          ->excludes(recording);
  a->window.add(*command);
  a->json.add(*command);
  command->add_option("--user", a->user, "whose copy is drawn solid (default: the first)")
      ->excludes(recording)
      ->excludes(connect);
  command->add_option("--pointer", a->pointer, "the mouse leads this user's fingers")
      ->excludes(recording)
      ->excludes(connect);
  command->add_option("--start", a->start, "skip so much of the session [s] (with --screenshot)")
      ->check(not_negative);
  command->add_option("--speed", a->speed, "seconds of the session a second")
      ->check(between(0.01, 100.0));
  command
      ->add_option("--delay-packets", a->delay_packets,
                   "round trip of the modelled network in packet periods")
      ->check(between(0.0, 60.0));
  command->add_option("--loss", a->loss, "of the modelled network [%]")->check(between(0.0, 100.0));
  command
      ->add_option("--jitter-ms", a->jitter_ms, "of the modelled network, uniform, up to +- [ms]")
      ->check(between(0.0, 1000.0));
  command->add_flag("--no-margin", a->no_margin, "do not predict the stability");
  command->callback([a] {
    try {
      if (!a->recording.empty())
        watch_recording(*a);
      else if (!a->connect.empty())
        watch_session(*a);
      else
        watch_scene(*a);
    } catch (const view::WindowError& e) {
      throw Failed(std::string("view: ") + e.what());
    }
  });
}

}  // namespace tandem::cli
