#include <fstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "net/udp_socket.h"
#include "recording/recording_reader.h"
#include "tests/system/program.h"

// A room's frames through the whole program: what a tracker says reaches the eye, what a device
// measures reaches the scene.
namespace tandem::test {
namespace {

std::string written(const std::string& name, const std::string& text) {
  std::ofstream(scratch(name)) << text;
  return scratch(name);
}

// The tracker's frame is the room's moved by (1, 0, 0); the screen hangs in the plane y = 2, its
// middle 1.5 m high, looking along -y: its x is the room's x, its y the room's z, its z the room's
// -y. A head at (-0.7, 0.1, 1.6) of the tracker is at (0.3, 0.1, 1.6) in the room and at
// (0.3, 0.1, 1.9) before the screen.
TEST(RoomThroughTheProgram, ATrackersDatagramsMoveTheEye) {
  const std::string room = written("room.json", R"({
    "screen": {"width": 2.7, "height": 2.0, "translation": [0, 2, 1.5],
               "rotation": [0.7071067811865476, 0.7071067811865476, 0, 0]},
    "common_from_scene": {"translation": [0, 1, 1]},
    "common_from_tracker": {"translation": [1, 0, 0]},
    "tracker_from_head": {"translation": [-1, 0, 1.5]}})");
  const std::string tracker = free_address(), json = scratch("eye.json");
  unsetenv("DISPLAY");
  Program program({"view", "--scene", "plane_single", "--seconds", "1.5", "--size", "200x150",
                   "--fps", "15", "--no-margin", "--room", room, "--head-udp", tracker, "--json",
                   json});
  net::UdpLink from("127.0.0.1:0");
  const net::Endpoint to = from.resolve(tracker);
  const auto say = [&](const std::string& text) {
    from.send(to, {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
  };
  for (int i = 0; i < 100; ++i) {
    say("-0.7 0.1 1.6\n");
    if (i % 10 == 0) say("nothing of this kind");
    sleep_seconds(0.05);
    if (program.says("pictures", 0.001)) break;
  }
  EXPECT_EQ(program.wait(), 0) << program.output();
  std::ifstream file(json);
  const nlohmann::json seen = nlohmann::json::parse(file);
  const double expected[] = {0.3, 0.1, 1.9};
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_NEAR(seen["eye_in_screen"][i].get<double>(), expected[i], 1e-9);
  EXPECT_NE(seen["head_status"].get<std::string>().find("datagrams refused"), std::string::npos);
}

// A device turned by a quarter around z and moved: (x, y) of it is (0.01 - y, 0.02 + x) of the
// scene. The recording played on it goes to (0.003, 0.004) and rests there. Without a spring of the
// hand it goes exactly there, from the finger's home (-0.035, 0), which is in the device's frame.
TEST(RoomThroughTheProgram, ARecordedDeviceIsBroughtIntoTheSceneByItsFrame) {
  const std::string room = written("frames.json", R"({
    "screen": {"width": 1, "height": 1, "translation": [0, 0, -1]},
    "common_from_scene": {"translation": [5, 6, 7]},
    "common_from_device": {"1a": {"translation": [5.01, 6.02, 7],
                                   "rotation": [0.7071067811865476, 0, 0, 0.7071067811865476]}}})");
  const std::string csv = written("hand.csv", "t,x,y\n0,0.003,0.004\n10,0.003,0.004\n");
  const std::string file = scratch("framed.h5");
  Program program(node({"server", "--scene", "plane_single", "--bind", free_address(), "--seconds",
                        "0.5", "--hands", "recorded", "--hand-file", csv, "--hand-columns",
                        "time=t,x=x,y=y,mode=kinematic,origin=zero", "--room", room, "--record",
                        file, "--quiet"}));
  EXPECT_EQ(program.wait(), 0) << program.output();
  recording::RecordingReader reader(file);
  const auto ticks = reader.ticks(reader.tick_count() - 1, 1);
  ASSERT_EQ(ticks.size(), 1u);
  // To a step of the scene's encoder, 10 um. Home: examples/scenes/plane_single.scene has its
  // finger a at (-0.035, 0).
  const double x = -0.035 + 0.003, y = 0.004;
  EXPECT_NEAR(ticks[0].hands[0].position.x, 0.01 - y, 1.001e-5);
  EXPECT_NEAR(ticks[0].hands[0].position.y, 0.02 + x, 1.001e-5);
  // The other finger has no frame.
  EXPECT_NEAR(ticks[0].hands[1].position.x, 0.035 + 0.003, 1.001e-5);
  EXPECT_NEAR(ticks[0].hands[1].position.y, 0.004, 1.001e-5);
}

TEST(RoomThroughTheProgram, AFrameOfADeviceNobodyHasIsRefused) {
  const std::string room = written("nobody.json", R"({
    "screen": {"width": 1, "height": 1, "translation": [0, 0, -1]},
    "common_from_device": {"1thumb": {}}})");
  Program program(node({"server", "--scene", "plane_single", "--bind", free_address(), "--seconds",
                        "0.5", "--room", room, "--quiet"}));
  EXPECT_EQ(program.wait(), 1) << program.output();
  EXPECT_NE(program.output().find("no device \"1thumb\"; it has 1a, 1b"), std::string::npos)
      << program.output();
}

}  // namespace
}  // namespace tandem::test
