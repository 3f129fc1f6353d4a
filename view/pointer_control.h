#pragma once

#include "core/scene.h"
#include "devices/pointer_feed.h"
#include "view/drawing.h"
#include "view/projection.h"

namespace tandem::view {

/// Turns a mouse into targets for a user's fingers: the pointer leads the middle of the hand in the
/// scene's plane (space: in the upright plane that faces the eye), pinching closes the fingers,
/// arrow keys move the second finger by itself.
class PointerControl {
 public:
  PointerControl(const Layout& layout, int user);

  struct Input {
    bool inside = false;  ///< the mouse has moved in this window
    Vec2 pixel{0.0};      ///< of the picture
    bool pinch = false;
    Vec2 second_finger{0.0};  ///< arrow keys, -1 .. 1
    double seconds = 0.0;     ///< since the last call
  };
  [[nodiscard]] devices::PointerTargets update(const Input& input, const Picture& picture);

  [[nodiscard]] const Vec3& middle() const noexcept { return middle_; }

 private:
  [[nodiscard]] bool on_plane(const Vec2& pixel, const Picture& picture, Vec3& out) const;

  const Layout& layout_;
  int user_;
  std::vector<Vec3> home_;  ///< fingers from the hand's middle
  Vec3 middle_{0.0};
  Vec3 second_{0.0};
  double open_ = 1.0;
};

}  // namespace tandem::view
