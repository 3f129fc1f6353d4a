#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "scene/validate_scene.h"
#include "tests/scene/scene_testing.h"

namespace tandem::scene {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using testing::contains;
using testing::error_of;
using testing::error_of_named;

struct Case {
  const char* scene;
  std::vector<std::string> sets;
  std::vector<const char*> said;
};

void expect_said(const Case& c) {
  const std::string error = error_of_named(c.scene, c.sets);
  for (const char* said : c.said)
    EXPECT_TRUE(contains(error, said)) << c.scene << " " << (c.sets.empty() ? "" : c.sets[0])
                                       << "\n  said: " << error << "\n  not:  " << said;
}

TEST(Validation, EveryNumberMustBeFinite) {
  for (const core::Scene& scene : testing::scenes_with_every_field()) {
    wire::Scene message = testing::message_of(scene);
    testing::for_each_leaf(
        message, "", [&](Message& parent, const FieldDescriptor* field, const std::string& path) {
          if (field->cpp_type() != FieldDescriptor::CPPTYPE_DOUBLE) return;
          const double before = parent.GetReflection()->GetDouble(parent, field);
          parent.GetReflection()->SetDouble(&parent, field, std::nan(""));
          const std::string error = error_of(testing::text_of(message));
          EXPECT_TRUE(contains(error, path + " = nan")) << path << ": " << error;
          EXPECT_TRUE(contains(error, "at most")) << path << ": " << error;
          parent.GetReflection()->SetDouble(&parent, field, before);
        });
  }
}

TEST(Validation, EveryNumberHasARange) {
  for (const core::Scene& scene : testing::scenes_with_every_field()) {
    wire::Scene message = testing::message_of(scene);
    testing::for_each_leaf(
        message, "", [&](Message& parent, const FieldDescriptor* field, const std::string& path) {
          if (field->cpp_type() != FieldDescriptor::CPPTYPE_DOUBLE) return;
          const double before = parent.GetReflection()->GetDouble(parent, field);
          parent.GetReflection()->SetDouble(&parent, field, 1e200);
          EXPECT_TRUE(contains(error_of(testing::text_of(message)), path + " = 1e+200")) << path;
          parent.GetReflection()->SetDouble(&parent, field, before);
        });
  }
}

TEST(Validation, SaysFieldValueAndWhatIsAllowed) {
  const std::vector<Case> cases = {
      {"axis_single",
       {"rates.local_hz=50"},
       {"rates.local_hz = 50 Hz", "at least 100", "20000 Hz"}},
      {"axis_single",
       {"rates.packet_hz=2048"},
       {"rates.packet_hz = 2048 Hz", "at most rates.local_hz = 1024"}},
      {"axis_single", {"rates.latency_ticks=9"}, {"rates.latency_ticks = 9 ticks", "at most 8"}},
      {"axis_single", {"rates.latency_ticks=-1"}, {"rates.latency_ticks = -1", "at least 0"}},
      {"axis_single", {"object.box.mass=0"}, {"object.box.mass = 0 kg", "above 0"}},
      {"axis_single", {"user.1.mass=-0.1"}, {"user.1.mass = -0.1 kg", "above 0"}},
      {"axis_single", {"coupler.k.stiffness=-5"}, {"coupler.k.stiffness = -5 N/m", "at least 0"}},
      {"axis_single",
       {"coupler.k.damping=1e6"},
       {"coupler.k.damping = 1000000 N s/m", "at most 100000 N s/m"}},
      {"axis_single",
       {"object.box.position.x=60"},
       {"object.box.position.x = 60 m", "at most 10 m"}},
      {"axis_single", {"gravity=-9.81"}, {"gravity = -9.81 m/s^2", "at least 0"}},
      {"axis_single",
       {"object.box.compensation=-3"},
       {"object.box.compensation = -3", "at least 0"}},
      {"box_distributed", {"silence.timeout=0"}, {"silence.timeout = 0 s", "above 0"}},
      {"box_distributed", {"silence.timeout=0.01"}, {"silence.timeout = 0.01 s", "0.015625 s"}},
      {"box_distributed", {"reconstruction.decay=0"}, {"reconstruction.decay = 0 s", "above 0"}},
      {"box_distributed",
       {"contact.dynamic_friction=0.9"},
       {"contact.dynamic_friction = 0.9", "at most static_friction = 0.6"}},
      {"box_distributed",
       {"wall.wall.dynamic_friction=0.9"},
       {"wall.wall.dynamic_friction = 0.9", "0.6"}},
      {"box_distributed", {"contact.pulse_force=0"}, {"contact.pulse_force = 0 N", "above 0"}},
      {"box_distributed",
       {"contact.pulse_force=20"},
       {"contact.pulse_force = 20 N", "max_force = 10 N of device '1a'"}},
      {"box_distributed",
       {"device.1a.velocity_cutoff_hz=600"},
       {"device.1a.velocity_cutoff_hz = 600 Hz", "512 Hz"}},
      {"box_distributed", {"device.1a.kind=RECORDED"}, {"device.1a.file is missing"}},
      {"box_distributed", {"device.1a.file=x.csv"}, {"device.1a.file = 'x.csv'", "RECORDED"}},
      {"box_distributed",
       {"user.1.finger.a.device=1b"},
       {"'1b'", "already held by user.1.finger.a", "own device"}},
      {"box_distributed",
       {"user.1.finger.a.device=1c"},
       {"user.1.finger.a.device = '1c'", "did you mean '1a'?"}},
      {"box_distributed",
       {"user.1.finger.a.path.2.time=0.5"},
       {"user.1.finger.a.path.2.time = 0.5 s", "later than the one before, 1 s"}},
      {"box_distributed",
       {"user.1.finger.a.path_sine.0.end=1"},
       {"path_sine.0.end = 1 s", "start = 2.5 s"}},
  };
  for (const Case& c : cases) expect_said(c);
}

TEST(Validation, PacketRatesNeedNotDivideTheLocalRate) {
  for (const char* rate : {"100", "93.0909090909091", "102.4", "1000"})
    EXPECT_EQ(error_of_named("axis_single", {std::string("rates.packet_hz=") + rate}), "");
}

TEST(Validation, FieldsThatTheSpaceLacksAreRefused) {
  const std::vector<Case> cases = {
      {"axis_single",
       {"object.box.position.y=1"},
       {"object.box.position.y: not part of an axis scene"}},
      {"axis_single", {"object.box.size.x=1"}, {"object.box.size: not part of an axis scene"}},
      {"axis_single",
       {"coupler.k.rotation.stiffness=1"},
       {"coupler.k.rotation: not part of an axis scene", "stiffness, damping"}},
      {"axis_single",
       {"coupler.k.normal.stiffness=1"},
       {"coupler.k.normal: not part of an axis scene"}},
      {"axis_single",
       {"contact.static_friction=0.5"},
       {"contact.static_friction: not part of an axis scene"}},
      {"axis_single", {"weight=true"}, {"weight: not part of an axis scene"}},
      {"box_distributed",
       {"object.box.position.z=1"},
       {"object.box.position.z: not part of a plane scene"}},
      {"box_distributed",
       {"object.box.inertia.x=1"},
       {"object.box.inertia.x: not part of a plane scene"}},
      {"box_distributed",
       {"coupler.k11.stiffness=1"},
       {"coupler.k11.stiffness: not part of a hand's coupler in a plane scene",
        "normal, tangential"}},
      {"box_distributed",
       {"coupler.ko1.normal.stiffness=1"},
       {"coupler.ko1.normal: not part of a coupler between copies", "linear, rotation"}},
      {"box_distributed",
       {"wall.wall.attached=true"},
       {"wall.wall.attached: not part of a plane scene"}},
      {"box_distributed", {"user.1.finger.a.path.2.z=1"}, {"path.2.z: not part of a plane scene"}},
      {"space_box",
       {"object.box.ground_friction=0.1"},
       {"object.box.ground_friction: not part of a space scene"}},
      {"space_box", {"object.box.angle=0.1"}, {"object.box.angle: not part of a space scene"}},
  };
  for (const Case& c : cases) expect_said(c);
}

TEST(Validation, ExactCouplersNeedWhatIsLinear) {
  const std::vector<Case> cases = {
      {"box_distributed",
       {"integrator=EXACT_COUPLER"},
       {"integrator = EXACT_COUPLER: only an AXIS scene", "contact.attached: true"}},
      {"axis_single",
       {"integrator=EXACT_COUPLER", "rates.latency_ticks=1"},
       {"computation delay", "set rates.latency_ticks: 0"}},
      {"axis_single",
       {"integrator=EXACT_COUPLER", "object.box.ground_friction=0.1"},
       {"set object.box.ground_friction: 0"}},
  };
  for (const Case& c : cases) expect_said(c);
}

TEST(Validation, ImpossibleGeometryIsRefused) {
  const std::vector<Case> cases = {
      {"box_distributed", {"object.box.size.y=0"}, {"object.box.size.y = 0 m", "above 0"}},
      {"box_distributed", {"object.box.shape=SPHERE"}, {"object.box.shape", "shape BOX"}},
      {"axis_single", {"object.box.shape=BOX"}, {"object.box.shape", "shape POINT"}},
      {"space_box", {"object.box.shape=POINT"}, {"object.box.shape", "BOX or SPHERE"}},
      {"space_box", {"object.box.radius=0.1"}, {"object.box.radius = 0.1 m", "only a SPHERE"}},
      {"space_sphere", {"object.ball.radius=0"}, {"object.ball.radius = 0 m", "above 0"}},
      {"space_sphere", {"object.ball.size.x=1"}, {"object.ball.size.x = 1 m", "no size"}},
      {"space_box", {"object.box.orientation.w=0"}, {"object.box.orientation", "length 0"}},
      {"space_box", {"object.box.inertia.x=1"}, {"object.box.inertia.y = 0", "above 0"}},
      {"space_box",
       {"object.box.inertia.x=1", "object.box.inertia.y=1", "object.box.inertia.z=3"},
       {"object.box.inertia.z = 3", "the sum of the other two, 2"}},
      {"box_distributed", {"wall.wall.normal.y=0"}, {"wall.wall.normal", "length 0", "free side"}},
      {"box_distributed",
       {"user.1.finger.a.position.x=-0.02"},
       {"user.1.finger.a.position: starts 0.01", "inside object 'box'"}},
      {"box_distributed",
       {"user.1.finger.a.radius=0.006"},
       {"user.1.finger.a.position: starts 0.00", "inside object 'box'"}},
      {"box_distributed",
       {"wall.wall.point.y=0.02"},
       {"object.box.position: starts 0.0", "behind wall 'wall'"}},
      {"box_distributed", {"wall.wall.normal.y=1"}, {"object.box.position", "behind wall 'wall'"}},
      {"box_distributed",
       {"wall.wall.touches_fingers=true", "wall.wall.point.y=0.031",
        "user.1.finger.a.position.y=0.04"},
       {"user.1.finger.a.position: starts 0.009", "behind wall 'wall'"}},
      // turned by 45 degrees the box reaches 0.0424 m
      {"box_distributed",
       {"object.box.angle=0.7853981633974483", "wall.wall.point.y=0.04"},
       {"object.box.position: starts 0.0024", "behind wall"}},
      {"space_box",
       {"object.box.position.z=0.029"},
       {"object.box.position: starts 0.001", "behind wall 'ground'"}},
      {"space_sphere",
       {"user.1.finger.a.position.x=-0.035"},
       {"user.1.finger.a.position", "inside object 'ball'"}},
      {"wall_single",
       {"user.1.finger.a.position.x=0.01"},
       {"user.1.finger.a.position: starts 0.01 m behind wall 'wall'"}},
  };
  for (const Case& c : cases) expect_said(c);
}

TEST(Validation, TouchingAndDeclaredGraspsAreAllowed) {
  EXPECT_EQ(error_of_named("box_distributed", {"user.1.finger.a.position.x=-0.03"}), "");
  EXPECT_EQ(error_of_named("box_distributed", {"wall.wall.point.y=0.03"}), "");
  EXPECT_EQ(error_of_named("box_distributed",
                           {"contact.attached=true", "user.1.finger.a.position.x=-0.025"}),
            "");
  EXPECT_EQ(error_of_named("box_distributed", {"wall.wall.normal.y=-2"}), "");
}

/// A small distributed axis scene, with text put in or left out.
std::string axis(const std::string& more, const std::string& architecture = "DISTRIBUTED") {
  return "scene_version: 1\narchitecture: " + architecture +
         "\nobject { name: 'box' }\n"
         "user { name: '1' finger { name: 'a' } }\nuser { name: '2' finger { name: 'a' } }\n" +
         more;
}
const std::string kAllCouplers =
    "coupler { name: 'k11' object: 'box' user: '1' copy: '1' }\n"
    "coupler { name: 'k22' object: 'box' user: '2' copy: '2' }\n"
    "coupler { name: 'k12' object: 'box' user: '2' copy: '1' }\n"
    "coupler { name: 'k21' object: 'box' user: '1' copy: '2' }\n"
    "coupler { name: 'ko1' object: 'box' copy: '1' }\n"
    "coupler { name: 'ko2' object: 'box' copy: '2' }\n";

void expect_text_says(const std::string& text, const std::vector<const char*>& said) {
  const std::string error = error_of(text);
  for (const char* part : said)
    EXPECT_TRUE(contains(error, part)) << "said: " << error << "\nnot:  " << part;
}

TEST(Validation, TheSmallSceneOfTheseTestsIsSound) { EXPECT_EQ(error_of(axis(kAllCouplers)), ""); }

TEST(Validation, NamesAreGivenOnceAndGiven) {
  const std::string good = axis(kAllCouplers);
  expect_text_says(good + "object { name: 'box' }",
                   {"t.scene:12: object.box: the name 'box' is given twice"});
  expect_text_says(good + "user { name: '2' finger { name: 'a' } }",
                   {"t.scene:12: user.2: the name '2' is given twice"});
  expect_text_says(good + "user { name: '3' finger { name: 'a' } finger { name: 'a' } }",
                   {"user.3.finger.a: the name 'a' is given twice"});
  expect_text_says(good + "coupler { name: 'k11' object: 'box' user: '1' copy: '1' }",
                   {"coupler.k11: the name 'k11' is given twice",
                    "the same object, user and copy as coupler 'k11'"});
  expect_text_says(good +
                       "wall { name: 'w' normal { x: 1 } point { x: -1 } } wall { name: 'w' normal "
                       "{ x: 1 } point { x: -1 } }",
                   {"wall.w: the name 'w' is given twice"});
  expect_text_says(good + "device { name: 'd' } device { name: 'd' }",
                   {"device.d: the name 'd' is given twice"});
  expect_text_says(good + "device { }", {"t.scene:12: device.0: has no name"});
  expect_text_says(good + "device { name: 'a.b' }", {"'a.b' must be 1 to 32 letters"});
  expect_text_says(good + "device { name: 'a=b' }", {"'a=b' must be 1 to 32 letters"});
}

TEST(Validation, CrossReferencesMustExist) {
  const std::string good = axis(kAllCouplers);
  expect_text_says(good + "coupler { name: 'x' object: 'bix' user: '1' copy: '1' }",
                   {"t.scene:12: coupler.x.object = 'bix'", "did you mean 'box'?"});
  expect_text_says(good + "coupler { name: 'x' object: 'box' user: '7' copy: '1' }",
                   {"coupler.x.user = '7': no user", "known: 1, 2"});
  expect_text_says(good + "coupler { name: 'x' object: 'box' user: '1' copy: '7' }",
                   {"coupler.x.copy = '7': no user", "known: 1, 2"});
  expect_text_says(good + "coupler { name: 'x' object: 'box' user: '1' }",
                   {"coupler.x.copy is missing"});
}

TEST(Validation, EveryArchitectureNeedsItsCouplers) {
  expect_text_says(axis(kAllCouplers.substr(kAllCouplers.find('\n') + 1)),
                   {"none joins the hand of user '1' to the copy at user '1' of object 'box'"});
  expect_text_says(axis(""),
                   {"hand of user '2' to the copy at user '1'", "holds the copy at user '2'"});
  expect_text_says(axis("coupler { name: 'k1' object: 'box' user: '1' }", "CENTRAL"),
                   {"none joins the hand of user '2' to object 'box'"});
  expect_text_says(axis("coupler { name: 'k1' object: 'box' user: '1' copy: '1' }", "CENTRAL"),
                   {"coupler.k1.copy = '1': copies exist only in distributed"});
  expect_text_says(axis("coupler { name: 'ko' object: 'box' }", "CENTRAL"),
                   {"coupler.ko.user is missing: only a distributed scene"});
  expect_text_says(axis(kAllCouplers, "DISTRIBUTED_SPLIT"),
                   {"coupler.k12.user = '2'", "own copy only"});
}

TEST(Validation, NumbersOfUsersAndThings) {
  expect_text_says(axis("", "SINGLE"), {"user: 2 users, a SINGLE scene has 1"});
  expect_text_says(
      "scene_version: 1 object { name: 'box' } user { name: '1' finger { name: 'a' } }",
      {"user: 1 users, a distributed scene has 2 to 8"});
  expect_text_says("scene_version: 1 architecture: CENTRAL", {"user: 0 users", "object: none"});
  expect_text_says("scene_version: 1 architecture: SINGLE user { name: '1' finger { name: 'a' } }",
                   {"nothing to feel"});
  expect_text_says("scene_version: 1 architecture: SINGLE user { name: '1' }",
                   {"user.1.finger: none"});
  expect_text_says(axis(kAllCouplers + "user { name: '3' local: true finger { name: 'a' } }"),
                   {"user.3.local = true: only a CENTRAL"});
  std::string many = axis(kAllCouplers), fingers = many, objects = many, walls = many;
  for (int i = 3; i <= 9; ++i)
    many += "user { name: '" + std::to_string(i) + "' finger { name: 'a' } }\n";
  expect_text_says(many, {"user: 9 entries, at most 8"});
  fingers += "user { name: '3' ";
  for (int i = 0; i < 5; ++i) fingers += "finger { name: 'f" + std::to_string(i) + "' } ";
  expect_text_says(fingers + "}", {"user.3.finger: 5 entries, at most 4"});
  for (int i = 0; i < 4; ++i) objects += "object { name: 'o" + std::to_string(i) + "' }\n";
  expect_text_says(objects, {"object: 5 entries, at most 4"});
  for (int i = 0; i < 9; ++i) walls += "wall { name: 'w" + std::to_string(i) + "' }\n";
  expect_text_says(walls, {"wall: 9 entries, at most 8"});
}

TEST(Validation, ReportsAllProblemsNotOnlyTheFirst) {
  const std::string error = error_of_named(
      "box_distributed", {"object.box.mass=-1", "rates.packet_hz=0", "wall.wall.normal.y=0",
                          "coupler.k11.object=bix", "user.1.finger.b.device=zz"});
  for (const char* said : {"object.box.mass", "rates.packet_hz", "wall.wall.normal",
                           "coupler.k11.object", "user.1.finger.b.device"})
    EXPECT_TRUE(contains(error, said)) << said << " not in\n" << error;
  EXPECT_GE(std::count(error.begin(), error.end(), '\n'), 4);
}

TEST(Validation, EightUsersAreAllowed) {
  std::string text = "scene_version: 1 architecture: DISTRIBUTED object { name: 'box' }\n";
  for (int i = 1; i <= 8; ++i) {
    const std::string u = std::to_string(i);
    text += "user { name: '" + u + "' finger { name: 'a' } }\n";
    text += "coupler { name: 'ko" + u + "' object: 'box' copy: '" + u + "' }\n";
    for (int j = 1; j <= 8; ++j)
      text += "coupler { name: 'k" + u + std::to_string(j) + "' object: 'box' copy: '" + u +
              "' user: '" + std::to_string(j) + "' }\n";
  }
  EXPECT_EQ(error_of(text), "");
}

}  // namespace
}  // namespace tandem::scene
