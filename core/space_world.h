#pragma once

#include <array>
#include <cmath>
#include <cstdint>

#include "core/finger_sample.h"
#include "core/reconstruction.h"
#include "core/space_body.h"
#include "core/space_contact.h"
#include "core/space_coordination.h"
#include "core/space_wall.h"

namespace tandem::core {

/// Physics of a spatial scene: finger spheres, boxes and spheres that move and turn in space, plane
/// walls. One of the three worlds; see AxisWorld for what a world is. Ground friction is a matter
/// of the plane: here the ground is a wall with friction, and objects have weight where the scene
/// declares it.
class SpaceWorld {
 public:
  static constexpr Space kSpace = Space::kSpace;
  using Vector = Vec3;
  using Body = SpaceBody;
  using Placed = PlacedSpaceBody;
  using Wrench = SpaceWrench;

  struct Grasp {
    bool present = false;
    bool is_attached = false;
    ContactGains gains;
    SpaceShape shape;
    AttachedSpaceContact attached;
  };
  struct Coordination {
    Gain linear, rotation;
    bool present = false;
  };
  using Contact = FingerSpaceContact;
  using ObjectWalls = std::array<SpaceWallContacts, kMaxWalls>;
  using FingerWalls = std::array<ContactMemory<Vec3>, kMaxWalls>;

  struct Touch {
    Vec3 on_finger{0.0};
    SpaceWrench on_body;
  };

  SpaceWorld() noexcept = default;
  SpaceWorld(const Scene& scene, double mass_share) noexcept
      : T_(scene.tick()),
        integrator_(scene.integrator),
        object_count_(static_cast<int>(scene.objects.size())),
        wall_count_(static_cast<int>(scene.walls.size())) {
    for (int o = 0; o < object_count_; ++o) {
      objects_[o] =
          space_body_parameters(scene.objects[o], scene.weight ? scene.gravity : 0.0, mass_share);
      shapes_[o] = shape_of(scene.objects[o], 0.0);
    }
    for (int w = 0; w < wall_count_; ++w) {
      const WallParameters& wall = scene.walls[w];
      const double length = std::sqrt(inner(wall.normal, wall.normal));
      walls_[w] = {{wall.point, wall.normal * (1.0 / length),
                    ContactGains{wall.gain, wall.tangential, wall.friction}},
                   wall.touches_objects,
                   wall.touches_fingers};
    }
  }

  [[nodiscard]] static Body initial_body(const ObjectParameters& object) noexcept {
    return {object.position, normalised(object.orientation), object.velocity,
            object.angular_velocity};
  }
  [[nodiscard]] static Placed place(const Body& body) noexcept { return PlacedSpaceBody(body); }

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
    g.shape = shape_of(object, finger.radius);
    g.attached =
        attach(g.shape, place(initial_body(object)), SpacePoint{finger.position, Vec3{0.0}});
    return g;
  }

  [[nodiscard]] static Coordination coordination(const CouplerParameters& c) noexcept {
    return {c.gain, c.rotation, c.gain.any() || c.rotation.any()};
  }

  [[nodiscard]] Touch touch(int, Contact& contact, const Grasp& g, const FingerSample<Vec3>& finger,
                            const Placed& body) const noexcept {
    const SpacePoint point{finger.p, finger.v};
    const SpaceContactForces f =
        g.is_attached ? hold(g.attached, g.gains.normal, g.gains.tangential, body, point)
                      : core::touch(contact, g.gains, g.shape, body, point, T_);
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
        wrench += hold_back(memory[w], walls_[w].wall, shapes_[o], body, T_, mean);
    return wrench;
  }

  /// `radius`: of the finger [m]; its surface is held back, not its centre.
  [[nodiscard]] Vector walls_on_finger(FingerWalls& memory, const FingerSample<Vec3>& finger,
                                       double radius) const noexcept {
    Vec3 force{0.0};
    for (int w = 0; w < wall_count_; ++w)
      if (walls_[w].fingers)
        force += hold_back(memory[w], walls_[w].wall, SpacePoint{finger.p, finger.v}, radius, T_);
    return force;
  }

  [[nodiscard]] Body step(int o, const Body& body, const Wrench& wrench) const noexcept {
    return core::step(objects_[o], integrator_, T_, body, wrench);
  }

  [[nodiscard]] static Body advance(const Body& b, const Advance& a) noexcept {
    return {b.p + b.v * a.time, rotation_by(b.omega * a.time) * b.q, b.v * a.keep,
            b.omega * a.keep};
  }
  /// The way from `b` to `a`; its q is the rotation, in W, that turns b into a.
  [[nodiscard]] static Body difference(const Body& a, const Body& b) noexcept {
    return {a.p - b.p, a.q * glm::conjugate(b.q), Vec3{0.0}, Vec3{0.0}};
  }
  [[nodiscard]] static Body moved_back(const Body& b, const Body& offset, double part) noexcept {
    return {b.p - offset.p * part, rotation_by(rotation_vector(offset.q) * -part) * b.q, b.v,
            b.omega};
  }
  [[nodiscard]] static Wrench scaled(const Wrench& w, double factor) noexcept {
    return {w.force * factor, w.torque * factor};
  }
  [[nodiscard]] static double work(const Wrench& w, const Body& a, const Body& b) noexcept {
    return inner(w.force, b.p - a.p) + inner(w.torque, rotation_between(a.q, b.q));
  }
  /// The two bits of the side hold the axis of the touched face, 0 x, 1 y, 2 z (its sign shows in
  /// where the finger is), or 3 for a sphere.
  [[nodiscard]] static std::uint32_t contact_bits(const Contact& contact) noexcept {
    const bool touches = contact.memory.state != ContactState::kFree;
    return with_contact(0, 0, contact.memory.state, touches ? contact.face >> 1 : 0);
  }

  template <typename Visitor>
  static void visit_body(Body& body, Visitor&& visitor) {
    visitor.position(body.p);
    visitor.orientation(body.q);
    visitor.velocity(body.v);
    visitor.angular_velocity(body.omega);
  }

  [[nodiscard]] int object_count() const noexcept { return object_count_; }
  [[nodiscard]] bool has_walls() const noexcept { return wall_count_ > 0; }

 private:
  struct Wall {
    SpaceWall wall;
    bool objects = false, fingers = false;
  };

  double T_ = 0.0;
  Integrator integrator_ = Integrator::kZeroOrderHold;
  int object_count_ = 0, wall_count_ = 0;
  std::array<SpaceBodyParameters, kMaxObjects> objects_{};
  std::array<SpaceShape, kMaxObjects> shapes_{};
  std::array<Wall, kMaxWalls> walls_{};
};

}  // namespace tandem::core
