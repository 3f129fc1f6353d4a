#pragma once

#include <memory>
#include <vector>

#include "view/drawing.h"
#include "view/projection.h"

namespace tandem::view {

/// Red, green, blue, row by row from the top; 8 bits each.
struct Image {
  int width = 0, height = 0;
  std::vector<unsigned char> rgb;
};

/// Draws a Drawing with OpenGL into a picture of its own, several samples a pixel, and brings that
/// to the window or into memory. Needs a current context (GlWindow).
class Renderer {
 public:
  /// Throws WindowError: a shader that does not compile. `samples`: a pixel; 0: no smoothing.
  explicit Renderer(int samples = 4);
  ~Renderer();
  Renderer(const Renderer&) = delete;
  Renderer& operator=(const Renderer&) = delete;

  /// Begins a picture of this size [pixel].
  void begin(int width, int height);
  /// One view of it; `line_scale`: pixels per 1/96 inch.
  void draw(const Drawing& drawing, const Picture& picture, double line_scale);
  /// All views are drawn: one colour a pixel from here on. What follows (panels) is drawn on top.
  void resolve();
  /// To the window.
  void present(int window_width, int window_height);
  [[nodiscard]] Image read() const;

 private:
  struct Gl;
  std::unique_ptr<Gl> gl_;
};

}  // namespace tandem::view
