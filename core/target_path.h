#pragma once

#include <array>
#include <type_traits>

#include "core/components.h"
#include "core/scene.h"
#include "core/trigonometry.h"

namespace tandem::core {

inline constexpr int kMaxKeyframes = 32;
inline constexpr int kMaxSines = 4;

/// Where a simulated hand is headed and the force it adds of itself, both as functions of time.
/// Keyframes are joined by quintic blends (zero velocity and acceleration at each), sines added.
/// V is double, Vec2 or Vec3. Before the first keyframe the target is the initial position.
template <typename V>
class TargetPath {
 public:
  struct Target {
    V position{0.0};  ///< [m]
    V velocity{0.0};  ///< [m/s]
  };

  TargetPath() noexcept = default;

  /// The loader has made sure that keyframes are in order of time and fit.
  TargetPath(const FingerIntent& intent, const Vec3& initial) noexcept
      : initial_(from_vec3<V>(initial)), constant_force_(from_vec3<V>(intent.force)) {
    for (const Keyframe& k : intent.path)
      if (keyframe_count_ < kMaxKeyframes)
        keyframes_[keyframe_count_++] = {k.time, from_vec3<V>(k.position)};
    for (const SinePart& s : intent.path_sines)
      if (path_sine_count_ < kMaxSines) path_sines_[path_sine_count_++] = s;
    for (const SinePart& s : intent.force_sines)
      if (force_sine_count_ < kMaxSines) force_sines_[force_sine_count_++] = s;
  }

  [[nodiscard]] Target at(double time) noexcept {
    Target target = blended(time);
    for (int i = 0; i < path_sine_count_; ++i) {
      const SinePart& s = path_sines_[i];
      if (time < s.start || time >= s.end) continue;
      const SinCos angle = sin_cos(s.omega * (time - s.start));
      if (s.positive_part_only && angle.sin <= 0.0) continue;
      const V direction = from_vec3<V>(s.direction);
      target.position += direction * (s.amplitude * angle.sin);
      target.velocity += direction * (s.amplitude * s.omega * angle.cos);
    }
    return target;
  }

  /// Force of the person beside the spring to the path [N].
  [[nodiscard]] V force_at(double time) const noexcept {
    V force = constant_force_;
    for (int i = 0; i < force_sine_count_; ++i) {
      const SinePart& s = force_sines_[i];
      if (time < s.start || time >= s.end) continue;
      const double sine = sin_cos(s.omega * (time - s.start)).sin;
      if (s.positive_part_only && sine <= 0.0) continue;
      force += from_vec3<V>(s.direction) * (s.amplitude * sine);
    }
    return force;
  }

 private:
  struct Knot {
    double time = 0.0;
    V offset{0.0};
  };

  [[nodiscard]] Target blended(double time) noexcept {
    if (keyframe_count_ == 0 || time <= keyframes_[0].time)
      return {initial_ + (keyframe_count_ > 0 ? keyframes_[0].offset : V{0.0}), V{0.0}};
    int last = keyframes_[knot_].time <= time ? knot_ : 0;  // time mostly moves on
    while (last + 1 < keyframe_count_ && keyframes_[last + 1].time <= time) ++last;
    knot_ = last;
    const Knot& from = keyframes_[last];
    if (last + 1 == keyframe_count_) return {initial_ + from.offset, V{0.0}};
    const Knot& to = keyframes_[last + 1];
    const double span = to.time - from.time;
    const double s = (time - from.time) / span;
    const double blend = s * s * s * (10.0 + s * (-15.0 + 6.0 * s));
    const double slope = 30.0 * s * s * (1.0 - s) * (1.0 - s) / span;
    const V step = to.offset - from.offset;
    return {initial_ + from.offset + step * blend, step * slope};
  }

  V initial_{0.0};
  V constant_force_{0.0};
  std::array<Knot, kMaxKeyframes> keyframes_{};
  std::array<SinePart, kMaxSines> path_sines_{};
  std::array<SinePart, kMaxSines> force_sines_{};
  int keyframe_count_ = 0, path_sine_count_ = 0, force_sine_count_ = 0;
  int knot_ = 0;  ///< where the last look-up ended; says nothing about the path
};

}  // namespace tandem::core
