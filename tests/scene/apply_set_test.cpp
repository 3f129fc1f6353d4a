#include "scene/apply_set.h"

#include <gtest/gtest.h>

#include "tests/scene/scene_testing.h"

namespace tandem::scene {
namespace {

using testing::contains;
using testing::error_of_named;

core::Scene edited(const std::string& name, const std::vector<std::string>& sets) {
  return load_scene(name, sets);
}

TEST(Set, ReachesEntriesByName) {
  const core::Scene axis =
      edited("axis_distributed",
             {"coupler.k11.stiffness=800", "coupler.k11.damping=7", "object.box.mass=0.5",
              "user.1.mass=0.2", "rates.packet_hz=64", "reconstruction.kind=EXTRAPOLATE",
              "user.2.finger.a.position.x=0.01", "name=mine"});
  EXPECT_EQ(axis.couplers[0].gain.stiffness, 800);
  EXPECT_EQ(axis.couplers[0].gain.damping, 7);
  EXPECT_EQ(axis.objects[0].mass, 0.5);
  EXPECT_EQ(axis.users[0].mass, 0.2);
  EXPECT_EQ(axis.ticks_per_packet(), 16);
  EXPECT_EQ(axis.reconstruction.kind, core::ReconstructionKind::kExtrapolate);
  EXPECT_EQ(axis.users[1].fingers[0].position.x, 0.01);
  EXPECT_EQ(axis.name, "mine");

  const core::Scene plane = edited(
      "box_distributed", {"coupler.k11.normal.stiffness=700", "coupler.ko1.rotation.damping=0.2",
                          "wall.wall.stiffness=5000", "wall.wall.tangential.damping=40",
                          "contact.static_friction=0.7", "device.1a.max_force=11",
                          "user.1.finger.a.hand.stiffness=250", "user.1.finger.a.path.2.x=0.02",
                          "user.1.finger.a.path_sine.0.amplitude=0.03", "object.box.size.y=0.05"});
  EXPECT_EQ(plane.couplers[0].gain.stiffness, 700);
  EXPECT_EQ(plane.couplers[4].rotation.damping, 0.2);
  EXPECT_EQ(plane.walls[0].gain.stiffness, 5000);
  EXPECT_EQ(plane.walls[0].tangential.damping, 40);
  EXPECT_EQ(plane.contact.friction.static_coefficient, 0.7);
  EXPECT_EQ(plane.devices[0].max_force, 11);
  EXPECT_EQ(plane.users[0].fingers[0].hand.stiffness, 250);
  EXPECT_EQ(plane.users[0].fingers[0].intent.path[2].position.x, 0.02);
  EXPECT_EQ(plane.users[0].fingers[0].intent.path_sines[0].amplitude, 0.03);
  EXPECT_EQ(plane.objects[0].size.y, 0.05);
}

TEST(Set, MakesAndTakesAwayParts) {
  EXPECT_TRUE(edited("axis_distributed", {"silence.timeout=0.2"}).silence.has_value());
  EXPECT_FALSE(edited("box_distributed", {"silence=none"}).silence.has_value());
}

TEST(Set, LaterEditsWinAndEnumsMayBeSmall) {
  EXPECT_EQ(edited("axis_single", {"object.box.mass=1", "object.box.mass=2"}).objects[0].mass, 2);
  EXPECT_EQ(edited("axis_single", {"integrator=explicit_euler"}).integrator,
            core::Integrator::kExplicitEuler);
  EXPECT_FALSE(
      edited("box_distributed", {"contact.moment_cancellation=false"}).contact.moment_cancellation);
}

TEST(Set, GainsOfZeroTakeAUsersCouplersAway) {
  const core::Scene scene =
      edited("axis_distributed", {"coupler.k22.stiffness=0", "coupler.k22.damping=0",
                                  "coupler.k12.stiffness=0", "coupler.k12.damping=0"});
  EXPECT_EQ(scene.couplers[1].gain.stiffness, 0);
}

struct WrongSet {
  const char* scene;
  const char* set;
  std::vector<const char*> said;
};

TEST(Set, SaysWhatIsWrongWithIt) {
  const std::vector<WrongSet> cases = {
      {"axis_single",
       "object.box.masss=1",
       {"--set object.box.masss=1", "'masss'", "did you mean 'mass'"}},
      {"axis_single", "objekt.box.mass=1", {"'objekt'", "did you mean 'object'"}},
      {"axis_distributed", "coupler.k13.stiffness=1", {"'k13'", "did you mean 'k11'", "ko2"}},
      {"axis_single", "wall.w.stiffness=1", {"no wall to edit"}},
      {"axis_single", "object.box.mass", {"expected PATH=VALUE"}},
      {"axis_single", "=3", {"expected PATH=VALUE"}},
      {"axis_single", "object.box.mass=heavy", {"object.box.mass", "'heavy' is not a number"}},
      {"axis_single", "object.box.mass=1kg", {"'1kg' is not a number"}},
      {"axis_single", "object.box.mass=", {"'' is not a number"}},
      {"axis_single", "rates.latency_ticks=1.5", {"'1.5' is not a whole number"}},
      {"axis_single", "integrator=RK4", {"'RK4'", "ZERO_ORDER_HOLD, SEMI_IMPLICIT_EULER"}},
      {"axis_single", "contact.attached=yes", {"neither true nor false"}},
      {"axis_single", "object=1", {"is a list; say which", "box"}},
      {"axis_single", "object.box=1", {"whole object", "mass"}},
      {"axis_single", "rates=1", {"fields of its own", "packet_hz"}},
      {"axis_single", "object.box.mass.x=1", {"single value"}},
      {"axis_single", "object..mass=1", {"which", "box"}},
      {"axis_single", "user.1.finger.b.position.x=1", {"no finger is named 'b'", "'a'"}},
      {"axis_single", "scene_version=2", {"this program reads version 1"}},
      {"axis_single",
       "object.box.mass=-1",
       {"--set object.box.mass=-1: object.box.mass = -1 kg: must be above 0"}},
      {"axis_single", "object.box.mass=nan", {"object.box.mass = nan kg"}},
      {"axis_single", "object.box.mass=inf", {"object.box.mass = inf kg"}},
  };
  for (const WrongSet& c : cases) {
    const std::string error = error_of_named(c.scene, {c.set});
    for (const char* said : c.said)
      EXPECT_TRUE(contains(error, said)) << c.set << "\n  said: " << error << "\n  not: " << said;
  }
}

TEST(Set, ReportsAllEditsThatAreWrong) {
  const std::string error =
      error_of_named("axis_single", {"object.bax.mass=1", "object.box.mass=x", "rates.hz=1"});
  EXPECT_TRUE(contains(error, "'bax'")) << error;
  EXPECT_TRUE(contains(error, "'x'")) << error;
  EXPECT_TRUE(contains(error, "'hz'")) << error;
}

}  // namespace
}  // namespace tandem::scene
