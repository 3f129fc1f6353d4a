#include "view/viewer.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <thread>
#include <utility>

#include <fmt/format.h>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include "view/gl_window.h"
#include "view/history.h"
#include "view/png_file.h"
#include "view/pointer_control.h"
#include "view/renderer.h"

namespace tandem::view {
namespace {

using SteadyClock = std::chrono::steady_clock;

[[nodiscard]] double seconds_between(SteadyClock::time_point a, SteadyClock::time_point b) {
  return std::chrono::duration<double>(b - a).count();
}

/// Distance before its screen that an eye has at least [m].
constexpr double kNearest = 0.02;

/// Mouse wheel movements since they were last looked at.
double scrolled = 0.0;
GLFWscrollfun scroll_before = nullptr;
void on_scroll(GLFWwindow* window, double x, double y) {
  scrolled += y;
  if (scroll_before != nullptr) scroll_before(window, x, y);
}

/// Everything one viewer holds while it runs.
class Viewer {
 public:
  Viewer(const core::Scene& scene, const Source& source, const ViewerOptions& options)
      : source_(source),
        options_(options),
        layout_(scene),
        window_({.width = options.width,
                 .height = options.height,
                 .title = options.text.title.empty() ? "Tandem" : options.text.title,
                 .visible = options.visible,
                 .offscreen = options.offscreen,
                 .on_display_lost = options.on_display_lost}),
        renderer_(options.samples.value_or(
            options.screenshot.empty() && options.frames.empty() && window_.in_software() ? 0 : 4)),
        panels_(window_),
        history_(scene),
        camera_(options.camera.value_or(
            layout_.camera(static_cast<double>(options.width) / options.height))),
        pointer_(layout_, options.pointer_user) {
    if (window_.glfw() != nullptr) scroll_before = glfwSetScrollCallback(window_.glfw(), on_scroll);
    scrolled = 0.0;
    if (options.room) last_head_ = options.room->tracker_from_head;
    if (!options.frames.empty()) std::filesystem::create_directories(options.frames);
  }

  ViewerReport run();

 private:
  [[nodiscard]] bool goes_on();
  void take_snapshot();
  void steer(double seconds);
  void steer_by_mouse(bool free_left);
  void steer_playback(Playback& playback);
  void lead_fingers(double seconds);
  void draw_picture(double seconds);
  void follow_head();
  [[nodiscard]] Picture picture_of(Eye eye, int x, int width, int height) const;
  [[nodiscard]] bool key(int k) const {
    return window_.glfw() != nullptr && glfwGetKey(window_.glfw(), k) == GLFW_PRESS;
  }
  /// Once for each time it is pressed.
  [[nodiscard]] bool pressed(int k);

  const Source& source_;
  ViewerOptions options_;
  Layout layout_;
  GlWindow window_;
  Renderer renderer_;
  Panels panels_;
  History history_;
  Camera camera_;
  PointerControl pointer_;
  Rigid last_head_;  ///< in the tracker's frame: the last from where the screen can be seen
  Snapshot seen_;
  bool any_ = false;
  double time_ = 0.0;  ///< since the start, or of the pictures
  Vec2 mouse_{0.0};
  bool mouse_moved_ = false;
  std::array<bool, GLFW_KEY_LAST + 1> down_{};
  ViewerReport report_;
};

bool Viewer::pressed(int k) {
  const bool now = key(k);
  const bool before = std::exchange(down_[static_cast<std::size_t>(k)], now);
  return now && !before;
}

bool Viewer::goes_on() {
  if (window_.wants_to_close() || (window_.glfw() != nullptr && key(GLFW_KEY_ESCAPE)))
    report_.ended = "the window was closed";
  else if (options_.stop != nullptr && options_.stop->load())
    report_.ended = "stopped";
  else if (options_.seconds > 0.0 && time_ >= options_.seconds - 1e-9)
    report_.ended = "time is over";
  else if (source_.ended && source_.ended())
    report_.ended = "the session ended";
  return report_.ended.empty();
}

void Viewer::take_snapshot() {
  if (source_.messages)
    for (const std::string& text : source_.messages()) history_.tell(text);
  if (!source_.newest(seen_)) return;
  any_ = true;
  history_.add(seen_);
}

void Viewer::steer_by_mouse(bool free_left) {
  GLFWwindow* w = window_.glfw();
  Vec2 now{0.0};
  glfwGetCursorPos(w, &now.x, &now.y);
  const Vec2 moved = now - mouse_;
  if (std::exchange(mouse_, now) != now) mouse_moved_ = true;
  const double wheel = std::exchange(scrolled, 0.0);
  if (panels_.takes_mouse()) return;
  const auto button = [&](int b) { return glfwGetMouseButton(w, b) == GLFW_PRESS; };
  int width = 1, height = 1;
  glfwGetWindowSize(w, &width, &height);
  const bool shift = key(GLFW_KEY_LEFT_SHIFT);
  if (button(GLFW_MOUSE_BUTTON_MIDDLE) || (shift && button(GLFW_MOUSE_BUTTON_RIGHT)))
    camera_.pan(-moved.x / height, moved.y / height);
  else if (button(GLFW_MOUSE_BUTTON_RIGHT) || (free_left && button(GLFW_MOUSE_BUTTON_LEFT)))
    camera_.turn(moved.x, moved.y);
  camera_.zoom(wheel);
}

void Viewer::steer(double seconds) {
  if (window_.glfw() == nullptr) return;
  const bool pointer = options_.pointer != nullptr;
  steer_by_mouse(!pointer);
  const double angle = 1.2 * seconds;
  if (!panels_.takes_keys()) {
    const auto axis = [&](int plus, int minus) {
      return (key(plus) ? 1.0 : 0.0) - (key(minus) ? 1.0 : 0.0);
    };
    camera_.azimuth += angle * axis(GLFW_KEY_D, GLFW_KEY_A);
    camera_.elevation =
        std::clamp(camera_.elevation + angle * axis(GLFW_KEY_W, GLFW_KEY_S), -0.2, 1.55);
    camera_.zoom(8.0 * seconds * axis(GLFW_KEY_EQUAL, GLFW_KEY_MINUS));
    if (!pointer) {
      camera_.azimuth += angle * axis(GLFW_KEY_RIGHT, GLFW_KEY_LEFT);
      camera_.elevation =
          std::clamp(camera_.elevation + angle * axis(GLFW_KEY_UP, GLFW_KEY_DOWN), -0.2, 1.55);
    }
    if (pressed(GLFW_KEY_R))
      camera_ = layout_.camera(static_cast<double>(window_.width()) / window_.height());
    if (pressed(GLFW_KEY_T)) camera_.elevation = 1.55, camera_.azimuth = -1.5708;
    if (pressed(GLFW_KEY_H)) options_.panels = !options_.panels;
    if (pressed(GLFW_KEY_G)) options_.drawing.ghosts = !options_.drawing.ghosts;
    if (pressed(GLFW_KEY_F)) options_.drawing.forces = !options_.drawing.forces;
    if (source_.playback != nullptr) steer_playback(*source_.playback);
  }
  if (pointer) lead_fingers(seconds);
}

void Viewer::steer_playback(Playback& playback) {
  constexpr double kStep = 0.5;  // [s]
  if (pressed(GLFW_KEY_SPACE)) playback.paused = !playback.paused;
  if (pressed(GLFW_KEY_COMMA)) playback.time = std::max(0.0, playback.time - kStep);
  if (pressed(GLFW_KEY_PERIOD)) playback.time = std::min(playback.length, playback.time + kStep);
  if (pressed(GLFW_KEY_LEFT_BRACKET)) playback.speed = std::max(0.05, 0.5 * playback.speed);
  if (pressed(GLFW_KEY_RIGHT_BRACKET)) playback.speed = std::min(4.0, 2.0 * playback.speed);
}

void Viewer::lead_fingers(double seconds) {
  GLFWwindow* w = window_.glfw();
  int width = 1, height = 1;
  glfwGetWindowSize(w, &width, &height);
  PointerControl::Input input;
  input.inside = mouse_moved_ && !panels_.takes_mouse() && mouse_.x >= 0 && mouse_.y >= 0 &&
                 mouse_.x < width && mouse_.y < height;
  input.pixel = {mouse_.x * window_.width() / width, mouse_.y * window_.height() / height};
  input.pinch =
      key(GLFW_KEY_SPACE) ||
      (!panels_.takes_mouse() && glfwGetMouseButton(w, GLFW_MOUSE_BUTTON_LEFT) == GLFW_PRESS);
  input.second_finger = {(key(GLFW_KEY_RIGHT) ? 1.0 : 0.0) - (key(GLFW_KEY_LEFT) ? 1.0 : 0.0),
                         (key(GLFW_KEY_UP) ? 1.0 : 0.0) - (key(GLFW_KEY_DOWN) ? 1.0 : 0.0)};
  input.seconds = std::min(seconds, 0.1);
  options_.pointer->publish(
      pointer_.update(input, picture_of(Eye::kMiddle, 0, window_.width(), window_.height())));
}

Picture Viewer::picture_of(Eye eye, int x, int width, int height) const {
  Picture p;
  if (options_.room) {
    p = options_.room->picture(eye, width, height);
  } else {
    Camera c = camera_;
    p = c.picture(width, height);
    if (eye != Eye::kMiddle) {
      // Without a room: eyes a thirtieth of the distance apart, both to the same target.
      const double side = (eye == Eye::kLeft ? -0.5 : 0.5) * c.distance / 30.0;
      p.view[3][0] -= side;
      const double near = 0.02 * c.distance;
      Frustum f =
          symmetric_frustum(c.fov_y, static_cast<double>(width) / height, near, 50.0 * c.distance);
      const double shift = side * near / c.distance;
      f.left -= shift;
      f.right -= shift;
      p.projection = projection_matrix(f);
    }
  }
  p.x = x;
  return p;
}

void Viewer::follow_head() {
  if (!options_.room) return;
  if (options_.move_head) options_.move_head(time_, *options_.room);
  if (options_.head_status) report_.head_status = options_.head_status(time_);
  const double nearest = std::min(options_.room->eye_in_screen(Eye::kLeft).z,
                                  options_.room->eye_in_screen(Eye::kRight).z);
  if (nearest > kNearest) {
    report_.eye_in_screen = options_.room->eye_in_screen(options_.eye);
    last_head_ = options_.room->tracker_from_head;
  } else {
    // A tracker that lost its markers: nothing can be seen from behind the screen.
    options_.room->tracker_from_head = last_head_;
    if (!report_.head_status.empty()) report_.head_status += '\n';
    report_.head_status +=
        "the tracker puts the head in or behind the screen: it is drawn from where it was";
  }
}

void Viewer::draw_picture(double seconds) {
  const int width = window_.width(), height = window_.height();
  if (width < 2 || height < 2) return;  // minimised
  follow_head();
  const Drawing drawing = any_ ? draw(layout_, seen_, options_.drawing) : Drawing{};
  const auto put_panels = [&] {
    if (!options_.panels) return;
    PanelText text = options_.text;
    if (!any_) text.status = "waiting for the session";
    if (!report_.head_status.empty())
      text.status += (text.status.empty() ? "" : "\n") + report_.head_status;
    panels_.plots(history_, text);
    if (source_.playback != nullptr) panels_.player(*source_.playback);
  };
  for (int i = 0; report_.pictures == 0 && i < 2; ++i) {
    panels_.begin(width, height, seconds);
    put_panels();
    panels_.measure_only();
  }
  panels_.begin(width, height, seconds);
  renderer_.begin(width, height);
  const auto view = [&](Eye eye, int x, int w) {
    const Picture p = picture_of(eye, x, w, height);
    renderer_.draw(drawing, p, panels_.scale());
    if (options_.drawing.labels) panels_.labels(drawing, p);
  };
  if (options_.stereo) {
    view(Eye::kLeft, 0, width / 2);
    view(Eye::kRight, width / 2, width - width / 2);
  } else {
    view(options_.eye, 0, width);
  }
  renderer_.resolve();
  put_panels();
  panels_.draw();
  if (!options_.frames.empty())
    write_png(fmt::format("{}/{:06}.png", options_.frames, report_.pictures), renderer_.read());
  if (window_.glfw() != nullptr) renderer_.present(width, height);
  window_.show();
  ++report_.pictures;
}

ViewerReport Viewer::run() {
  report_.renderer = window_.description();
  std::vector<double> drawing_ms, interval_ms;
  const auto start = SteadyClock::now();
  auto last = start;
  const double period = 1.0 / options_.fps;
  // Where nobody looks and only the last picture is kept, the others need not be drawn.
  const bool only_last =
      !options_.visible && options_.frames.empty() && !options_.screenshot.empty();
  std::int64_t step = 0;
  while (true) {
    const auto begin = SteadyClock::now();
    if (options_.own_time) {
      time_ = static_cast<double>(step++) * period;
      if (options_.seconds > 0.0) time_ = std::min(time_, options_.seconds);
      if (source_.advance_to) source_.advance_to(time_);
    } else {
      time_ = seconds_between(start, begin);
    }
    window_.poll();
    const double since = options_.own_time ? period : seconds_between(last, begin);
    if (report_.pictures > 0) interval_ms.push_back(1e3 * seconds_between(last, begin));
    last = begin;
    take_snapshot();
    steer(since);
    const bool more = goes_on();
    if (!only_last || !more) {
      draw_picture(since);
      drawing_ms.push_back(1e3 * seconds_between(begin, SteadyClock::now()));
    }
    if (!more) break;
    if (!options_.own_time) {
      const double used = seconds_between(begin, SteadyClock::now());
      if (used < period) std::this_thread::sleep_for(std::chrono::duration<double>(period - used));
    }
  }
  report_.seconds = seconds_between(start, SteadyClock::now());
  report_.last = seen_;
  report_.camera = camera_;
  report_.width = window_.width();
  report_.height = window_.height();
  for (const double ms : drawing_ms)
    report_.picture_ms_mean += ms / static_cast<double>(drawing_ms.size());
  const auto p99 = [](std::vector<double>& v) {
    if (v.empty()) return 0.0;
    std::sort(v.begin(), v.end());
    return v[std::min(v.size() - 1, v.size() * 99 / 100)];
  };
  report_.picture_ms_p99 = p99(drawing_ms);
  report_.interval_ms_p99 = p99(interval_ms);
  if (!options_.screenshot.empty()) write_png(options_.screenshot, renderer_.read());
  return report_;
}

}  // namespace

ViewerReport run_viewer(const core::Scene& scene, const Source& source,
                        const ViewerOptions& options) {
  Viewer viewer(scene, source, options);
  return viewer.run();
}

}  // namespace tandem::view
