#pragma once

#include "bench/error_cases.h"
#include "core/axis_state.h"
#include "core/held_step.h"
#include "core/integrate.h"

namespace tandem::bench {

/// A mass and a wall and nothing else: what event location would buy, beside the same without it.
struct WallScheme {
  const char* name;
  core::Integrator integrator;  ///< kExactCoupler: mass and wall spring together, core/held_step.h
  bool events;                  ///< the tick is cut where the mass meets or leaves the wall
};

inline constexpr WallScheme kWallSchemes[] = {
    {"bare_zero_order_hold", core::Integrator::kZeroOrderHold, false},
    {"bare_zero_order_hold_events", core::Integrator::kZeroOrderHold, true},
    {"bare_semi_implicit", core::Integrator::kSemiImplicitEuler, false},
    {"bare_semi_implicit_events", core::Integrator::kSemiImplicitEuler, true},
    {"bare_exact_wall", core::Integrator::kExactCoupler, false},
    {"bare_exact_wall_events", core::Integrator::kExactCoupler, true}};

/// The force is that of the axis world's wall: a spring and damper that never pull.
class BareWall {
 public:
  BareWall(const ErrorPoint& point, const WallScheme& scheme, double T) noexcept
      : scheme_(scheme),
        T_(T),
        k_(point.stiffness / kObjectMass),
        b_(point.damping / kObjectMass),
        held_(core::held_step(k_, b_, T)) {}

  void step() noexcept {
    if (!scheme_.events) {
      advance(T_, touches());
      return;
    }
    // Cut the tick at the way in and at the way out; both are found by bisection of the scheme's
    // own step, so nothing is assumed about it.
    double left = T_;
    for (int cuts = 0; cuts < 3; ++cuts) {
      const bool inside = inside_;
      const core::AxisState start = at_;
      advance(left, inside);
      if (!crossed(inside)) return;
      double low = 0.0, high = left;
      for (int i = 0; i < 40; ++i) {
        const double middle = 0.5 * (low + high);
        at_ = start;
        advance(middle, inside);
        (crossed(inside) ? high : low) = middle;
      }
      at_ = start;
      advance(high, inside);
      inside_ = !inside;
      left -= high;
    }
    advance(left, inside_);
  }

  void sample(double* out) const noexcept { out[0] = at_.p, out[1] = at_.v; }

 private:
  [[nodiscard]] double push() const noexcept { return k_ * (at_.p - kGap) + b_ * at_.v; }
  [[nodiscard]] bool touches() const noexcept { return at_.p > kGap && push() > 0.0; }
  [[nodiscard]] bool crossed(bool inside) const noexcept {
    return inside ? push() < 0.0 : at_.p > kGap && push() > 0.0;
  }

  void advance(double h, bool inside) noexcept {
    if (inside && scheme_.integrator == core::Integrator::kExactCoupler) {
      const core::HeldStep s = h == T_ ? held_ : core::held_step(k_, b_, h);
      const double u = -k_ * (at_.p - kGap);
      at_ = {at_.p + s.y_v * at_.v + s.y_u * u, s.v_v * at_.v + s.v_u * u};
      return;
    }
    core::advance(scheme_.integrator, h, 0.0, at_.p, at_.v, inside ? -push() : 0.0);
  }

  WallScheme scheme_;
  double T_, k_, b_;
  core::HeldStep held_;
  core::AxisState at_{0.0, kFlight};
  bool inside_ = false;
};

}  // namespace tandem::bench
