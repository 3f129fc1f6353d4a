#pragma once

#include <cmath>
#include <cstdint>

#include "core/finger_sample.h"
#include "core/integrate.h"
#include "core/target_path.h"

namespace tandem::core {

/// Exact zero-order-hold step of x' = v, v' = -w x - d v + u with u held over T:
///   [x v]' = [[a00 a01] [a10 a11]] [x v] + [b0 b1] u
/// From the Taylor series with scaling and squaring, arithmetic only.
struct SecondOrderStep {
  double a00, a01, a10, a11, b0, b1;
};

[[nodiscard]] inline SecondOrderStep second_order_step(double w, double d, double T) noexcept {
  // exp of [[0 1 0][-w -d 1][0 0 0]] T / 2^s; the third column carries the held input.
  int squarings = 0;
  double h = T;
  while ((w * h + d) * h > 0.0625) {
    h *= 0.5;
    ++squarings;
  }
  double m[2][3] = {{1, 0, 0}, {0, 1, 0}};
  double term[2][3] = {{1, 0, 0}, {0, 1, 0}};
  for (int k = 1; k <= 14; ++k) {
    for (auto& row : term) {  // term <- term * A h / k, where row 3 of A is zero
      const double x = row[0], v = row[1];
      row[0] = -w * v * h / k;
      row[1] = (x - d * v) * h / k;
      row[2] = v * h / k;
    }
    for (int r = 0; r < 2; ++r)
      for (int c = 0; c < 3; ++c) m[r][c] += term[r][c];
  }
  for (int s = 0; s < squarings; ++s) {
    double square[2][3];
    for (int r = 0; r < 2; ++r)
      for (int c = 0; c < 3; ++c)
        square[r][c] = m[r][0] * m[0][c] + m[r][1] * m[1][c] + (c == 2 ? m[r][2] : 0.0);
    for (int r = 0; r < 2; ++r)
      for (int c = 0; c < 3; ++c) m[r][c] = square[r][c];
  }
  return {m[0][0], m[0][1], m[1][0], m[1][1], m[0][2], m[1][2]};
}

/// A simulated hand on a device: mass, spring and damper to a target path, damper to the ground,
/// Coulomb friction of the mechanism, encoder. Linear parts are stepped by the exact
/// zero-order-hold formula with the device force and the target held over the tick; a hand without
/// spring and dampers is the thesis's free mass (3.5, 3.6). V is double, Vec2 or Vec3.
template <typename V>
class SimulatedHand {
 public:
  SimulatedHand() noexcept = default;

  SimulatedHand(double T, double mass, const FingerParameters& finger,
                const DeviceParameters* device) noexcept
      : T_(T),
        mass_(mass),
        stiffness_(finger.hand.stiffness),
        damping_(finger.hand.damping),
        path_(finger.intent, finger.position) {
    x_ = from_vec3<V>(finger.position);
    free_ = stiffness_ == 0.0 && damping_ == 0.0 && finger.damping == 0.0;
    if (!free_)
      step_ = second_order_step(stiffness_ / mass_, (damping_ + finger.damping) / mass_, T_);
    if (device != nullptr) {
      encoder_step_ = device->encoder_step;
      friction_ = device->friction;
    }
  }

  /// What the device reports now: quantised when it has an encoder step, and then without velocity.
  [[nodiscard]] FingerSample<V> sample() const noexcept {
    if (encoder_step_ <= 0.0) return {x_, v_};
    FingerSample<V> out;
    for (int i = 0; i < kComponents<V>; ++i)
      component(out.p, i) = std::floor(component(x_, i) / encoder_step_ + 0.5) * encoder_step_;
    return out;
  }

  /// Advances from slot to slot + 1 with `device_force` held.
  void step(const V& device_force, std::int64_t slot) noexcept {
    if (prescribed_) {
      x_ += v_ * T_;
      return;
    }
    const double time = static_cast<double>(slot) * T_;
    const V force = device_force + path_.force_at(time) + external_;
    if (free_) {
      advance(Integrator::kZeroOrderHold, T_, friction_ / mass_, x_, v_, force * (1.0 / mass_));
    } else {
      const auto target = path_.at(time);
      const V u =
          (force + target.position * stiffness_ + target.velocity * damping_) * (1.0 / mass_);
      const V x = x_, v_before = v_;
      x_ = x * step_.a00 + v_before * step_.a01 + u * step_.b0;
      v_ = x * step_.a10 + v_before * step_.a11 + u * step_.b1;
      if (friction_ > 0.0) rub(x, v_before);
    }
  }

  /// Force added to the person's, for experiments [N].
  void set_external_force(const V& force) noexcept { external_ = force; }
  /// From now on the hand moves at this velocity whatever pushes back.
  void prescribe_velocity(const V& v) noexcept {
    prescribed_ = true;
    v_ = v;
  }
  [[nodiscard]] const V& position() const noexcept { return x_; }
  [[nodiscard]] const V& velocity() const noexcept { return v_; }

  /// Visits position and velocity; these are the hand's states.
  template <typename Visitor>
  void visit_state(Visitor&& visitor) {
    visitor.position(x_);
    visitor.velocity(v_);
  }

 private:
  /// Friction as an impulse after the linear step; a finger at rest stays exactly where it was.
  void rub(const V& x_before, const V& v_before) noexcept {
    const V free_v = v_;
    const bool stopped = rub_on_ground(T_ * friction_ / mass_, v_);
    if (stopped && inner(v_before, v_before) == 0.0)
      x_ = x_before;
    else
      x_ += (v_ - free_v) * (0.5 * T_);
  }

  double T_ = 0.0, mass_ = 1.0, stiffness_ = 0.0, damping_ = 0.0;
  double encoder_step_ = 0.0, friction_ = 0.0;
  SecondOrderStep step_{};
  V x_{0.0}, v_{0.0}, external_{0.0};
  bool free_ = true;
  bool prescribed_ = false;
  TargetPath<V> path_;
};

}  // namespace tandem::core
