#include <cmath>
#include <cstdlib>
#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/scene.h"
#include "recording/recording_reader.h"
#include "tests/system/program.h"
#include "tests/view/x_server.h"
#include "view/png_file.h"

// The program's own pictures, from a window on an X server: things are where an independent pinhole
// camera puts them. What they are comes from the scene's file, or from a node's recording.
namespace tandem::test {
namespace {

using Json = nlohmann::json;
using core::Vec3;

/// A pinhole camera by its words: eye, target, full vertical angle; z up.
struct Pinhole {
  Vec3 eye, target;
  double fov_y;
  int width, height;

  explicit Pinhole(const Json& report)
      : eye(vector(report["camera"]["eye"])),
        target(vector(report["camera"]["target"])),
        fov_y(report["camera"]["fov_y"]),
        width(report["size"][0]),
        height(report["size"][1]) {}
  static Vec3 vector(const Json& j) { return {j[0], j[1], j[2]}; }

  [[nodiscard]] core::Vec2 pixel(const Vec3& p) const {
    const Vec3 forward = unit(target - eye);
    const Vec3 right = unit(cross(forward, {0, 0, 1}));
    const Vec3 up = cross(right, forward);
    const Vec3 d = p - eye;
    const double pixels = 0.5 * height / std::tan(0.5 * fov_y) / dot(d, forward);
    return {0.5 * width + dot(d, right) * pixels, 0.5 * height - dot(d, up) * pixels};
  }
  static double dot(const Vec3& a, const Vec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
  static Vec3 cross(const Vec3& a, const Vec3& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
  }
  static Vec3 unit(const Vec3& a) { return a * (1.0 / std::sqrt(dot(a, a))); }
};

struct Shot {
  Json report;
  view::Image image;
  [[nodiscard]] Thing at(const Vec3& p) const {
    const core::Vec2 pixel = Pinhole(report).pixel(p);
    return thing_at(image, pixel.x, pixel.y);
  }
};

/// Nothing on the picture but the scene.
Shot take(std::vector<std::string> arguments, double patience = 30.0) {
  const std::string png = scratch("picture.png"), json = scratch("picture.json");
  arguments.insert(arguments.begin(), "view");
  for (const char* a : {"--no-panels", "--no-labels", "--no-margin", "--size", "800x600"})
    arguments.emplace_back(a);
  // Steep, and along the plane of symmetry: nothing hides a hand, and no bow the corners of the
  // lid.
  arguments.insert(arguments.end(), {"--camera", "-90,80,0.6,0,0,0"});
  arguments.insert(arguments.end(), {"--screenshot", png, "--json", json});
  Program program(arguments);
  EXPECT_EQ(program.wait(patience), 0) << program.output();
  std::ifstream file(json);
  return {Json::parse(file), view::read_png(png)};
}

// The planar box is drawn half as high as it is wide: its lid is at 30 mm, hands at 15 mm.
constexpr double kLid = 0.030, kHands = 0.015;

/// Box, hands and wall of the planar scenes, the box's middle and angle as given.
void expect_box_scene(const Shot& shot, const core::Vec2& box, double angle,
                      const std::vector<std::pair<core::Vec2, Thing>>& fingers) {
  const double c = std::cos(angle), s = std::sin(angle);
  const auto on_lid = [&](double x, double y) {
    return Vec3{box.x + c * x - s * y, box.y + s * x + c * y, kLid};
  };
  EXPECT_EQ(shot.at(on_lid(0, 0)), Thing::kBox);
  // A lid of 60 mm reaches 30 mm each way: what is 26 mm off is on it. The hands' bows, 3 pixels
  // wide, cross over the sides where fingers are: the corners are free.
  for (const double x : {-0.026, 0.026})
    for (const double y : {-0.026, 0.026}) EXPECT_EQ(shot.at(on_lid(x, y)), Thing::kBox) << x << y;
  // 8 mm before its front edge, on the ground: no box any more.
  const Vec3 before = on_lid(0, -0.038);
  EXPECT_NE(shot.at({before.x, before.y, 0.0}), Thing::kBox);
  for (const auto& [at, user] : fingers)
    EXPECT_EQ(shot.at({at.x, at.y, kHands}), user) << at.x << ", " << at.y;
  // The wall's face is y = 0.11, it is 37 mm high: its lid just behind the face.
  EXPECT_EQ(shot.at({0.0, 0.1115, 0.0372}), Thing::kWall);
  EXPECT_EQ(shot.at({0.06, 0.1115, 0.0372}), Thing::kWall);
}

class Pictures : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!server_.runs()) GTEST_SKIP() << "Xvfb is not installed";
    server_.use();
  }
  XServer server_{"1024x768"};
};

// At the first tick everything is where the scene's file says.
TEST_F(Pictures, OfASceneByItselfShowBoxHandsAndWallWhereTheFileSays) {
  const Shot shot = take({"--scene", "box_distributed", "--seconds", "0.01"});
  expect_box_scene(shot, {0, 0}, 0.0,
                   {{{-0.035, 0.012}, Thing::kUser1},
                    {{0.035, 0.012}, Thing::kUser1},
                    {{-0.035, -0.012}, Thing::kUser2},
                    {{0.035, -0.012}, Thing::kUser2}});
}

// Without a display the same picture comes from EGL, pixel for pixel but for its rounding.
TEST_F(Pictures, WithoutADisplayAreTheSame) {
  const std::vector<std::string> scene{"--scene", "space_box", "--seconds", "3"};
  const Shot with = take(scene);
  unsetenv("DISPLAY");
  const Shot without = take(scene);
  ASSERT_EQ(with.image.rgb.size(), without.image.rgb.size());
  std::size_t different = 0;
  for (std::size_t i = 0; i < with.image.rgb.size(); ++i)
    if (std::abs(with.image.rgb[i] - without.image.rgb[i]) > 8) ++different;
  EXPECT_LT(different, with.image.rgb.size() / 1000);
}

// Two replicas carry the box; a spectator takes a picture on the way. Then the recording is played
// at the same moment. The recording of replica 1 says where everything was.
TEST_F(Pictures, OfARunningSessionAndOfItsRecordingShowWhatTheReplicaHad) {
  Shot live;
  std::string file;
  std::vector<core::TickRecord> ticks;
  // A computer that stands still for 40 ms while two hands carry a box may shake it out of place:
  // once more then, twice at most.
  for (int attempt = 1; attempt <= 3; ++attempt) {
    const std::string a = free_address(), b = free_address();
    file = scratch("carry" + std::to_string(attempt) + ".h5");
    Program two(node({"replica", "--scene", "box_distributed", "--user", "2", "--bind", b, "--peer",
                      "1=" + a, "--seconds", "7", "--quiet"}));
    Program one(node({"replica", "--scene", "box_distributed", "--user", "1", "--bind", a,
                      "--seconds", "7", "--record", file, "--quiet"}));
    ASSERT_TRUE(one.says("user '2' joined")) << one.output();
    live = take({"--connect", a, "--seconds", "3.5"});
    EXPECT_EQ(one.wait(), 0) << one.output();
    EXPECT_EQ(two.wait(), 0) << two.output();
    recording::RecordingReader reader(file);
    ticks = reader.ticks(0, reader.tick_count());
    ASSERT_FALSE(ticks.empty());
    const auto slots = static_cast<std::size_t>(ticks.back().slot - ticks.front().slot) + 1;
    if (slots - ticks.size() < slots / 500) break;
  }
  const auto tick_at = [&](double time) {
    std::size_t i = 0;
    while (i + 1 < ticks.size() && static_cast<double>(ticks[i].slot) / 1024.0 < time) ++i;
    return ticks[i];
  };
  const auto check = [&](const Shot& shot) {
    const core::TickRecord t = tick_at(shot.report["time"]);
    expect_box_scene(shot, {t.objects[0][0], t.objects[0][1]}, t.objects[0][2], {});
    const Json& box = shot.report["objects"][0];
    return std::hypot(box[0].get<double>() - t.objects[0][0],
                      box[1].get<double>() - t.objects[0][1]);
  };
  // The finger ball outside the face, where the hand of user 2, a packet older, was drawn too.
  const auto finger = [&](const Shot& shot, int user, int f) {
    return Pinhole::vector(shot.report["users"][static_cast<std::size_t>(user)]["fingers"]
                                      [static_cast<std::size_t>(f)]["drawn"]);
  };
  const double error = check(live);
  RecordProperty("spectator_error_m", std::to_string(error));
  // Hermite's error and a tick of motion at the carry's 0.1 m/s: 0.1 mm each, and 0.1 mm to spare.
  EXPECT_LT(error, 3e-4);
  for (int user = 0; user < 2; ++user)
    EXPECT_EQ(live.at(finger(live, user, 0)), user == 0 ? Thing::kUser1 : Thing::kUser2);
  EXPECT_EQ(live.report["users"].size(), 2u);

  const Shot replay = take({"--recording", file, "--start", "3.0", "--seconds", "0.5"});
  EXPECT_LT(check(replay), 1.2e-4) << "the tick before: 0.1 m/s for 1/1024 s";
  for (int user = 0; user < 2; ++user)
    EXPECT_EQ(replay.at(finger(replay, user, 0)), user == 0 ? Thing::kUser1 : Thing::kUser2);
}

}  // namespace
}  // namespace tandem::test
