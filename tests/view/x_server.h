#pragma once

#include <string>
#include <sys/types.h>

#include "view/renderer.h"

namespace tandem::test {

/// An X server without a screen (Xvfb), for as long as it lives. Programs started while it is
/// `use`d find it.
class XServer {
 public:
  explicit XServer(const std::string& size = "640x480");
  ~XServer();
  XServer(const XServer&) = delete;
  XServer& operator=(const XServer&) = delete;

  /// False: Xvfb is not installed.
  [[nodiscard]] bool runs() const { return !display_.empty(); }
  [[nodiscard]] const std::string& display() const { return display_; }
  /// For programs started from here on.
  void use() const;
  void kill();

 private:
  pid_t pid_ = -1;
  std::string display_;
};

/// What a pixel is of, by its colour.
enum class Thing { kGround, kBox, kWall, kUser1, kUser2, kOther };
[[nodiscard]] Thing thing_at(const view::Image& image, double x, double y);

}  // namespace tandem::test
