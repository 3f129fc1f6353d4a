#include <bit>
#include <cstdint>
#include <map>

#include <gtest/gtest.h>

#include "scene/find_scene.h"
#include "tests/scene/scene_testing.h"

namespace tandem::scene {
namespace {

// The hash that peers compare. A new value means that a scene, the list of shared fields or the
// byte form changed, and that older peers will be refused: copy the printed value here and say why
// in CHANGELOG.md.
const std::map<std::string, std::uint64_t> kGoldenHashes = {
    {"axis_central", 0x11324ea48ab978ba},
    {"axis_central_thesis", 0xf8ab60cbc499cbd0},
    {"axis_distributed", 0xff936e275efa0e4c},
    {"axis_distributed_split", 0x00cc725041af3d39},
    {"axis_distributed_thesis", 0x59d0ec486e3f0276},
    {"axis_single", 0x9c41eaed22dfd144},
    {"box_central", 0x73b874adf58791c1},
    {"box_central_table_8_1", 0x1bff21a4615f1bdf},
    {"box_central_thesis", 0x872a7d69f0ce8ce3},
    {"box_distributed", 0x68889ebdba7e1835},
    {"box_distributed_split", 0x632fc6db6842831c},
    {"box_distributed_thesis", 0xbdfe72d59951d0f7},
    {"plane_single", 0x7a41f8847f9f54f7},
    {"space_box", 0x3a3f85e8ae5e5792},
    {"space_sphere", 0x5e346958258544d0},
    {"wall_single", 0xc9e53f18310aa2cc},
};

TEST(ShippedScenes, LoadAndCarryTheNameOfTheirFile) {
  for (const auto& [name, hash] : kGoldenHashes) {
    const core::Scene scene = load_scene(name);
    EXPECT_EQ(scene.name, name);
    EXPECT_FALSE(scene.description.empty()) << name;
  }
}

TEST(ShippedScenes, AreAllInThisTest) {
  EXPECT_EQ(scene_names().size(), kGoldenHashes.size());
  for (const std::string& name : scene_names()) EXPECT_TRUE(kGoldenHashes.contains(name)) << name;
}

TEST(ShippedScenes, HaveTheirGoldenHash) {
  for (const auto& [name, hash] : kGoldenHashes)
    EXPECT_EQ(shared_hash(load_scene(name)), hash)
        << name << " 0x" << std::hex << shared_hash(load_scene(name));
}

TEST(ShippedScenes, ComeBackFromTheirTextBitForBit) {
  for (const auto& [name, hash] : kGoldenHashes) {
    const core::Scene scene = load_scene(name);
    const std::string text = to_text(scene);
    const core::Scene back = load_scene_text(text, name);
    EXPECT_EQ(to_text(back), text) << name;
    EXPECT_EQ(shared_hash(back), hash) << name;
  }
}

TEST(CanonicalText, KeepsDoublesThatNeedAllTheirDigits) {
  core::Scene scene = load_scene("box_distributed");
  // 1/3, one ulp above 0.7, smallest normal number's neighbourhood, a value with 17 digits
  scene.objects[0].mass = std::bit_cast<double>(std::bit_cast<std::uint64_t>(0.7) + 1);
  scene.objects[0].position.x = 1.0 / 3.0 - 0.33;
  scene.objects[0].velocity.y = 5e-324;
  scene.couplers[0].gain.stiffness = 0.1 + 0.2;
  scene.objects[0].angle = -0.0;
  scene.contact.attached = true;
  const core::Scene back = load_scene_text(to_text(scene), "t");
  const auto same = [](double a, double b) {
    return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
  };
  EXPECT_TRUE(same(back.objects[0].mass, scene.objects[0].mass));
  EXPECT_TRUE(same(back.objects[0].position.x, scene.objects[0].position.x));
  EXPECT_TRUE(same(back.objects[0].velocity.y, 5e-324));
  EXPECT_TRUE(same(back.objects[0].angle, -0.0));
  EXPECT_TRUE(same(back.couplers[0].gain.stiffness, 0.1 + 0.2));
}

TEST(CanonicalText, KeepsNormalsAndOrientationsThatWereMadeUnitVectors) {
  const std::vector<std::string> sets = {
      "contact.attached=true",  "wall.ground.normal.x=0.3",     "wall.ground.normal.y=0.1",
      "wall.ground.point.z=-1", "object.box.orientation.w=0.7", "object.box.orientation.z=0.2"};
  const core::Scene scene = load_scene("space_box", sets);
  const auto& n = scene.walls[0].normal;
  EXPECT_NEAR(n.x * n.x + n.y * n.y + n.z * n.z, 1.0, 1e-15);  // a few roundings of numbers near 1
  const core::Scene back = load_scene_text(to_text(scene), "t");
  for (int i = 0; i < 3; ++i) EXPECT_EQ(back.walls[0].normal[i], n[i]);
  EXPECT_EQ(back.objects[0].orientation.w, scene.objects[0].orientation.w);
  EXPECT_EQ(back.objects[0].orientation.z, scene.objects[0].orientation.z);
}

TEST(ShippedScenes, UseExplicitEulerOnlyInThesisVariants) {
  for (const std::string& name : scene_names())
    EXPECT_EQ(load_scene(name).integrator == core::Integrator::kExplicitEuler,
              name.ends_with("_thesis"))
        << name;
}

core::Gain gain_of(const core::Scene& scene, const std::string& coupler) {
  return scene.couplers.at(static_cast<std::size_t>(core::index_of(scene.couplers, coupler))).gain;
}

TEST(ShippedScenes, AxisScenesHaveTable61) {
  const core::Scene central = load_scene("axis_central");
  EXPECT_EQ(gain_of(central, "k1").stiffness, 1000);
  EXPECT_EQ(gain_of(central, "k1").damping, 15);
  EXPECT_EQ(gain_of(central, "k2").stiffness, 85);
  EXPECT_EQ(gain_of(central, "k2").damping, 3);
  EXPECT_TRUE(central.users[0].local);
  EXPECT_FALSE(central.users[1].local);
  const core::Scene distributed = load_scene("axis_distributed");
  const std::map<std::string, core::Gain> table = {{"k11", {3000, 20}}, {"k22", {3000, 20}},
                                                   {"k12", {400, 2}},   {"k21", {400, 2}},
                                                   {"ko1", {300, 10}},  {"ko2", {300, 10}}};
  ASSERT_EQ(distributed.couplers.size(), table.size());
  for (const auto& [name, gain] : table) {
    EXPECT_EQ(gain_of(distributed, name).stiffness, gain.stiffness) << name;
    EXPECT_EQ(gain_of(distributed, name).damping, gain.damping) << name;
  }
  // k12 acts on copy 1, from hand 2
  const auto& k12 = distributed.couplers.at(
      static_cast<std::size_t>(core::index_of(distributed.couplers, "k12")));
  EXPECT_EQ(k12.copy, "1");
  EXPECT_EQ(k12.user, "2");
  for (const core::Scene& scene : {central, distributed}) {
    EXPECT_EQ(scene.objects[0].mass, 0.4);
    EXPECT_EQ(scene.users[0].mass, 0.1);
    EXPECT_EQ(scene.users[1].mass, 0.1);
    EXPECT_EQ(scene.ticks_per_packet(), 8);
    EXPECT_FALSE(scene.silence.has_value());
    EXPECT_TRUE(scene.contact.attached);
  }
}

TEST(ShippedScenes, PlanarScenesHaveTables81And82) {
  const core::Scene distributed = load_scene("box_distributed");
  for (const auto& c : distributed.couplers) {
    const bool hand = !c.user.empty();
    EXPECT_EQ(c.gain.stiffness, hand ? 800 : 400) << c.name;
    EXPECT_EQ(c.gain.damping, hand ? 3 : 8) << c.name;
    EXPECT_EQ(hand ? c.tangential.stiffness : c.rotation.stiffness, hand ? 1200 : 10) << c.name;
    EXPECT_EQ(hand ? c.tangential.damping : c.rotation.damping, hand ? 10 : 0.1) << c.name;
  }
  const core::Scene reduced = load_scene("box_central");
  EXPECT_EQ(gain_of(reduced, "k2").stiffness, 170);
  EXPECT_EQ(reduced.couplers[1].tangential.stiffness, 270);
  EXPECT_EQ(reduced.couplers[1].tangential.damping, 5);
  EXPECT_EQ(gain_of(load_scene("box_central_table_8_1"), "k2").stiffness, 800);
  EXPECT_EQ(distributed.walls[0].gain.stiffness, 4000);
  EXPECT_EQ(distributed.walls[0].tangential.stiffness, 7000);
  EXPECT_EQ(distributed.objects[0].ground_friction, 0.05);
  EXPECT_EQ(distributed.objects[0].ground_friction_rotation, 0.15);
  EXPECT_EQ(distributed.contact.friction.static_coefficient, 0.6);
}

TEST(ShippedScenes, EveryPlanarFingerNamesItsOwnDevice) {
  const core::Scene scene = load_scene("box_distributed");
  ASSERT_EQ(scene.devices.size(), 4U);
  std::map<std::string, int> held;
  for (const auto& user : scene.users)
    for (const auto& finger : user.fingers) ++held[finger.device];
  EXPECT_EQ(held.size(), 4U);
  for (const auto& device : scene.devices) EXPECT_EQ(held[device.name], 1) << device.name;
}

TEST(Defaults, AreThoseOfThePlainStructs) {
  const core::Scene scene = load_scene_text(
      "scene_version: 1 architecture: SINGLE object { name: 'o' }"
      "coupler { name: 'k' object: 'o' user: 'u' } user { name: 'u' finger { name: 'a' } }",
      "t");
  core::Scene plain;
  plain.architecture = core::Architecture::kSingle;
  plain.objects.push_back({.name = "o"});
  plain.couplers.push_back({"k", "o", "u", "", {}, {}, {}});
  plain.users.emplace_back().name = "u";
  plain.users[0].fingers.emplace_back().name = "a";
  EXPECT_EQ(to_text(scene), to_text(plain));
}

}  // namespace
}  // namespace tandem::scene
