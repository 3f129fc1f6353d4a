#include "view/projection.h"

#include <cmath>

#include <gtest/gtest.h>

#include "view/camera.h"
#include "view/head_tracker.h"
#include "view/room.h"

namespace tandem::view {
namespace {

constexpr double kRounding = 1e-12;  // some dozen operations on numbers of order one

// A screen of 2 x 1.5 m, the eye 1 m before it, 0.2 m to the right and 0.1 m below its middle. At
// the near plane of 0.1 m everything is a tenth: -1 - 0.2 = -1.2 -> -0.12, and so on.
TEST(OffAxisFrustum, IsTheOneComputedByHand) {
  const Frustum f = off_axis_frustum(2.0, 1.5, {0.2, -0.1, 1.0}, 0.1, 10.0);
  EXPECT_NEAR(f.left, -0.12, kRounding);
  EXPECT_NEAR(f.right, 0.08, kRounding);
  EXPECT_NEAR(f.bottom, -0.065, kRounding);
  EXPECT_NEAR(f.top, 0.085, kRounding);
}

// An eye at half the distance sees the same screen under a window twice as large.
TEST(OffAxisFrustum, GrowsAsTheEyeComesNearer) {
  const Frustum f = off_axis_frustum(2.0, 1.5, {0.0, 0.0, 0.5}, 0.1, 10.0);
  EXPECT_NEAR(f.right, 0.2, kRounding);
  EXPECT_NEAR(f.top, 0.15, kRounding);
  EXPECT_NEAR(f.left, -f.right, kRounding);
}

TEST(OffAxisFrustum, RefusesAnEyeBehindTheScreen) {
  EXPECT_THROW((void)off_axis_frustum(2.0, 1.5, {0, 0, 0}, 0.1, 10), std::invalid_argument);
  EXPECT_THROW((void)off_axis_frustum(2.0, 1.5, {0, 0, NAN}, 0.1, 10), std::invalid_argument);
  EXPECT_THROW((void)off_axis_frustum(0.0, 1.5, {0, 0, 1}, 0.1, 10), std::invalid_argument);
}

// By hand: the eye 2 m from the target along x, z up. A point 0.5 m left of the target (at +y...
// the eye at +x looks along -x, so +y is to its right) and 0.25 m up: tan of half the angle is 0.5,
// the picture 200 x 100, so a pixel is 0.02 m at the target.
TEST(CameraPicture, PutsAPointAtThePixelComputedByHand) {
  Camera c;
  c.target = {1.0, 0.0, 0.0};
  c.azimuth = 0.0;
  c.elevation = 0.0;
  c.distance = 2.0;
  c.fov_y = 2.0 * std::atan(0.5);
  const Picture p = c.picture(200, 100);
  const auto middle = p.pixel({1.0, 0.0, 0.0});
  ASSERT_TRUE(middle);
  EXPECT_NEAR(middle->x, 100.0, 1e-9);
  EXPECT_NEAR(middle->y, 50.0, 1e-9);
  const auto at = p.pixel({1.0, 0.5, 0.25});
  ASSERT_TRUE(at);
  EXPECT_NEAR(at->x, 125.0, 1e-9);
  EXPECT_NEAR(at->y, 37.5, 1e-9);
  EXPECT_FALSE(p.pixel({4.0, 0.0, 0.0})) << "behind the eye";
  // The way back: the ray through that pixel goes through that point.
  const Vec3 ray = p.ray(*at), way = glm::normalize(Vec3{1.0, 0.5, 0.25} - p.eye());
  EXPECT_NEAR(glm::dot(ray, way), 1.0, 1e-12);
}

constexpr const char* kRoom = R"({
  // A screen on the wall y = 2 m of the room, its middle 1.5 m high, looking along -y.
  "screen": {"width": 2.7, "height": 2.0, "translation": [0, 2, 1.5],
             "rotation": [0.7071067811865476, 0.7071067811865476, 0, 0]},
  "common_from_scene": {"translation": [0, 1, 1], "rotation": [1, 0, 0, 0]},
  "common_from_tracker": {"translation": [1, 0, 0], "rotation": [1, 0, 0, 0]},
  "tracker_from_head": {"translation": [-0.7, 0.1, 1.6]},
  "eye_separation": 0.06
})";

// The head is at (-0.7, 0.1, 1.6) + (1, 0, 0) = (0.3, 0.1, 1.6) in the room. The screen's x is the
// room's x, its y the room's z, its z the room's -y: the head is (0.3, 0.1, 1.9) before the screen.
TEST(Room, BringsTheTrackedHeadIntoTheFrameOfTheScreen) {
  const Room room = parse_room(kRoom, "test");
  const Vec3 e = room.eye_in_screen(Eye::kMiddle);
  EXPECT_NEAR(e.x, 0.3, kRounding);
  EXPECT_NEAR(e.y, 0.1, kRounding);
  EXPECT_NEAR(e.z, 1.9, kRounding);
  EXPECT_NEAR(room.eye_in_screen(Eye::kRight).x - room.eye_in_screen(Eye::kLeft).x, 0.06,
              kRounding);
}

// What lies in the plane of the screen is drawn where it is, whoever looks: by hand, the point
// 0.675 m right of the middle (a quarter of the width) and 0.5 m up (a quarter of the height) is at
// three quarters of the picture.
TEST(Room, APointOnTheScreenStaysWhereItIsForBothEyesAndAnyHead) {
  Room room = parse_room(kRoom, "test");
  const Vec3 in_scene = room.common_from_scene.inverse()({0.675, 2.0, 2.0});
  for (const Vec3 head : {Vec3{-0.7, 0.1, 1.6}, Vec3{-1.9, 1.2, 0.4}, Vec3{0.0, -3.0, 2.5}})
    for (const Eye eye : {Eye::kLeft, Eye::kRight}) {
      room.tracker_from_head.t = head;
      const auto at = room.picture(eye, 1000, 800).pixel(in_scene);
      ASSERT_TRUE(at);
      EXPECT_NEAR(at->x, 750.0, 1e-8);
      EXPECT_NEAR(at->y, 200.0, 1e-8);
    }
}

// A point half way between eye and screen (similar triangles): seen from e = (0.3, 0.1, 1.9) the
// point (0.3, 0.35, 0.95) is drawn at (0.3, 0.6) on the screen: x (0.3 + 1.35) / 2.7, y (1 - 0.6)
// / 2.
TEST(Room, APointBeforeTheScreenIsDrawnWhereTheRayMeetsTheScreen) {
  const Room room = parse_room(kRoom, "test");
  const Vec3 in_common = room.common_from_screen({0.3, 0.35, 0.95});
  const auto at =
      room.picture(Eye::kMiddle, 1000, 800).pixel(room.common_from_scene.inverse()(in_common));
  ASSERT_TRUE(at);
  EXPECT_NEAR(at->x, 1000.0 * 1.65 / 2.7, 1e-8);
  EXPECT_NEAR(at->y, 800.0 * 0.2, 1e-8);
}

// A device turned by a quarter around z and moved by (1, 2, 3), measured at four points.
TEST(Room, FitsAFrameToPairsOfPoints) {
  const Room room = parse_room(R"({"screen": {"width": 1, "height": 1},
    "common_from_device": {"left": {"pairs": [
      {"here": [0,0,0], "common": [1,2,3]},   {"here": [0.1,0,0], "common": [1,2.1,3]},
      {"here": [0,0.1,0], "common": [0.9,2,3]}, {"here": [0,0,0.1], "common": [1,2,3.1]}]}}})",
                               "test");
  const Vec3 p = room.common_from_device.at("left")({0.2, 0.3, 0.4});
  EXPECT_NEAR(p.x, 0.7, 1e-12);
  EXPECT_NEAR(p.y, 2.2, 1e-12);
  EXPECT_NEAR(p.z, 3.4, 1e-12);
  EXPECT_LT(room.worst_residual, 1e-12);
}

TEST(HeadTracker, ReadsPositionsAndTurns) {
  const Rigid at = parse_head("0.1, -0.2 ,1.5\n");
  EXPECT_EQ(at.t.x, 0.1);
  EXPECT_EQ(at.t.y, -0.2);
  EXPECT_EQ(at.t.z, 1.5);
  EXPECT_EQ(at.q.w, 1.0);
  // A quarter turn around y takes x (from the left to the right eye) to -z.
  const Vec3 right = parse_head("0 0 0 0.70710678 0 0.70710678 0").q * Vec3{1, 0, 0};
  EXPECT_NEAR(right.z, -1.0, 1e-7);
  for (const char* wrong : {"", "1 2", "1 2 3 4", "a b c", "nan 0 0", "1e9 0 0", "0 0 0 1 1 0 0",
                            "0 0 0 0 0 0 0", "1 2 3 1 0 0 0 9"})
    EXPECT_THROW((void)parse_head(wrong), std::invalid_argument) << wrong;
}

TEST(Room, SaysWhatIsWrongWithAFile) {
  const auto said = [](const std::string& json) {
    try {
      (void)parse_room(json, "r.json");
    } catch (const std::exception& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  EXPECT_NE(said("{").find("not JSON"), std::string::npos);
  EXPECT_NE(said("[]").find("not a JSON object"), std::string::npos);
  EXPECT_NE(said("{}").find("field screen: is missing"), std::string::npos);
  EXPECT_NE(said(R"({"screen": {"width": -1, "height": 1}})").find("screen.width"),
            std::string::npos);
  EXPECT_NE(
      said(R"({"screen": {"width": 1, "height": 1, "rotation": [1, 1, 0, 0]}})").find("length"),
      std::string::npos);
  EXPECT_NE(said(R"({"sreen": {}})").find("is not known"), std::string::npos);
  EXPECT_NE(
      said(
          R"({"screen": {"width": 1, "height": 1}, "tracker_from_head": {"translation": [0, 0, -1]}})")
          .find("in front of it"),
      std::string::npos);
  EXPECT_NE(said(R"({"screen": {"width": 1, "height": 1}, "common_from_tracker": {"pairs": [
      {"here": [0,0,0], "common": [0,0,0]}, {"here": [1,0,0], "common": [1,0,0]},
      {"here": [2,0,0], "common": [2,0,0]}]}})")
                .find("on one line"),
            std::string::npos);
}

}  // namespace
}  // namespace tandem::view
