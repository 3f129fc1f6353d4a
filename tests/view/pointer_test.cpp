#include <gtest/gtest.h>

// After GoogleTest, which has a type None; X makes that a number.
#include <X11/Xlib.h>
#include <X11/extensions/XTest.h>

#include "recording/recording_reader.h"
#include "scene/load_scene.h"
#include "tests/system/program.h"
#include "tests/view/x_server.h"
#include "view/drawing.h"

// Two people at two machines, each with a mouse: two X servers, two replicas with windows, and mice
// that are moved by the X servers themselves (XTest), all the way through window, hand, law and
// UDP.
namespace tandem::test {
namespace {

/// A person's mouse.
class Mouse {
 public:
  explicit Mouse(const std::string& display) : display_(XOpenDisplay(display.c_str())) {}
  ~Mouse() {
    if (display_ != nullptr) XCloseDisplay(display_);
  }
  Mouse(const Mouse&) = delete;
  Mouse& operator=(const Mouse&) = delete;
  [[nodiscard]] bool found() const { return display_ != nullptr; }
  void move(int x, int y) {
    XTestFakeMotionEvent(display_, -1, x, y, 0);
    XFlush(display_);
  }
  void press(bool down) {
    XTestFakeButtonEvent(display_, 1, down ? True : False, 0);
    XFlush(display_);
  }

 private:
  Display* display_;
};

std::vector<std::string> replica(const std::string& user, const std::string& bind,
                                 const std::string& file) {
  return node({"replica", "--scene", "box_distributed", "--user", user, "--bind", bind, "--seconds",
               "6", "--record", file, "--hands", "pointer", "--view", "--view-size", "800x600",
               "--view-fps", "25", "--quiet"});
}

TEST(Pointer, TwoPeopleWithMiceMoveTheBoxTogetherOverUdp) {
  XServer left("800x600"), right("800x600");
  if (!left.runs() || !right.runs()) GTEST_SKIP() << "Xvfb is not installed";
  const std::string a = free_address(), b = free_address();
  const std::string files[] = {scratch("left.h5"), scratch("right.h5")};
  left.use();
  Program one(replica("1", a, files[0]));
  right.use();
  auto with_peer = replica("2", b, files[1]);
  with_peer.insert(with_peer.end(), {"--peer", "1=" + a});
  Program two(with_peer);
  ASSERT_TRUE(one.says("user '2' joined")) << one.output() << two.output();
  Mouse mice[] = {Mouse(left.display()), Mouse(right.display())};
  ASSERT_TRUE(mice[0].found() && mice[1].found());
  sleep_seconds(0.8);

  // People look where things are: each moves to the middle of its own hand, pinches, and goes 50 mm
  // up in y.
  const view::Layout layout(scene::load_scene("box_distributed"));
  const view::Picture picture = layout.camera(800.0 / 600.0).picture(800, 600);
  const auto point = [&](double up) {
    for (int u = 0; u < 2; ++u) {
      const auto at = picture.pixel(layout.place({0.0, (u == 0 ? 0.012 : -0.012) + up, 0.0}, u));
      ASSERT_TRUE(at);
      mice[u].move(static_cast<int>(at->x), static_cast<int>(at->y));
    }
  };
  point(0.0);
  sleep_seconds(0.5);
  for (Mouse& mouse : mice) mouse.press(true);
  sleep_seconds(1.0);
  for (int step = 1; step <= 30; ++step) {
    point(0.050 * step / 30);
    sleep_seconds(0.05);
  }
  EXPECT_EQ(one.wait(), 0) << one.output();
  EXPECT_EQ(two.wait(), 0) << two.output();

  double moved[2] = {0, 0}, squeeze[2] = {0, 0}, last[2][2] = {};
  for (int u = 0; u < 2; ++u) {
    recording::RecordingReader reader(files[u]);
    const auto ticks = reader.ticks(0, reader.tick_count());
    ASSERT_GT(ticks.size(), 2000u);
    for (const core::TickRecord& t : ticks) {
      moved[u] = std::max(moved[u], t.objects[0][1] - ticks.front().objects[0][1]);
      squeeze[u] = std::max(squeeze[u], std::min(-t.command[0].x, t.command[1].x));
    }
    for (int i = 0; i < 2; ++i) last[u][i] = ticks.back().objects[0][static_cast<std::size_t>(i)];
  }
  for (int u = 0; u < 2; ++u) {
    RecordProperty("moved_m_" + std::to_string(u + 1), std::to_string(moved[u]));
    // 50 mm, less what the springs give (friction of the ground 0.34 N on 4 x 300 N/m) and a pixel.
    EXPECT_GT(moved[u], 0.035) << "the box of user " << u + 1 << " went with the mice";
    // Both fingers pressed: a target 21 mm inside at 300 N/m against 800 N/m gives 4.6 N.
    EXPECT_GT(squeeze[u], 1.0) << "user " << u + 1 << " held it from both sides";
  }
  EXPECT_LT(std::hypot(last[0][0] - last[1][0], last[0][1] - last[1][1]), 2e-3)
      << "it is one box, not two";
}

}  // namespace
}  // namespace tandem::test
