#pragma once

#include <array>
#include <map>
#include <string>

#include "core/rigid.h"
#include "view/projection.h"

/// A screen in a room and an eye before it: the frames of the juggling paper's section 6.3, where
/// picture, devices and head tracker are brought to one common frame, so that what is seen is where
/// it is felt.
namespace tandem::view {

using core::Quat;
using core::Rigid;

enum class Eye { kLeft, kMiddle, kRight };

/// Frames, read from a file (docs/viewer.md): common C, scene W, each device D, tracker V, screen S
/// (origin in its middle, x right, y up, z towards the people), head H (origin between the eyes, x
/// from left to right).
struct Room {
  Rigid common_from_scene;
  Rigid common_from_tracker;
  Rigid common_from_screen;
  std::map<std::string, Rigid> common_from_device;         ///< by its name in the scene
  double screen_width = 0.0, screen_height = 0.0;          ///< [m]
  double eye_separation = 0.063;                           ///< [m]
  Rigid tracker_from_head{{0.0, 0.0, 0.6}, {1, 0, 0, 0}};  ///< until a tracker says otherwise
  double near = 0.05, far = 20.0;                          ///< [m]
  /// Largest distance that a frame fitted to pairs of points leaves [m]; 0: nothing was fitted.
  double worst_residual = 0.0;

  /// Each device in the scene's frame: what devices::FramedDevice wants.
  [[nodiscard]] std::map<std::string, Rigid> scene_from_devices() const;
  [[nodiscard]] Vec3 eye_in_screen(Eye eye) const;
  /// What this eye sees on the screen. Throws std::invalid_argument for an eye behind it.
  [[nodiscard]] Picture picture(Eye eye, int width, int height) const;
};

/// Throws std::runtime_error with the file, the field, its value and what is allowed.
[[nodiscard]] Room load_room(const std::string& file);
[[nodiscard]] Room parse_room(const std::string& json, const std::string& name);

/// "X,Y,Z" of the head in the tracker's frame [m].
[[nodiscard]] Vec3 parse_point(const std::string& text);

}  // namespace tandem::view
