#include <gtest/gtest.h>

#include "arch_central/central_loop.h"
#include "arch_distributed/distributed_loop.h"
#include "core/axis_world.h"
#include "core/plane_world.h"
#include "scene/load_scene.h"
#include "view/assemble.h"
#include "view/drawing.h"
#include "view/paced_session.h"
#include "view/pointer_control.h"

namespace tandem::view {
namespace {

/// What a session that waits for nobody shows at `time` [s].
bool see_at(const core::Scene& scene, double time, Snapshot& seen) {
  PacedSession::Options options;
  options.speed = 0.0;
  PacedSession paced(scene, options);
  paced.advance_to(time);
  return paced.fetch(seen);
}

// The paced session is the loop and nothing else: the same bits after five seconds.
TEST(PacedSession, ShowsWhatTheLoopHas) {
  const core::Scene scene = scene::load_scene("box_distributed");
  Snapshot seen;
  ASSERT_TRUE(see_at(scene, 5.0, seen));
  distributed::DistributedLoop<core::PlaneWorld> loop(scene);
  for (int k = 0; k < 5 * 1024; ++k) loop.tick();
  EXPECT_EQ(seen.slot, loop.slot());
  for (int u = 0; u < 2; ++u) {
    EXPECT_EQ(seen.sites[u].objects[0].p.y, loop.object(u, 0).p.y);
    EXPECT_EQ(seen.sites[u].fingers[1].p.x, loop.law(u).site().fingers[1].p.x);
    EXPECT_EQ(seen.sites[u].fingers[1].force.x, loop.output(u).forces[1].x);
  }
}

// In the carry a finger has sunk into the face: the law says by how much, 5 mm for 4 N on 800 N/m.
// The drawn ball lies on the face, a ball's radius outside it, whatever the depth.
TEST(DrawnFinger, StaysOnTheSurfaceWhileTheHandSinksIn) {
  const core::Scene scene = scene::load_scene("box_distributed");
  const Layout layout(scene);
  Snapshot seen;
  ASSERT_TRUE(see_at(scene, 4.0, seen));
  const Body& box = seen.sites[0].objects[0];
  for (int f = 0; f < 2; ++f) {
    const Finger& finger = seen.sites[0].fingers[f];
    ASSERT_NE(finger.contact, core::ContactState::kFree);
    const double side = f == 0 ? -1.0 : 1.0;
    // Along the box's own x, from its middle: 30 mm to the face and the ball's radius.
    const Vec3 proxy = glm::conjugate(box.q) * (drawn_finger(layout, seen, 0, f).proxy - box.p);
    EXPECT_NEAR(proxy.x * side, 0.030 + layout.finger_radius(0, f), 1e-12);
    const Vec3 hip = glm::conjugate(box.q) * (finger.p - box.p);
    EXPECT_LT(hip.x * side, 0.028) << "the hand itself is inside";
    EXPECT_NEAR(glm::length(finger.force), 800.0 * (0.030 - hip.x * side), 2.0)
        << "normal force of 800 N/m, and friction that carries the box beside it";
  }
}

// A hand 2 mm inside a wall: the ball is drawn on the wall, its radius outside it.
TEST(DrawnFinger, StaysOnAWallWhileTheHandIsInsideIt) {
  core::Scene scene = scene::load_scene("box_distributed");
  scene.walls[0].touches_fingers = true;
  const core::WallParameters& wall = scene.walls[0];
  const Layout layout(scene);
  Snapshot seen;
  ASSERT_TRUE(see_at(scene, 0.0, seen));
  const Vec3 n = glm::normalize(wall.normal);
  seen.sites[0].fingers[0].p = wall.point - 0.002 * n;
  const DrawnFinger at = drawn_finger(layout, seen, 0, 0);
  EXPECT_NEAR(glm::dot(n, at.proxy - wall.point), layout.finger_radius(0, 0), 1e-12);
  EXPECT_NEAR(glm::dot(n, at.hip - wall.point), -0.002, 1e-12);
}

TEST(DrawnFinger, IsTheHandWhereNothingIsTouched) {
  const core::Scene scene = scene::load_scene("box_distributed");
  const Layout layout(scene);
  Snapshot seen;
  ASSERT_TRUE(see_at(scene, 0.0, seen));
  const DrawnFinger at = drawn_finger(layout, seen, 1, 0);
  EXPECT_NEAR(at.proxy.x, -0.035, 1e-12);
  EXPECT_NEAR(at.proxy.y, -0.012, 1e-12);
  EXPECT_EQ(at.proxy.x, at.hip.x);
}

// Every shipped scene can be laid out and drawn, and everything that moves is in sight.
TEST(Layout, EveryShippedSceneIsInSight) {
  for (const char* name :
       {"wall_single", "axis_single", "axis_central", "axis_distributed", "plane_single",
        "box_central", "box_distributed", "space_box", "space_sphere"}) {
    const core::Scene scene = scene::load_scene(name);
    const Layout layout(scene);
    PacedSession::Options options;
    options.speed = 0.0;
    PacedSession paced(scene, options);
    for (const auto& [width, height] : {std::pair{800, 600}, std::pair{3840, 2160}}) {
      const Picture picture =
          layout.camera(static_cast<double>(width) / height).picture(width, height);
      for (const double time : {0.0, 3.0, 6.0}) {
        paced.advance_to(time);
        Snapshot seen;
        (void)paced.fetch(seen);
        const Drawing drawing = draw(layout, seen, {});
        EXPECT_GT(drawing.items.size(), scene.users.size()) << name;
        for (std::size_t u = 0; u < scene.users.size(); ++u) {
          const auto at = picture.pixel(drawn_finger(layout, seen, static_cast<int>(u), 0).proxy);
          ASSERT_TRUE(at) << name;
          EXPECT_TRUE(at->x > 0 && at->x < width && at->y > 0 && at->y < height)
              << name << " at " << time << " s: " << at->x << ", " << at->y;
        }
      }
    }
  }
}

// A tick and a packet, made by hand: what the assembler shows is what was put in.
TEST(Assembler, PutsTicksAndPacketsTogether) {
  const core::Scene scene = scene::load_scene("box_distributed");
  Assembler assembler(scene, "1");
  core::TickRecord tick;
  tick.slot = 2048;
  tick.hands[1].position = {0.01, 0.02, 0};
  tick.command[1] = {-3, 4, 0};
  tick.objects[0] = {0.1, 0.2, 0.0, 0.5, 0.6, 0.7};
  tick.ages[1] = 0.030;
  tick.contact_bits[0] = core::with_contact(0, 1, core::ContactState::kSlide, 1);
  assembler.take(tick);
  core::PacketRecord packet;
  packet.peer = 1;
  // Fingers a, b: p, v each; box: p, angle, v, omega.
  const double values[] = {1, 2, 3, 4, 5, 6, 7, 8, 0.11, 0.21, 0.0, 0, 0, 0};
  std::copy(std::begin(values), std::end(values), packet.packet.values.begin());
  packet.packet.value_count = 14;
  assembler.take(packet);
  const Snapshot& s = assembler.snapshot();
  EXPECT_EQ(s.time, 2.0);
  EXPECT_EQ(s.own, 0);
  EXPECT_EQ(s.sites[0].fingers[1].p.y, 0.02);
  EXPECT_EQ(s.sites[0].fingers[1].force.y, 4.0);
  EXPECT_EQ(s.sites[0].fingers[1].contact, core::ContactState::kSlide);
  EXPECT_EQ(s.sites[0].objects[0].omega.z, 0.7);
  EXPECT_EQ(s.sites[1].fingers[1].p.x, 5.0);
  EXPECT_EQ(s.sites[1].age, 0.030);
  EXPECT_NEAR(replica_gap(s.sites[0], s.sites[1], 0), std::sqrt(2e-4), 1e-15);
}

// Of each four packets one is lost: sequences 1, 2, 3, 5, 6, 7, 9 ... over a second.
TEST(Assembler, CountsLossFromSequenceNumbers) {
  const core::Scene scene = scene::load_scene("box_distributed");
  Assembler assembler(scene, "1");
  std::int64_t used = 0;
  for (std::uint64_t sequence = 1; sequence <= 400; ++sequence) {
    if (sequence % 4 == 0) continue;
    core::PacketRecord packet;
    packet.peer = 1;
    packet.packet.sequence = sequence;
    assembler.take(packet, ++used);
  }
  EXPECT_NEAR(assembler.snapshot().sites[1].loss, 0.25, 0.01);  // a packet of 128 more or less
}

// Straight from above, the eye 1 m over the plane in which the hands are: a pixel right of the
// middle is (2 tan(fov/2) / height) metres. The hand goes there at its own speed, 0.4 m/s.
TEST(PointerControl, LeadsTheMiddleOfTheHandToThePointer) {
  const core::Scene scene = scene::load_scene("box_distributed");
  const Layout layout(scene);
  PointerControl control(layout, 0);
  Camera c;
  c.target = {0.0, 0.0, 0.25 * layout.unit};
  c.azimuth = -1.5707963267948966;
  c.elevation = 1.5707;
  c.distance = 1.0;
  c.fov_y = 2.0 * std::atan(0.5);
  const Picture picture = c.picture(200, 100);
  PointerControl::Input input;
  input.inside = true;
  input.pixel = {103.0, 47.0};  // 3 pixels right, 3 up: 30 mm each
  input.seconds = 0.05;
  devices::PointerTargets t = control.update(input, picture);
  EXPECT_NEAR(glm::length(control.middle() - Vec3{0.0, 0.012, 0.0}), 0.02, 1e-9) << "0.4 m/s";
  for (int k = 0; k < 20; ++k) t = control.update(input, picture);
  EXPECT_NEAR(control.middle().x, 0.030, 2e-4);  // elevation is 90 degrees less 1e-4 rad
  EXPECT_NEAR(control.middle().y, 0.030, 2e-4);
  EXPECT_NEAR(t.fingers[1].x - t.fingers[0].x, 0.070, 1e-9) << "open as in the scene";
  input.pinch = true;
  for (int k = 0; k < 20; ++k) t = control.update(input, picture);
  EXPECT_NEAR(t.fingers[1].x - t.fingers[0].x, 0.35 * 0.070, 1e-9) << "closed";
}

}  // namespace
}  // namespace tandem::view
