#pragma once

#include <atomic>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/scene.h"
#include "devices/pointer_feed.h"
#include "view/drawing.h"
#include "view/panels.h"
#include "view/room.h"
#include "view/snapshot.h"

namespace tandem::view {

/// Where the snapshots come from. All are called on the viewer's thread.
struct Source {
  /// The session as it is to be drawn now. False: nothing newer than the last time.
  std::function<bool(Snapshot&)> newest;
  std::function<bool()> ended;                         ///< empty: never
  std::function<void(double time)> advance_to;         ///< where the viewer makes the time [s]
  std::function<std::vector<std::string>()> messages;  ///< news for people; empty: none
  Playback* playback = nullptr;                        ///< a recording is played
};

struct ViewerOptions {
  int width = 1280, height = 720;
  bool visible = true;
  bool offscreen = false;  ///< no window, even where there is a display
  bool own_time = false;   ///< time goes with the pictures, through Source::advance_to
  double seconds = 0.0;    ///< ends after this time [s]; 0: when the source or the person ends it
  double fps = 60.0;       ///< pictures a second at most
  std::string screenshot;  ///< PNG of the last picture; empty: none
  std::string frames;      ///< folder for every picture; empty: none
  bool panels = true;
  DrawOptions drawing;
  /// A pixel, for smooth edges. None given: 4, but 0 where people look and software draws.
  std::optional<int> samples;
  bool stereo = false;                                ///< left and right eye side by side
  std::optional<Room> room;                           ///< head-tracked; none: camera on the mouse
  std::function<void(double time, Room&)> move_head;  ///< sets tracker_from_head; empty: it rests
  /// What there is to say of the head's tracker; empty, or an empty string: nothing.
  std::function<std::string(double time)> head_status;
  Eye eye = Eye::kMiddle;        ///< without stereo
  std::optional<Camera> camera;  ///< none: all of the scene
  PanelText text;
  devices::PointerFeed* pointer = nullptr;  ///< the mouse leads this user's fingers
  int pointer_user = 0;
  const std::atomic<bool>* stop = nullptr;
  std::function<void()> on_display_lost;
};

struct ViewerReport {
  std::int64_t pictures = 0;
  double seconds = 0.0;
  double picture_ms_mean = 0.0, picture_ms_p99 = 0.0;  ///< drawing time of one
  double interval_ms_p99 = 0.0;                        ///< from picture to picture
  std::string renderer;
  std::string ended;  ///< "time is over", "the window was closed", "the session ended", "stopped"
  Snapshot last;
  Camera camera;
  std::optional<Vec3> eye_in_screen;  ///< with a room: the last picture's eye
  std::string head_status;            ///< as shown last
  int width = 0, height = 0;

  [[nodiscard]] double pictures_a_second() const {
    return seconds > 0.0 ? static_cast<double>(pictures) / seconds : 0.0;
  }
};

/// Draws until something ends it. Main thread. Throws WindowError, std::runtime_error (files).
[[nodiscard]] ViewerReport run_viewer(const core::Scene& scene, const Source& source,
                                      const ViewerOptions& options);

}  // namespace tandem::view
