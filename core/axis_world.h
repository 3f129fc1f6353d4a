#pragma once

#include <array>
#include <cstdint>

#include "core/axis_state.h"
#include "core/finger_sample.h"
#include "core/held_step.h"
#include "core/integrate.h"
#include "core/mean_contact.h"
#include "core/reconstruction.h"
#include "core/scene.h"

namespace tandem::core {

/// Physics of an axis scene: hands and objects are points on a line (thesis Figs 3.1, 4.3, 4.4).
/// One of the three worlds; the laws of arch_central/ and arch_distributed/ are written once over
/// them. Trivially copyable; built from a validated scene before the session.
///
/// Integrator kExactCoupler: the fingers of the own machine are led by half a tick,
///   p + v T / 2,  v + (v - v of the tick before) / 2        (standing before the first tick)
/// and object and couplers to these are integrated together, exactly (core/held_step.h); walls,
/// copies and remote hands stay held forces. Finger and object are given the mean force of the
/// tick, equal and opposite. Second order in T; stable on the object's side for any stiffness. The
/// lead returns the damping K T / 2 that a held force takes away: a hand of mass m on a heavy
/// object stays stable far beyond 2 b / T, and for b < m / T. It trusts the finger's velocity.
class AxisWorld {
 public:
  static constexpr Space kSpace = Space::kAxis;
  using Vector = double;  ///< of a finger: position, velocity, force
  using Body = AxisState;
  using Placed = AxisState;  ///< a body with what all its contacts of a tick share
  using Wrench = double;

  /// Coupler between one finger and one object.
  struct Grasp {
    Gain gain;
    double offset = 0.0;  ///< rest distance finger minus object [m]
    double side = 0.0;    ///< 0: attached; +-1: unilateral, the finger pushes towards -side
    bool present = false;
    bool exact = false;  ///< integrated together with the object
    double lead = 0.0;   ///< exact: half a tick [s]
  };
  struct Coordination {
    Gain gain;
    bool present = false;
  };
  struct Contact {
    double before = 0.0;  ///< exact: the finger's velocity at the tick before [m/s]
  };
  struct ObjectWalls {};
  struct FingerWalls {};

  /// Force of a coupler, named by what it acts on; on_finger = -on_body.
  struct Touch {
    double on_finger = 0.0;
    double on_body = 0.0;
  };

  AxisWorld() noexcept = default;
  /// `mass_share`: part of each object's mass that this copy carries, 1 or 1/N.
  AxisWorld(const Scene& scene, double mass_share) noexcept
      : T_(scene.tick()),
        integrator_(scene.integrator),
        object_count_(static_cast<int>(scene.objects.size())),
        wall_count_(static_cast<int>(scene.walls.size())) {
    for (int o = 0; o < object_count_; ++o) {
      const ObjectParameters& object = scene.objects[o];
      const double mass = object.mass * mass_share;
      objects_[o] = {
          1.0 / mass, object.compensation,    object.ground_friction * scene.gravity, 0.0,
          0.0,        held_step(0.0, 0.0, T_)};
    }
    for (int w = 0; w < wall_count_; ++w) {
      const WallParameters& wall = scene.walls[w];
      walls_[w] = {wall.gain,     wall.point.x,         wall.normal.x < 0.0 ? -1.0 : 1.0,
                   wall.attached, wall.touches_objects, wall.touches_fingers};
    }
  }

  [[nodiscard]] static Body initial_body(const ObjectParameters& object) noexcept {
    return {object.position.x, object.velocity.x};
  }

  [[nodiscard]] static Placed place(const Body& body) noexcept { return body; }

  [[nodiscard]] static Grasp grasp(const Scene& scene, const CouplerParameters& coupler,
                                   const FingerParameters& finger, const ObjectParameters& object,
                                   double /*user_mass*/, bool own) noexcept {
    Grasp g{coupler.gain, 0.0, 0.0, coupler.gain.stiffness > 0.0 || coupler.gain.damping > 0.0};
    g.exact = own && scene.integrator == Integrator::kExactCoupler;
    if (g.exact) g.lead = 0.5 * scene.tick();
    const double distance = finger.position.x - object.position.x;
    if (scene.contact.attached)
      g.offset = distance;
    else
      g.side = distance < 0.0 ? -1.0 : 1.0;
    return g;
  }

  [[nodiscard]] static Coordination coordination(const CouplerParameters& coupler) noexcept {
    return {coupler.gain, coupler.gain.stiffness > 0.0 || coupler.gain.damping > 0.0};
  }

  /// f_O = K (x_H - x_O) + B (v_H - v_O), f_H = -f_O (3.4, 4.28 without the mirrored axis).
  /// Unilateral when the contact is not attached: the normal force never pulls.
  [[nodiscard]] Touch touch(int, Contact& contact, const Grasp& g,
                            const FingerSample<double>& finger, const Body& body) const noexcept {
    double stretch = finger.p - body.p - g.offset;
    double rate = finger.v - body.v;
    if (g.exact) {
      stretch += finger.v * g.lead;
      rate += 0.5 * (finger.v - contact.before);
      contact.before = finger.v;
    }
    double on_body = g.gain.stiffness * stretch + g.gain.damping * rate;
    if (g.side != 0.0) {
      const bool inside = g.side * stretch < 0.0;
      if (!inside || g.side * on_body > 0.0) on_body = 0.0;
    }
    return {-on_body, on_body};
  }

  /// Force on this copy that pulls it to another: K_o (x_other - x_self) + B_o (v_other - v_self).
  [[nodiscard]] static Wrench coordinate(const Coordination& c, const Body& self,
                                         const Body& other) noexcept {
    return c.gain.stiffness * (other.p - self.p) + c.gain.damping * (other.v - self.v);
  }

  /// Walls that open are met within the tick (core/mean_contact.h) where forces are held.
  [[nodiscard]] Wrench walls_on_object(int, ObjectWalls&, const Body& body) const noexcept {
    double force = 0.0;
    for (int w = 0; w < wall_count_; ++w) {
      const Wall& wall = walls_[w];
      if (!wall.objects) continue;
      if (wall.attached || !takes_mean_contact(integrator_)) {
        force += push(wall, body.p, body.v);
        continue;
      }
      const MeanContact mean =
          mean_contact(wall.normal * (wall.point - body.p), wall.normal * body.v, T_);
      const double f = wall.gain.stiffness * mean.depth - wall.gain.damping * mean.normal_velocity;
      if (mean.depth > 0.0 && f > 0.0) force += wall.normal * f;
    }
    return force;
  }

  [[nodiscard]] Vector walls_on_finger(
      FingerWalls&, const FingerSample<double>& finger,
      double /*radius: a finger on an axis is a point*/) const noexcept {
    double force = 0.0;
    for (int w = 0; w < wall_count_; ++w)
      if (walls_[w].fingers) force += push(walls_[w], finger.p, finger.v);
    return force;
  }

  /// Couplers of object `o` that kExactCoupler integrates with it: the sum of their gains.
  void hold(int o, const Gain& sum) noexcept {
    Object& object = objects_[o];
    object.stiffness = sum.stiffness * object.inverse_mass;
    object.damping = sum.damping * object.inverse_mass;
    object.held = held_step(object.stiffness, object.damping, T_);
  }
  [[nodiscard]] bool holds_exactly() const noexcept {
    return integrator_ == Integrator::kExactCoupler;
  }
  /// By how much position and velocity of object `o` over the tick differ in the mean from those at
  /// its start, where `touch` was evaluated. `force` is what `step` was given.
  [[nodiscard]] Body mean_change(int o, const Body& before, Wrench force) const noexcept {
    const Object& object = objects_[o];
    const double u = input(object, before, force);
    return {object.held.mean_v * before.v + object.held.mean_u * u,
            (object.held.y_v * before.v + object.held.y_u * u) / T_ - before.v};
  }
  /// What that takes away from the force of one coupler on the object.
  [[nodiscard]] static Wrench given_way(const Grasp& g, const Body& change) noexcept {
    return g.exact ? g.gain.stiffness * change.p + g.gain.damping * change.v : 0.0;
  }

  /// One tick of an object: compensation (negative damping, chapter 6) is evaluated at the tick and
  /// held.
  [[nodiscard]] Body step(int o, const Body& body, Wrench force) const noexcept {
    const Object& object = objects_[o];
    if (integrator_ == Integrator::kExactCoupler) {
      // The velocity from the mean force, which the fingers are given too: momentum is kept to
      // rounding, and the roundings of v_v and v_u do not add up.
      const double u = input(object, body, force);
      const Body change = mean_change(o, body, force);
      const double a = (force + object.compensation * body.v) * object.inverse_mass;
      return {body.p + object.held.y_v * body.v + object.held.y_u * u,
              body.v + T_ * (a - object.stiffness * change.p - object.damping * change.v)};
    }
    if (object.compensation != 0.0) force += object.compensation * body.v;
    Body next = body;
    core::advance(integrator_, T_, object.friction, next.p, next.v, force * object.inverse_mass);
    return next;
  }

  [[nodiscard]] static Body advance(const Body& body, const Advance& a) noexcept {
    return {body.p + body.v * a.time, body.v * a.keep};
  }

  /// Difference of two poses, and a pose moved back by a part of one: re-seating a coupler.
  [[nodiscard]] static Body difference(const Body& a, const Body& b) noexcept {
    return {a.p - b.p, 0.0};
  }
  [[nodiscard]] static Body moved_back(const Body& body, const Body& offset, double part) noexcept {
    return {body.p - part * offset.p, body.v};
  }
  [[nodiscard]] static Wrench scaled(Wrench force, double factor) noexcept {
    return force * factor;
  }
  /// Work of `force` over the way from `a` to `b` [J].
  [[nodiscard]] static double work(const Wrench& force, const Body& a, const Body& b) noexcept {
    return force * (b.p - a.p);
  }
  [[nodiscard]] static std::uint32_t contact_bits(const Contact&) noexcept { return 0; }

  template <typename Visitor>
  static void visit_body(Body& body, Visitor&& visitor) {
    visitor.position(body.p);
    visitor.velocity(body.v);
  }

  [[nodiscard]] int object_count() const noexcept { return object_count_; }
  [[nodiscard]] bool has_walls() const noexcept { return wall_count_ > 0; }

 private:
  struct Object {
    double inverse_mass = 0.0;
    double compensation = 0.0;
    double friction = 0.0;   ///< deceleration by ground friction, mu g [m/s^2]
    double stiffness = 0.0;  ///< of `held`, by mass [1/s^2]
    double damping = 0.0;    ///< of `held`, by mass [1/s]
    HeldStep held;           ///< of kExactCoupler
  };
  /// Acceleration at the start of the tick, with the dampers' part of the start taken out: the
  /// held step counts damping from standstill.
  [[nodiscard]] static double input(const Object& object, const Body& body, Wrench force) noexcept {
    return (force + object.compensation * body.v) * object.inverse_mass + object.damping * body.v;
  }
  struct Wall {
    Gain gain;
    double point = 0.0;
    double normal = 1.0;
    bool attached = false, objects = false, fingers = false;
  };

  /// Penalty of a wall; unilateral and never pulling unless attached.
  [[nodiscard]] static double push(const Wall& wall, double p, double v) noexcept {
    const double depth = wall.normal * (wall.point - p);
    const double f = wall.gain.stiffness * depth - wall.gain.damping * wall.normal * v;
    if (!wall.attached && (depth <= 0.0 || f <= 0.0)) return 0.0;
    return wall.normal * f;
  }

  double T_ = 0.0;
  Integrator integrator_ = Integrator::kZeroOrderHold;
  int object_count_ = 0, wall_count_ = 0;
  std::array<Object, kMaxObjects> objects_{};
  std::array<Wall, kMaxWalls> walls_{};
};

}  // namespace tandem::core
