#pragma once

#include <string>

#include "view/drawing.h"
#include "view/gl_window.h"
#include "view/history.h"
#include "view/projection.h"

namespace tandem::view {

/// How a recording is being played; the panel changes it.
struct Playback {
  double length = 0.0;  ///< [s]
  double time = 0.0;
  double speed = 1.0;
  bool paused = false;
};

/// What the panels say beside the history.
struct PanelText {
  std::string title;   ///< scene and where it comes from
  std::string margin;  ///< predicted stability, in one line; empty: not known
  std::string legend;  ///< what arrows and dots mean
  std::string status;  ///< pictures a second and the like
};

/// Words, plots and the player's bar over the picture (Dear ImGui).
class Panels {
 public:
  explicit Panels(GlWindow& window);
  ~Panels();
  Panels(const Panels&) = delete;
  Panels& operator=(const Panels&) = delete;

  void begin(int width, int height, double seconds_since_last);
  void labels(const Drawing& drawing, const Picture& picture);
  void plots(const History& history, const PanelText& text);
  void player(Playback& playback);
  void draw();
  /// Instead of `draw`: windows that fit their words are only seen from the second picture on.
  void measure_only();

  /// The mouse or the keyboard is at a panel: not for the camera.
  [[nodiscard]] bool takes_mouse() const;
  [[nodiscard]] bool takes_keys() const;
  [[nodiscard]] double scale() const noexcept { return scale_; }

 private:
  void load_font();

  GlWindow& window_;
  int width_ = 0, height_ = 0;
  double scale_ = 1.0, font_scale_ = 0.0;
};

}  // namespace tandem::view
