#pragma once

#include <string>

#include <CLI/CLI.hpp>

#include "view/viewer.h"

namespace tandem::cli {

/// The options of everything that opens a window.
struct WindowArguments {
  std::string size = "1280x720";
  double fps = 60.0, seconds = 0.0;
  std::string screenshot, frames;
  bool hidden = false, offscreen = false, no_panels = false, no_labels = false, no_ghosts = false;
  int samples = -1;  ///< -1: what suits
  bool stereo = false;
  std::string room, head, head_track, head_udp, eye = "middle";
  std::string camera;

  void add(CLI::App& command);
  /// Throws CLI::ValidationError, std::runtime_error (room).
  [[nodiscard]] view::ViewerOptions options() const;
};

}  // namespace tandem::cli
