#include "bench/error_tandem.h"

#include <memory>
#include <stdexcept>
#include <utility>

#include "arch_central/central_loop.h"
#include "bench/error_wall.h"
#include "core/axis_world.h"
#include "core/plane_world.h"
#include "core/space_world.h"

namespace tandem::bench {
namespace {

using core::Integrator;

constexpr std::pair<const char*, Integrator> kIntegrators[] = {
    {"zero_order_hold", Integrator::kZeroOrderHold},
    {"semi_implicit_euler", Integrator::kSemiImplicitEuler},
    {"explicit_euler", Integrator::kExplicitEuler},
    {"exact_coupler", Integrator::kExactCoupler}};

core::ObjectParameters object_named(const char* name, double mass) {
  core::ObjectParameters object;
  object.name = name;
  object.mass = mass;
  return object;
}

core::UserParameters user_named(const char* name) {
  core::UserParameters user;
  user.name = name;
  user.mass = kHandMass;
  user.local = true;
  user.fingers.resize(1);
  user.fingers[0].name = "f";
  return user;
}

void add_user(core::Scene& scene, const char* name, const ErrorPoint& point) {
  scene.users.push_back(user_named(name));
  core::CouplerParameters coupler;
  coupler.name = std::string("k") + name;
  coupler.object = "box";
  coupler.user = name;
  coupler.gain = {point.stiffness, point.damping};
  scene.couplers.push_back(coupler);
}

core::Scene base_scene(int hz, Integrator integrator, core::Space space) {
  core::Scene scene;
  scene.name = "bench_error";
  scene.space = space;
  scene.architecture = core::Architecture::kCentral;  // everyone at the server: no packets
  scene.rates = {static_cast<double>(hz), static_cast<double>(hz), 0};
  scene.integrator = integrator;
  return scene;
}

core::Scene scene_of(const ErrorPoint& point, Integrator integrator, int hz) {
  switch (point.which) {
    case Case::kMasses:
    case Case::kHands: {
      core::Scene scene = base_scene(hz, integrator, core::Space::kAxis);
      scene.objects.push_back(object_named("box", kObjectMass));
      add_user(scene, "1", point);
      if (point.which == Case::kMasses) {
        scene.objects[0].velocity.x = kThrown;
        return scene;
      }
      add_user(scene, "2", point);
      for (int u = 0; u < 2; ++u) scene.users[u].fingers[0].intent.force.x = kPushed[u];
      return scene;
    }
    case Case::kWall: {
      core::Scene scene = base_scene(hz, integrator, core::Space::kAxis);
      scene.objects.push_back(object_named("box", kObjectMass));
      scene.objects[0].velocity.x = kFlight;
      scene.users.push_back(user_named("1"));  // stands by
      core::WallParameters wall;
      wall.name = "wall";
      wall.point.x = kGap;
      wall.normal.x = -1.0;
      wall.gain = {point.stiffness, point.damping};
      scene.walls.push_back(wall);
      return scene;
    }
    case Case::kStickSlip: {
      // A finger pressed on a wall and drawn along it by the hand's own spring. Its end moves along
      // a sine so slow that its first second is straight to 1e-10 of the way.
      core::Scene scene = base_scene(hz, integrator, core::Space::kPlane);
      scene.contact.attached = false;
      core::WallParameters wall;
      wall.name = "floor";
      wall.normal.y = 1.0;
      wall.gain = {3000.0, 5.0};
      wall.tangential = {point.stiffness, point.damping};
      wall.friction = {kSticks, kSlips, 0.005};
      wall.touches_fingers = true;
      wall.touches_objects = false;
      scene.walls.push_back(wall);
      core::UserParameters user = user_named("1");
      core::FingerParameters& finger = user.fingers[0];
      finger.position.y = -kNormalForce / wall.gain.stiffness;
      finger.hand = {kDrawSpring, 0.0};
      finger.intent.force.y = -kNormalForce;
      constexpr double kSlow = 2e-5;  // [rad/s]
      core::SinePart draw;
      draw.amplitude = kDrawSpeed / kSlow;
      draw.omega = kSlow;
      draw.direction.x = 1.0;
      finger.intent.path_sines.push_back(draw);
      scene.users.push_back(user);
      return scene;
    }
    case Case::kSlide: {
      core::Scene scene = base_scene(hz, integrator, core::Space::kPlane);
      core::ObjectParameters box = object_named("box", kObjectMass);
      box.shape = core::Shape::kBox;
      box.size = {kBoxSize, kBoxSize, 0.0};
      box.velocity = {kSlideSpeed[0], kSlideSpeed[1], 0.0};
      box.ground_friction = kSlideFriction;
      scene.objects.push_back(box);
      scene.users.push_back(user_named("1"));
      return scene;
    }
    case Case::kSpin: {
      core::Scene scene = base_scene(hz, integrator, core::Space::kSpace);
      core::ObjectParameters box = object_named("box", kObjectMass);
      box.shape = core::Shape::kBox;
      box.size = {kBoxSize, kBoxSize, kBoxSize};
      box.inertia = {kMoments[0], kMoments[1], kMoments[2]};
      box.angular_velocity = {kSpin[0], kSpin[1], kSpin[2]};
      scene.objects.push_back(box);
      scene.users.push_back(user_named("1"));
      return scene;
    }
  }
  throw std::logic_error("no such case");
}

/// A session in its loop. Laws are trivially copied into place; nothing is allocated in step().
template <typename World>
class Model {
 public:
  Model(const ErrorPoint& point, const core::Scene& scene) : which_(point.which), loop_(scene) {}

  void step() noexcept { loop_.tick(); }
  void sample(double* out) const noexcept {
    const auto hand = [this, &out](int user) {
      const auto& finger = loop_.hands().finger(user, 0);
      put(out, finger.position(), finger.velocity());
    };
    if (which_ == Case::kStickSlip) {
      const auto& finger = loop_.hands().finger(0, 0);
      *out++ = core::component(finger.position(), 0);
      *out++ = core::component(finger.velocity(), 0);
      return;
    }
    if (which_ == Case::kMasses || which_ == Case::kHands) hand(0);
    const auto& body = loop_.object(0, 0);
    if constexpr (World::kSpace == core::Space::kSpace) {
      for (const double x :
           {body.q.w, body.q.x, body.q.y, body.q.z, body.omega.x, body.omega.y, body.omega.z})
        *out++ = x;
    } else {
      put(out, body.p, body.v);
    }
    if (which_ == Case::kHands) hand(1);
  }

 private:
  template <typename V>
  static void put(double*& out, const V& p, const V& v) noexcept {
    for (int i = 0; i < core::kComponents<V>; ++i) *out++ = core::component(p, i);
    for (int i = 0; i < core::kComponents<V>; ++i) *out++ = core::component(v, i);
  }

  Case which_;
  central::CentralLoop<World> loop_;
};

template <typename World>
ErrorRun run_loop(const ErrorPoint& point, Integrator integrator, int hz) {
  const core::Scene scene = scene_of(point, integrator, hz);
  return measure(point, hz, [&] { return std::make_unique<Model<World>>(point, scene); });
}

}  // namespace

std::vector<Scheme> schemes_of(const ErrorPoint& point) {
  if (point.which == Case::kStickSlip) return {{"contact_law", true, true}};
  std::vector<Scheme> out;
  for (const auto& [name, integrator] : kIntegrators) {
    const bool linear = point.which == Case::kMasses || point.which == Case::kHands;
    if (integrator == Integrator::kExactCoupler && !linear) continue;
    out.push_back({name, integrator == core::Scene{}.integrator, true});
  }
  if (point.which == Case::kWall)
    for (const WallScheme& candidate : kWallSchemes) out.push_back({candidate.name, false, false});
  return out;
}

ErrorRun run_tandem(const ErrorPoint& point, const Scheme& scheme, int hz) {
  if (!scheme.in_tandem) {
    for (const WallScheme& candidate : kWallSchemes)
      if (scheme.name == candidate.name)
        return measure(point, hz,
                       [&] { return std::make_unique<BareWall>(point, candidate, 1.0 / hz); });
    throw std::logic_error("no such scheme: " + scheme.name);
  }
  Integrator integrator = core::Scene{}.integrator;
  for (const auto& [name, value] : kIntegrators)
    if (scheme.name == name) integrator = value;
  switch (point.which) {
    case Case::kMasses:
    case Case::kHands:
    case Case::kWall:
      return run_loop<core::AxisWorld>(point, integrator, hz);
    case Case::kStickSlip:
    case Case::kSlide:
      return run_loop<core::PlaneWorld>(point, integrator, hz);
    case Case::kSpin:
      return run_loop<core::SpaceWorld>(point, integrator, hz);
  }
  throw std::logic_error("no such case");
}

}  // namespace tandem::bench
