#pragma once

#include <functional>
#include <memory>
#include <stdexcept>
#include <string>

struct GLFWwindow;

namespace tandem::view {

/// Why nothing can be drawn, in words for the person at the screen.
class WindowError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A place to draw with OpenGL 3.3 core: a window, or without a display nothing but the picture
/// (EGL without a surface). One at a time, on the main thread.
class GlWindow {
 public:
  struct Options {
    int width = 1280, height = 720;  ///< [screen coordinates]
    std::string title = "Tandem";
    bool visible = true;     ///< false: a window nobody sees
    bool offscreen = false;  ///< true: no window even where there is a display
    /// Called when the display goes away under us (its server died); it must not return into
    /// drawing, so it ends the program. Empty: a message and exit status 1.
    std::function<void()> on_display_lost;
  };

  /// Throws WindowError: no display and no EGL, or an OpenGL that is too old.
  explicit GlWindow(const Options& options);
  ~GlWindow();
  GlWindow(const GlWindow&) = delete;
  GlWindow& operator=(const GlWindow&) = delete;

  /// nullptr when off screen.
  [[nodiscard]] GLFWwindow* glfw() const noexcept { return window_; }
  [[nodiscard]] int width() const;  ///< of the picture [pixel]
  [[nodiscard]] int height() const;
  [[nodiscard]] double content_scale() const;  ///< pixels per 1/96 inch as the display says
  [[nodiscard]] bool wants_to_close() const;
  void show();                                    ///< what was drawn
  void poll();                                    ///< mouse and keys
  [[nodiscard]] std::string description() const;  ///< renderer and version
  [[nodiscard]] bool in_software() const;         ///< the processor draws, not a graphics card

 private:
  void open_window(const Options& options);
  void open_offscreen();

  Options options_;
  GLFWwindow* window_ = nullptr;
  struct Egl;
  std::unique_ptr<Egl> egl_;
};

/// Whether this session has a display at all.
[[nodiscard]] bool has_display();

}  // namespace tandem::view
