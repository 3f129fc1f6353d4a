#include <cstdlib>

#include <gtest/gtest.h>

// After GoogleTest, which has a type None; X makes that a number.
#include <X11/Xlib.h>
#include <X11/extensions/XTest.h>
#include <X11/keysym.h>

#include "recording/recording_reader.h"
#include "tests/system/program.h"
#include "tests/view/x_server.h"
#include "view/gl_window.h"
#include "view/shader.h"

// Whatever happens to the window, the person is told and the node goes on to its end.
namespace tandem::test {
namespace {

std::vector<std::string> node_with_window(const std::string& file) {
  return node({"server", "--scene", "plane_single", "--bind", free_address(), "--seconds", "2.5",
               "--record", file, "--view", "--view-size", "200x150", "--view-fps", "20",
               "--quiet"});
}

/// All ticks of 2.5 s but those a busy machine missed.
void expect_whole(const std::string& file) {
  recording::RecordingReader reader(file);
  EXPECT_TRUE(reader.complete());
  const auto last = reader.ticks(reader.tick_count() - 1, 1);
  ASSERT_EQ(last.size(), 1u);
  EXPECT_GT(last[0].slot, 2500);
}

TEST(ViewFailures, TheDisplayGoesAwayAndTheNodeGoesOn) {
  XServer server;
  if (!server.runs()) GTEST_SKIP() << "Xvfb is not installed";
  server.use();
  const std::string file = scratch("display_lost.h5");
  Program program(node_with_window(file));
  ASSERT_TRUE(program.says("server: scene"));
  sleep_seconds(1.0);
  server.kill();
  EXPECT_EQ(program.wait(), 0) << program.output();
  EXPECT_NE(program.output().find("the display is gone; the node goes on"), std::string::npos)
      << program.output();
  expect_whole(file);
}

TEST(ViewFailures, ADisplayWithoutOpenGlIsSaidAndTheNodeGoesOn) {
  XServer server;
  if (!server.runs()) GTEST_SKIP() << "Xvfb is not installed";
  server.use();
  const std::string file = scratch("old_gl.h5");
  setenv("MESA_GL_VERSION_OVERRIDE", "2.1", 1);
  Program program(node_with_window(file));
  unsetenv("MESA_GL_VERSION_OVERRIDE");
  EXPECT_EQ(program.wait(), 0) << program.output();
  EXPECT_NE(program.output().find("OpenGL 3.3"), std::string::npos) << program.output();
  EXPECT_NE(program.output().find("the node goes on without it"), std::string::npos);
  expect_whole(file);
}

TEST(ViewFailures, TheWindowIsClosedAndTheNodeGoesOn) {
  XServer server;
  if (!server.runs()) GTEST_SKIP() << "Xvfb is not installed";
  server.use();
  const std::string file = scratch("closed.h5");
  Program program(node_with_window(file));
  ASSERT_TRUE(program.says("server: scene"));
  Display* display = XOpenDisplay(server.display().c_str());
  ASSERT_NE(display, nullptr);
  // Escape, over the window, until it has been heard: nobody says when a window is there.
  XTestFakeMotionEvent(display, -1, 100, 75, 0);
  const KeyCode escape = XKeysymToKeycode(display, XK_Escape);
  for (int i = 0; i < 10 && !program.says("the window was closed", 0.1); ++i) {
    XTestFakeKeyEvent(display, escape, True, 0);
    XFlush(display);
    sleep_seconds(0.1);
    XTestFakeKeyEvent(display, escape, False, 0);
    XFlush(display);
  }
  XCloseDisplay(display);
  EXPECT_EQ(program.wait(), 0) << program.output();
  EXPECT_NE(program.output().find("the window was closed; the node goes on without it"),
            std::string::npos)
      << program.output();
  expect_whole(file);
}

TEST(ViewFailures, AShaderThatDoesNotCompileIsSaidWithTheDriversWords) {
  view::GlWindow::Options options;
  options.width = options.height = 64;
  options.offscreen = true;
  const view::GlWindow window(options);
  const char* vertex = "#version 330 core\nvoid main() { gl_Position = vec4(0.0); }\n";
  const char* broken = "#version 330 core\nvoid main() { nonsense(); }\n";
  try {
    const view::Shader shader("paint", vertex, broken);
    FAIL() << "it was taken";
  } catch (const view::WindowError& e) {
    EXPECT_NE(std::string(e.what()).find("the fragment shader \"paint\""), std::string::npos)
        << e.what();
    EXPECT_NE(std::string(e.what()).find("nonsense"), std::string::npos) << e.what();
  }
}

TEST(ViewFailures, AHostThatGoesIsSaidAndTheSpectatorWaitsForIt) {
  unsetenv("DISPLAY");
  const std::string a = free_address();
  Program host(
      node({"server", "--scene", "plane_single", "--bind", a, "--seconds", "1", "--quiet"}));
  ASSERT_TRUE(host.says("server: scene"));
  Program viewer({"view", "--connect", a, "--seconds", "2", "--size", "200x150", "--fps", "20",
                  "--no-margin"});
  EXPECT_EQ(host.wait(), 0) << host.output();
  EXPECT_EQ(viewer.wait(), 0) << viewer.output();
  EXPECT_NE(viewer.output().find(a + " left the session"), std::string::npos) << viewer.output();
  EXPECT_NE(viewer.output().find("time is over"), std::string::npos) << viewer.output();
}

TEST(ViewFailures, NoDisplayOfThatNameIsSaid) {
  setenv("DISPLAY", ":987", 1);
  Program program({"view", "--scene", "plane_single", "--seconds", "1"});
  EXPECT_EQ(program.wait(), 1) << program.output();
  EXPECT_NE(program.output().find("cannot open display :987"), std::string::npos)
      << program.output();
}

TEST(ViewFailures, WrongInputIsRefusedWithWhatIsAllowed) {
  unsetenv("DISPLAY");
  struct Case {
    std::vector<std::string> arguments;
    const char* said;
    int status;
  };
  const std::string png = scratch("x.png");
  for (const Case& c : std::initializer_list<Case>{
           {{"--size", "10x10"}, "64x64 to", 2},
           {{"--size", "nan"}, "WIDTHxHEIGHT", 2},
           {{"--camera", "1,2"}, "AZIMUTH,ELEVATION", 2},
           {{"--screenshot", png}, "--seconds", 2},
           {{"--screenshot", "/nowhere/x.png", "--seconds", "1"}, "/nowhere/x.png", 2},
           {{"--pointer", "nobody"}, "has no user \"nobody\"", 2},
           {{"--scene", "nothing"}, "nothing", 2},
           {{"--recording", "missing.h5"}, "missing.h5", 1},
           {{"--recording", "missing.h5", "--pointer", "1"}, "excludes", 2},
           {{"--speed", "nan"}, "not between 0.01", 2},
           {{"--fps", "nan"}, "not between 1", 2},
           {{"--connect", "here"}, "here", 1},
           {{"--room", "missing.json"}, "missing.json", 1}}) {
    std::vector<std::string> arguments{"view"};
    arguments.insert(arguments.end(), c.arguments.begin(), c.arguments.end());
    Program program(arguments);
    EXPECT_EQ(program.wait(), c.status) << c.arguments[0] << ": " << program.output();
    EXPECT_NE(program.output().find(c.said), std::string::npos)
        << c.arguments[0] << ": " << program.output();
  }
}

}  // namespace
}  // namespace tandem::test
