#include "cli/window_arguments.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <memory>
#include <numbers>
#include <sstream>
#include <tuple>
#include <vector>

#include <fmt/format.h>

#include "cli/node_command.h"
#include "cli/options.h"
#include "view/head_tracker.h"

namespace tandem::cli {
namespace {

/// Two positive whole numbers as in "1280x720".
std::pair<int, int> parse_size(const std::string& text) {
  int w = 0, h = 0;
  char x = 0, more = 0;
  std::istringstream in(text);
  if (!(in >> w >> x >> h) || x != 'x' || (in >> more) || w < 64 || h < 64 || w > 16384 ||
      h > 16384)
    throw CLI::ValidationError("--size",
                               "\"" + text + "\" is not WIDTHxHEIGHT, 64x64 to 16384x16384");
  return {w, h};
}

/// Azimuth, elevation [degree], distance [m], and perhaps the target [m]: "A,E,D[,X,Y,Z]".
view::Camera parse_camera(const std::string& text) {
  std::vector<double> numbers;
  std::istringstream in(text);
  for (std::string word; std::getline(in, word, ',');) {
    try {
      std::size_t end = 0;
      numbers.push_back(std::stod(word, &end));
      if (end != word.size() || !std::isfinite(numbers.back())) throw std::invalid_argument("");
    } catch (const std::exception&) {
      numbers.clear();
      break;
    }
  }
  if ((numbers.size() != 3 && numbers.size() != 6) || !(numbers[2] > 0.0) ||
      std::abs(numbers[1]) > 89.0)
    throw CLI::ValidationError("--camera", "\"" + text +
                                               "\" is not AZIMUTH,ELEVATION,DISTANCE[,X,Y,Z]: "
                                               "degrees, -89 to 89 degrees, metres above 0");
  constexpr double kDegree = std::numbers::pi / 180.0;
  view::Camera c;
  c.azimuth = numbers[0] * kDegree;
  c.elevation = numbers[1] * kDegree;
  c.distance = numbers[2];
  if (numbers.size() == 6) c.target = {numbers[3], numbers[4], numbers[5]};
  return c;
}

/// Head positions over time, "t,x,y,z" a line in the tracker's frame.
std::function<void(double, view::Room&)> head_of_file(const std::string& file) {
  std::ifstream in(file);
  if (!in) throw CLI::ValidationError("--head-track", "cannot read " + file);
  struct Pose {
    double t;
    core::Vec3 p;
  };
  auto track = std::make_shared<std::vector<Pose>>();
  int number = 0;
  for (std::string line; std::getline(in, line);) {
    ++number;
    if (line.empty() || line[0] == '#' || line[0] == 't') continue;
    const auto comma = line.find(',');
    try {
      const double t = std::stod(line.substr(0, comma));
      const core::Vec3 p = view::parse_point(line.substr(comma + 1));
      if (comma == std::string::npos || !std::isfinite(t) ||
          (!track->empty() && t <= track->back().t))
        throw std::invalid_argument("times must grow");
      track->push_back({t, p});
    } catch (const std::exception& e) {
      throw CLI::ValidationError(
          "--head-track",
          fmt::format("{}:{}: \"{}\" is not t,x,y,z [s, m]: {}", file, number, line, e.what()));
    }
  }
  if (track->empty()) throw CLI::ValidationError("--head-track", file + " has no line t,x,y,z");
  return [track](double time, view::Room& room) {
    const auto next =
        std::find_if(track->begin(), track->end(), [&](const Pose& pose) { return pose.t > time; });
    if (next == track->begin()) {
      room.tracker_from_head.t = next->p;
    } else if (next == track->end()) {
      room.tracker_from_head.t = track->back().p;
    } else {
      const Pose& before = *(next - 1);
      const double part = (time - before.t) / (next->t - before.t);
      room.tracker_from_head.t = before.p + (next->p - before.p) * part;
    }
  };
}

/// The head where a tracker's datagrams say, and a line in the window while they say nothing.
void follow_tracker(const std::string& bind, view::ViewerOptions& o) {
  auto tracker = std::make_shared<view::HeadTracker>(bind);
  o.move_head = [tracker](double time, view::Room& room) {
    (void)tracker->update(time, room.tracker_from_head);
  };
  o.head_status = [tracker](double time) {
    std::string text;
    if (tracker->silent(time)) text = "no head from a tracker at " + tracker->address();
    if (tracker->refused() > 0)
      text += fmt::format("{}{} of the tracker's datagrams refused: {}", text.empty() ? "" : "\n",
                          tracker->refused(), tracker->last_refusal());
    return text;
  };
}

}  // namespace

void WindowArguments::add(CLI::App& command) {
  command.add_option("--size", size, "of the window, WIDTHxHEIGHT")->capture_default_str();
  command
      .add_option("--seconds", seconds, "ends after this time [s]; 0: until the window is closed")
      ->check(not_negative);
  command.add_option("--fps", fps, "pictures a second, at most")
      ->check(between(1.0, 1000.0))
      ->capture_default_str();
  command.add_option("--screenshot", screenshot,
                     "write the last picture here, PNG; needs no display");
  command.add_option("--frames", frames, "write every picture into this folder, PNG");
  command.add_flag("--hidden", hidden, "a window nobody sees");
  command.add_flag("--offscreen", offscreen, "no window, even where there is a display");
  command.add_flag("--no-panels", no_panels, "no plots and notes (key H)");
  command.add_flag("--no-labels", no_labels, "no names");
  command.add_flag("--no-ghosts", no_ghosts, "not the copies of the others (key G)");
  command
      .add_option("--samples", samples,
                  "a pixel, for smooth edges; 0: none (default: 4, but none in a window that is "
                  "drawn in software, which is two to three times as quick)")
      ->check(CLI::Range(0, 16));
  command.add_option("--camera", camera,
                     "AZIMUTH,ELEVATION,DISTANCE[,X,Y,Z]: degrees, metres; where it looks from");
  auto* co_located = command.add_option_group("screens in a room (docs/viewer.md)");
  auto* both = co_located->add_flag("--stereo", stereo, "left and right eye side by side");
  co_located->add_option("--eye", eye, "only this eye: a window for each projector of a screen")
      ->check(CLI::IsMember({"left", "middle", "right"}))
      ->excludes(both)
      ->capture_default_str();
  auto* room_option = co_located->add_option(
      "--room", room,
      "JSON file with the frames of scene, tracker, devices, screen: picture for a "
      "tracked head before that screen");
  co_located->add_option("--head", head, "X,Y,Z of the head in the tracker's frame [m]")
      ->needs(room_option);
  auto* file =
      co_located->add_option("--head-track", head_track, "file with t,x,y,z of the head a line")
          ->needs(room_option);
  co_located
      ->add_option("--head-udp", head_udp,
                   "[ADDRESS:]PORT where a tracker sends the head, \"X Y Z\" or \"X Y Z QW QX QY "
                   "QZ\" a datagram; without ADDRESS from this computer only")
      ->needs(room_option)
      ->excludes(file);
}

WindowArguments NodeArguments::window_arguments() const {
  WindowArguments w;
  w.size = view_size;
  w.fps = view_fps;
  w.screenshot = view_screenshot;
  w.hidden = view_hidden;
  w.room = room;
  w.head_udp = head_udp;
  return w;
}

view::ViewerOptions WindowArguments::options() const {
  view::ViewerOptions o;
  std::tie(o.width, o.height) = parse_size(size);
  o.fps = fps;
  o.seconds = seconds;
  o.screenshot = screenshot;
  o.frames = frames;
  o.visible = !hidden;
  o.offscreen = offscreen;
  o.panels = !no_panels;
  o.drawing.labels = !no_labels;
  o.drawing.ghosts = !no_ghosts;
  if (samples >= 0) o.samples = samples;
  o.stereo = stereo;
  o.eye = eye == "left"    ? view::Eye::kLeft
          : eye == "right" ? view::Eye::kRight
                           : view::Eye::kMiddle;
  if (!screenshot.empty())
    if (const std::string why = writable_file(screenshot); !why.empty())
      throw CLI::ValidationError("--screenshot", why);
  if (!camera.empty()) o.camera = parse_camera(camera);
  if (room.empty()) return o;
  o.room = view::load_room(room);
  if (o.room->worst_residual > 0.0)
    fmt::print(stderr, "room {}: pairs of points fit within {:.2f} mm\n", room,
               1e3 * o.room->worst_residual);
  if (!head.empty()) o.room->tracker_from_head.t = view::parse_point(head);
  if (!head_track.empty()) o.move_head = head_of_file(head_track);
  if (!head_udp.empty()) follow_tracker(head_udp, o);
  (void)o.room->picture(view::Eye::kMiddle, 16, 9);
  return o;
}

}  // namespace tandem::cli
