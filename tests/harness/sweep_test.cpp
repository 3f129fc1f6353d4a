#include "harness/sweep.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>
#include <unistd.h>

#include <gtest/gtest.h>

#include "harness/recorded_series.h"
#include "scene/scene_error.h"

namespace tandem::harness {
namespace {

class File {
 public:
  File(const std::string& name, const std::string& text)
      : path_(std::filesystem::temp_directory_path() /
              (name + std::to_string(::getpid()) + ".sweep")) {
    std::ofstream(path_) << text;
  }
  ~File() { std::filesystem::remove(path_); }
  File(const File&) = delete;
  File& operator=(const File&) = delete;
  [[nodiscard]] std::string path() const { return path_.string(); }

 private:
  std::filesystem::path path_;
};

std::string refusal(const std::string& text) {
  const File file("refused", text);
  try {
    static_cast<void>(load_sweep(file.path()));
  } catch (const std::exception& e) {
    return e.what();
  }
  return "accepted";
}

TEST(Sweep, BuiltInOnesHaveTheirPoints) {
  const std::pair<const char*, std::size_t> steps[] = {
      {"thesis", 4}, {"rate", 6}, {"delay", 7}, {"jitter", 7}, {"loss", 8}};
  for (const auto& [name, count] : steps) {
    SweepOptions quick;
    quick.quick = true;
    EXPECT_EQ(load_sweep(name, quick).points.size() % 9, 0u) << name;  // 3 scenes, 3 styles
    EXPECT_LT(load_sweep(name, quick).points.size(), 9 * count) << name;
  }
  const Sweep thesis = load_sweep("thesis");
  ASSERT_EQ(thesis.points.size(), 36u);
  EXPECT_EQ(thesis.points[3].network.there.delay, 0.0234375);  // three periods, all of them there
  EXPECT_TRUE(is_clear(thesis.points[3].network.back));
}

// Thesis 6.2.3 and the reference analysis: -3 N s/m at n = 1 with Table 6.1, where -3.150 would
// take all drag away.
TEST(Sweep, CompensationIsTheThesisAtNOne) {
  const Sweep thesis = load_sweep("thesis");
  for (const SweepPoint& p : thesis.points)
    if (p.name == "distributed/compensated/round trip=n = 1") {
      EXPECT_NEAR(p.scene.objects[0].compensation, 0.95 * 3.1496, 0.01);
      return;
    }
  FAIL() << "no such point";
}

TEST(Sweep, UsersAreMadeLikeTheSecond) {
  const Sweep sweep = load_sweep("users", {.quick = true, .seconds = 0.0});
  for (const SweepPoint& p : sweep.points) {
    const std::size_t n = p.scene.users.size();
    const std::size_t couplers = p.architecture == "central"       ? n
                                 : p.architecture == "distributed" ? n * n + n
                                                                   : 2 * n;
    EXPECT_EQ(p.scene.couplers.size(), couplers) << p.name;
  }
}

TEST(Sweep, RefusesWithWhatIsAllowed) {
  const std::string scene = "scene: \"axis_distributed\" ";
  const std::pair<std::string, const char*> wrong[] = {
      {"", "no scene"},
      {scene, "no step"},
      {scene + "step { delay: 1 }", "unknown field 'delay'"},
      {scene + "style: HOLT step { }", "'HOLD'"},
      {scene + "step { network { both { dely: 1 } } }", "did you mean 'delay'"},
      {scene + "step { network { both { loss: 5 } } }", "fraction, not percent"},
      {scene + "step { network { both { loss: 0.1 bursts { enter: 0.1 leave: 0.5 } } } }",
       "one kind of loss"},
      {scene + "step { network { there { delay: nan } } }", "there: delay"},
      {scene + "step { users: 3 network { there { delay: 0.01 } } }", "must be alike"},
      {scene + "step { users: 9 }", "within 2 and 8"},
      {scene + "step { network { both { delay: 1 } } }", "packets in flight"},
      {scene + "step { } step { }", "different labels"},
      {scene + "seconds: -1 step { }", "seconds"},
      {scene + "step { set: \"coupler.k99.stiffness=1\" }", "k99"},
      {"scene: \"wall_single\" step { }", "one user"},
      {"scene: \"box_distributed\" step { users: 3 }", "axis scene"},
      {scene + "step { network { both { recorded { one_way: \"no such file\" } } } }",
       "cannot be read"},
      {scene + "step { network { both { recorded { } } } }", "exactly one"},
      {"scene: \"axis_distributed\" step {", ":1:"},
  };
  for (const auto& [text, word] : wrong)
    EXPECT_NE(refusal(text).find(word), std::string::npos) << text << "\n" << refusal(text);
  try {
    static_cast<void>(load_sweep("thesys"));
    FAIL();
  } catch (const SweepError& e) {
    EXPECT_NE(std::string(e.what()).find("did you mean 'thesis'"), std::string::npos) << e.what();
  }
}

TEST(RecordedSeries, RoundTripsAreTimesAndHalves) {
  const File file("trips", "10\n20\n\n5\n");
  const RecordedSeries s = read_round_trips(file.path());
  ASSERT_EQ(s.time.size(), 3u);
  EXPECT_NEAR(s.time[2], 0.030, 1e-12);
  EXPECT_NEAR(s.delay[1], 0.010, 1e-12);
  EXPECT_THROW(static_cast<void>(read_round_trips(File("bad", "10\n-3\n").path())), SweepError);
  EXPECT_THROW(static_cast<void>(read_round_trips(File("empty", "").path())), SweepError);
}

TEST(RecordedSeries, StampsOfOneClockAreMatchedByName) {
  const File sent("sent", "1000000000,a\n1100000000,b\n1200000000,c\n1300000000,a\n");
  const File received("received", "1000004500,a\n1200004700,c\n1300004600,a\n");
  const RecordedSeries s = read_stamps(sent.path(), received.path());
  ASSERT_EQ(s.time.size(), 4u);
  EXPECT_NEAR(s.delay[0], 4.5e-6, 1e-15);
  EXPECT_TRUE(std::isnan(s.delay[1]));
  EXPECT_NEAR(s.delay[2], 4.7e-6, 1e-15);
  EXPECT_NEAR(s.delay[3], 4.6e-6, 1e-15);
  EXPECT_NEAR(s.time[3], 0.3, 1e-12);
}

TEST(RecordedSeries, OneWayHasHolesWherePacketsWereLost) {
  const RecordedSeries s =
      read_one_way(File("oneway", "time_s,delay_s\n0,0.001\n0.5,\n1,nan\n1.5,0.002\n").path());
  ASSERT_EQ(s.time.size(), 4u);
  EXPECT_TRUE(std::isnan(s.delay[1]) && std::isnan(s.delay[2]));
  EXPECT_EQ(s.delay[3], 0.002);
  EXPECT_THROW(static_cast<void>(read_one_way(File("back", "time_s,delay_s\n1,0\n1,0\n").path())),
               SweepError);
  EXPECT_THROW(static_cast<void>(read_one_way(File("head", "t,d\n1,0\n").path())), SweepError);
}

}  // namespace
}  // namespace tandem::harness
