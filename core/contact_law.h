#pragma once

#include <cmath>
#include <cstdint>

#include "core/components.h"
#include "core/contact_state.h"
#include "core/scene.h"

/// The four contact states of thesis 7.2.2 for one point against one surface, free of any geometry:
/// depth and motion in the contact point frame go in, the force on the point comes out. `Tangent`
/// is double in the plane and a vector in space, so the friction limit is a cone, never a pyramid.
namespace tandem::core {

struct ContactGains {
  Gain normal;
  Gain tangential;
  FrictionParameters friction;  ///< both coefficients 0: no friction, nothing computed
  bool moment_cancellation = false;
  double pulse_force = 0.0;  ///< F_max [N]
  double mass = 0.0;         ///< m_h of what arrives, hand with device [kg]
};

/// Motion of the point relative to the surface it touches, in a frame that moves with the body the
/// surface belongs to.
template <typename Tangent>
struct SurfaceMotion {
  double depth = 0.0;            ///< below the surface, <= 0 is apart [m]
  double normal_velocity = 0.0;  ///< along the outward normal, negative when approaching [m/s]
  Tangent position{0.0};         ///< along the surface [m]
  Tangent velocity{0.0};         ///< of it, relative to the surface [m/s]
};

/// Force on the point; the surface feels the opposite.
template <typename Tangent>
struct SurfaceForce {
  double normal = 0.0;      ///< along the outward normal, never negative [N]
  Tangent tangential{0.0};  ///< [N]
};

/// What a contact remembers from tick to tick.
template <typename Tangent>
struct ContactMemory {
  Tangent anchor{0.0};  ///< the contact point on the surface, in the surface's own frame [m]
  std::int32_t pulses_left = 0;
  ContactState state = ContactState::kFree;
};

[[nodiscard]] inline double magnitude(double a) noexcept { return std::fabs(a); }
template <typename Vector>
[[nodiscard]] inline double magnitude(const Vector& a) noexcept {
  return std::sqrt(inner(a, a));
}

/// Number of braking pulses (7.2): the largest whole number smaller than m_h v_c / (T F_max), so
/// the pulses never carry more momentum than arrived. `approach` v_c > 0 [m/s].
[[nodiscard]] inline std::int32_t braking_pulses(const ContactGains& gains, double approach,
                                                 double T) noexcept {
  if (!gains.moment_cancellation || !(gains.pulse_force > 0.0) || !(approach > 0.0)) return 0;
  const double ratio = gains.mass * approach / (T * gains.pulse_force);
  if (!(ratio > 1.0)) return 0;
  if (ratio > 1e6) return 1000000;
  const auto whole = static_cast<std::int32_t>(ratio);
  return static_cast<double>(whole) == ratio ? whole - 1 : whole;
}

/// Slide (7.4): |f_t| = mu_k f_n against the slip. The slip is the velocity, but for a spring that
/// leaves the cone below v_tr: it slips along its own stretch, whatever the noise of the velocity.
/// The contact point is dragged after the point until k_t |stretch| <= mu_k f_n. The drag never
/// adds stretch: that grows by motion alone, and what it lacks to mu_k f_n is plain dissipation, so
/// a closed path never returns more work than was put in (elasto-plastic, Hayward & Armstrong
/// 2000).
template <typename Tangent>
[[nodiscard]] inline Tangent slide_force(ContactMemory<Tangent>& memory, const ContactGains& gains,
                                         const SurfaceMotion<Tangent>& at, double normal,
                                         double speed) noexcept {
  const Tangent stretch = at.position - memory.anchor;
  const double length = magnitude(stretch);
  const double limit = gains.friction.dynamic_coefficient * normal;
  const double k = gains.tangential.stiffness;
  const bool by_velocity =
      speed > gains.friction.threshold_velocity || (k * length <= limit && speed > 0.0);
  const Tangent along = by_velocity ? at.velocity * (1.0 / speed) : stretch * (1.0 / length);
  double kept = length;
  if (k * kept > limit) kept = limit / k;
  memory.anchor = at.position - along * kept;
  return along * -limit;
}

/// One tick of one contact.
///   normal:    f_n = max(0, k d - b v_n)                     never pulls (thesis (7.3) would)
///   pulses:    f_n = F_max, f_t = 0                          (7.1), (7.2)
///   pre-slide: f_t = -k_t (x - anchor) - b_t v_t             (7.3), while |f_t| <= mu_s f_n
///   slide:     |f_t| = mu_k f_n against the slip             (7.4), until |v_t| <= v_tr
///
/// Moment cancellation begins at first touch and ends with the counted pulses, when the approach
/// velocity changes sign, or when less momentum is left than one pulse takes. The pulse replaces
/// the penalty force and acts on both sides, equal and opposite: so momentum is conserved, the
/// device is asked for F_max and never more, and a light object is pushed along as a real one
/// would be. (Braking the finger alone, as the thesis may be read, lets momentum vanish and gives
/// the hand energy when the object is what moves.) The object's impulse is at most m_h v_c.
///
/// Every tick: f_n >= 0, |f_t| <= mu_s f_n; first tick of a touch: zero stretch.
/// Always inlined: as a call it takes a fifth of a planar tick to pass its values through memory.
template <typename Tangent>
[[nodiscard, gnu::always_inline]] inline SurfaceForce<Tangent> press(
    ContactMemory<Tangent>& memory, const ContactGains& gains, const SurfaceMotion<Tangent>& at,
    double T) noexcept {
  if (!(at.depth > 0.0)) {
    memory.state = ContactState::kFree;
    return {};
  }
  if (memory.state == ContactState::kFree) {
    memory.anchor = at.position;
    memory.pulses_left = braking_pulses(gains, -at.normal_velocity, T);
    memory.state =
        memory.pulses_left > 0 ? ContactState::kMomentCancellation : ContactState::kPreSlide;
  }
  if (memory.state == ContactState::kMomentCancellation) {
    const double left = -at.normal_velocity * gains.mass;  // momentum still arriving [N s]
    if (memory.pulses_left > 0 && left >= T * gains.pulse_force) {
      --memory.pulses_left;
      return {gains.pulse_force, Tangent{0.0}};
    }
    memory.state = ContactState::kPreSlide;
  }

  const double penalty =
      gains.normal.stiffness * at.depth - gains.normal.damping * at.normal_velocity;
  const double normal = penalty > 0.0 ? penalty : 0.0;
  const double static_limit = gains.friction.static_coefficient * normal;
  if (gains.friction.static_coefficient <= 0.0) {
    memory.state = ContactState::kSlide;
    memory.anchor = at.position;
    return {normal, Tangent{0.0}};
  }

  const double speed = magnitude(at.velocity);
  if (memory.state == ContactState::kSlide && speed <= gains.friction.threshold_velocity)
    memory.state = ContactState::kPreSlide;
  if (memory.state == ContactState::kPreSlide) {
    const Tangent held = (at.position - memory.anchor) * -gains.tangential.stiffness -
                         at.velocity * gains.tangential.damping;
    if (inner(held, held) <= static_limit * static_limit) return {normal, held};
    memory.state = ContactState::kSlide;
  }
  return {normal, slide_force(memory, gains, at, normal, speed)};
}

}  // namespace tandem::core
