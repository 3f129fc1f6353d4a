#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>

#include "core/network_model.h"
#include "core/scene.h"

namespace tandem::analysis {

/// The scene with one hand only: every coupler of the other users' hands taken away (the thesis's
/// free motion, 6.1, where the second user is kept from touching).
[[nodiscard]] inline core::Scene with_one_hand(core::Scene scene, const std::string& user) {
  std::erase_if(scene.couplers, [&](const core::CouplerParameters& c) {
    return !c.user.empty() && c.user != user;
  });
  return scene;
}

/// The user whose free motion is asked for: the first one across the network, or the first.
[[nodiscard]] inline int drag_user(const core::Scene& scene) {
  if (scene.architecture == core::Architecture::kCentral)
    for (std::size_t u = 0; u < scene.users.size(); ++u)
      if (!scene.users[u].local) return static_cast<int>(u);
  return 0;
}

struct Drag {
  std::optional<double> n_s_per_m;  ///< empty: no steady state either way
  bool prescribed = false;          ///< the motion was prescribed, not the force
  double settled_after_s = 0.0;
};

namespace detail {

/// Runs `loop` until `value(loop)`, taken over one repeat of its packet ticks, changes by less than
/// one part in 10^11, or of `least` if that is more, over three checks of 128 periods each; empty
/// if it never does or leaves all bounds.
template <typename Loop, typename Value>
[[nodiscard]] std::optional<double> settled(Loop& loop, Value&& value, double least,
                                            double max_seconds) {
  double previous = std::numeric_limits<double>::quiet_NaN();
  int steady = 0;
  while (loop.time() < max_seconds) {
    for (std::int64_t k = 0; k < 128; k += loop.packet_slots().packets) loop.advance_repeat();
    const double now = value(loop);
    if (!std::isfinite(now) || std::abs(now) > 1e9) return std::nullopt;
    const double tolerance = 1e-11 * std::max(std::abs(now), least);
    steady = std::abs(now - previous) <= tolerance ? steady + 1 : 0;
    if (steady == 3) return now;
    previous = now;
  }
  return std::nullopt;
}

}  // namespace detail

/// Viscous drag felt in free motion (6.2): constant force on the hand, mean velocity over the last
/// repeat of the packet ticks (a packet period where the ratio of the rates is whole) once settled.
/// Where the drag is not positive there is no steady state, and the motion is prescribed instead
/// and the mean force divided by the velocity.
template <typename Loop>
[[nodiscard]] Drag measure_drag(const Loop& at_rest, int user, double T) {
  constexpr double kForce = 1.0, kVelocity = 0.1;  // the loop is linear: the sizes do not matter
  const std::int64_t ticks = at_rest.packet_slots().ticks;  // of a repeat: every packet period
  const double period = static_cast<double>(ticks) * T;     // where the ratio is whole

  Loop pushed = at_rest;
  pushed.hands().finger(user, 0).set_external_force(kForce);
  const auto mean_velocity = [&](Loop& loop) {
    const double before = loop.hands().finger(user, 0).position();
    loop.advance_repeat();
    return (loop.hands().finger(user, 0).position() - before) / period;
  };
  Drag drag;
  if (const auto v = detail::settled(pushed, mean_velocity, 1e-3, 600.0); v && *v > 0.0) {
    drag.n_s_per_m = kForce / *v;
    drag.settled_after_s = pushed.time();
    return drag;
  }

  Loop led = at_rest;
  led.hands().finger(user, 0).prescribe_velocity(kVelocity);
  const auto mean_force = [&](Loop& loop) {
    double sum = 0.0;
    for (std::int64_t k = 0; k < ticks; ++k) {
      loop.tick();
      sum -= loop.output(user).forces[0];
    }
    return sum / static_cast<double>(ticks);
  };
  drag.prescribed = true;
  // The rounding of metres times a stiffness is some 1e-12 N, and all there is without drag.
  if (const auto f = detail::settled(led, mean_force, 1.0, 600.0)) drag.n_s_per_m = *f / kVelocity;
  drag.settled_after_s = led.time();
  return drag;
}

/// The same for the loop that an axis scene declares over a network; throws std::domain_error where
/// the scene is no axis.
[[nodiscard]] Drag measure_drag(const core::Scene& scene, const core::NetworkModel& network,
                                int user);

}  // namespace tandem::analysis
