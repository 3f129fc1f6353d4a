#pragma once

#include <array>
#include <cstdint>

#include "core/coordination.h"
#include "core/finger_sample.h"
#include "core/plane_body.h"
#include "core/plane_contact.h"
#include "core/reconstruction.h"

namespace tandem::core {

/// Physics of a planar scene (thesis chapter 7): finger points, boxes that move in x, y and turn,
/// walls that are half planes. One of the three worlds; see AxisWorld for what a world is.
class PlaneWorld {
 public:
  static constexpr Space kSpace = Space::kPlane;
  using Vector = Vec2;
  using Body = PlaneBody;
  using Placed = PlacedBody;
  using Wrench = PlaneWrench;

  struct Grasp {
    bool present = false;
    bool is_attached = false;
    ContactGains gains;
    PlaneBox box;
    AttachedContact attached;
  };
  struct Coordination {
    Gain linear, rotation;
    bool present = false;
  };
  using Contact = FingerBoxContact;
  using ObjectWalls = std::array<WallContacts, kMaxWalls>;
  using FingerWalls = std::array<ContactMemory<double>, kMaxWalls>;

  struct Touch {
    Vec2 on_finger{0.0};
    PlaneWrench on_body;
  };

  PlaneWorld() noexcept = default;
  PlaneWorld(const Scene& scene, double mass_share) noexcept
      : T_(scene.tick()),
        integrator_(scene.integrator),
        object_count_(static_cast<int>(scene.objects.size())),
        wall_count_(static_cast<int>(scene.walls.size())) {
    for (int o = 0; o < object_count_; ++o) {
      objects_[o] = plane_body_parameters(scene.objects[o], scene.gravity, mass_share);
      boxes_[o] = box_of(scene.objects[o], 0.0);
    }
    for (int w = 0; w < wall_count_; ++w) {
      const WallParameters& wall = scene.walls[w];
      walls_[w] = {{from_vec3<Vec2>(wall.point), from_vec3<Vec2>(wall.normal),
                    ContactGains{wall.gain, wall.tangential, wall.friction}},
                   wall.touches_objects,
                   wall.touches_fingers};
    }
  }

  [[nodiscard]] static Body initial_body(const ObjectParameters& object) noexcept {
    return {from_vec3<Vec2>(object.position), object.angle, from_vec3<Vec2>(object.velocity),
            object.angular_velocity.z};
  }
  [[nodiscard]] static Placed place(const Body& body) noexcept { return PlacedBody(body); }

  /// `own`: the finger belongs to this machine's loop, so braking pulses reach it at the local
  /// rate.
  [[nodiscard]] static Grasp grasp(const Scene& scene, const CouplerParameters& coupler,
                                   const FingerParameters& finger, const ObjectParameters& object,
                                   double user_mass, bool own) noexcept {
    Grasp g;
    g.present = coupler.gain.any() || coupler.tangential.any();
    g.is_attached = scene.contact.attached;
    g.gains = {coupler.gain,
               coupler.tangential,
               scene.contact.friction,
               own && scene.contact.moment_cancellation,
               scene.contact.pulse_force,
               user_mass};
    g.box = box_of(object, finger.radius);
    g.attached = attach(g.box, place(initial_body(object)),
                        PlanePoint{from_vec3<Vec2>(finger.position), Vec2{0.0}});
    return g;
  }

  [[nodiscard]] static Coordination coordination(const CouplerParameters& c) noexcept {
    return {c.gain, c.rotation, c.gain.any() || c.rotation.any()};
  }

  [[nodiscard]] Touch touch(int, Contact& contact, const Grasp& g, const FingerSample<Vec2>& finger,
                            const Placed& body) const noexcept {
    const PlanePoint point{finger.p, finger.v};
    const ContactForces f = g.is_attached
                                ? hold(g.attached, g.gains.normal, g.gains.tangential, body, point)
                                : core::touch(contact, g.gains, g.box, body, point, T_);
    return {f.on_finger_W, f.on_body};
  }

  [[nodiscard]] static Wrench coordinate(const Coordination& c, const Body& self,
                                         const Body& other) noexcept {
    return core::coordinate(c.linear, c.rotation, self, other);
  }

  [[nodiscard]] Wrench walls_on_object(int o, ObjectWalls& memory,
                                       const Placed& body) const noexcept {
    Wrench wrench;
    const bool mean = takes_mean_contact(integrator_);
    for (int w = 0; w < wall_count_; ++w)
      if (walls_[w].objects)
        wrench += hold_back(memory[w], walls_[w].wall, boxes_[o], body, T_, mean);
    return wrench;
  }

  [[nodiscard]] Vector walls_on_finger(FingerWalls& memory, const FingerSample<Vec2>& finger,
                                       double radius) const noexcept {
    Vec2 force{0.0};
    for (int w = 0; w < wall_count_; ++w)
      if (walls_[w].fingers)
        force += hold_back(memory[w], walls_[w].wall, PlanePoint{finger.p, finger.v}, radius, T_);
    return force;
  }

  [[nodiscard]] Body step(int o, const Body& body, const Wrench& wrench) const noexcept {
    return core::step(objects_[o], integrator_, T_, body, wrench);
  }

  [[nodiscard]] static Body advance(const Body& b, const Advance& a) noexcept {
    return {b.p + b.v * a.time, b.angle + b.omega * a.time, b.v * a.keep, b.omega * a.keep};
  }
  /// The way from `b` to `a`; whole turns are left out, as the coupler leaves them out.
  [[nodiscard]] static Body difference(const Body& a, const Body& b) noexcept {
    return {a.p - b.p, twist(a.angle, b.angle), Vec2{0.0}, 0.0};
  }
  [[nodiscard]] static Body moved_back(const Body& b, const Body& offset, double part) noexcept {
    return {b.p - offset.p * part, b.angle - offset.angle * part, b.v, b.omega};
  }
  [[nodiscard]] static Wrench scaled(const Wrench& w, double factor) noexcept {
    return {w.force * factor, w.torque * factor};
  }
  [[nodiscard]] static double work(const Wrench& w, const Body& a, const Body& b) noexcept {
    return inner(w.force, b.p - a.p) + w.torque * (b.angle - a.angle);
  }
  [[nodiscard]] static std::uint32_t contact_bits(const Contact& contact) noexcept {
    const bool touches = contact.memory.state != ContactState::kFree;
    return with_contact(0, 0, contact.memory.state, touches ? contact.side : 0);
  }

  template <typename Visitor>
  static void visit_body(Body& body, Visitor&& visitor) {
    visitor.position(body.p);
    visitor.angle(body.angle);
    visitor.velocity(body.v);
    visitor.angular_velocity(body.omega);
  }

  [[nodiscard]] int object_count() const noexcept { return object_count_; }
  [[nodiscard]] bool has_walls() const noexcept { return wall_count_ > 0; }

 private:
  struct Wall {
    PlaneWall wall;
    bool objects = false, fingers = false;
  };

  [[nodiscard]] static PlaneBox box_of(const ObjectParameters& object, double radius) noexcept {
    return {{0.5 * object.size.x, 0.5 * object.size.y}, radius};
  }

  double T_ = 0.0;
  Integrator integrator_ = Integrator::kZeroOrderHold;
  int object_count_ = 0, wall_count_ = 0;
  std::array<PlaneBodyParameters, kMaxObjects> objects_{};
  std::array<PlaneBox, kMaxObjects> boxes_{};
  std::array<Wall, kMaxWalls> walls_{};
};

}  // namespace tandem::core
