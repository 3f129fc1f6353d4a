// Networks on this machine: namespaces, conditions that change, and a short sweep on real sockets
// behind netem or in user-mode Linux.
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <unistd.h>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "harness/child.h"
#include "harness/harness_error.h"
#include "harness/namespaces.h"
#include "harness/qdisc_player.h"
#include "harness/real_sweep.h"

namespace tandem::harness {
namespace {

namespace fs = std::filesystem;

TEST(ChildTest, ItsWordsAndItsEndAreKnown) {
  const Ended ended = run_program({"sh", "-c", "echo out; echo err >&2; cat; exit 3"}, "", "in");
  EXPECT_EQ(ended.status, 3);
  EXPECT_EQ(ended.said, "out\nerr\nin");
  EXPECT_THROW(run_program({"no-such-program-here"}).status, HarnessError);
  EXPECT_THROW(must_run({"false"}), HarnessError);
}

TEST(NamespacesTest, ANameThatIsTakenIsRefusedAndLeftAlone) {
  if (geteuid() != 0) GTEST_SKIP() << "needs root: makes a network namespace";
  const std::string name = "taken-" + std::to_string(getpid());
  if (run_program({"ip", "netns", "add", name + "-2"}).status != 0)
    GTEST_SKIP() << "no network namespaces here";
  try {
    const Namespaces network(name, 2);
    ADD_FAILURE() << "a namespace that was there already was taken";
  } catch (const HarnessError& e) {
    EXPECT_NE(std::string(e.what()).find(name + "-2"), std::string::npos) << e.what();
  }
  EXPECT_EQ(namespaces_of(name), std::vector<std::string>{name + "-2"});
  remove_namespaces({name + "-2"});
  EXPECT_TRUE(namespaces_of(name).empty());
}

TEST(NamespacesTest, NamesThatNobodyShouldGiveAreRefused) {
  for (const char* name : {"", "a b", "../x", "-x", "a/b"})
    EXPECT_NE(problem_with_network_name(name), "") << name;
  EXPECT_EQ(problem_with_network_name(own_network_name()), "");
}

TEST(QdiscPlayerTest, AnOutageChangesNetemAtItsEdgesOnly) {
  Condition condition;
  condition.delay = 0.005;
  condition.outage = Outage{.start = 1.0, .length = 0.1, .period = 0.0};
  const auto changes = changes_of(condition, 5.0);
  ASSERT_EQ(changes.size(), 2u);
  EXPECT_EQ(changes[0].time, 1.0);
  EXPECT_NEAR(changes[1].time, 1.1, 1e-12);  // a sum of two doubles
  EXPECT_NE(changes[0].netem_arguments, changes[1].netem_arguments);
  EXPECT_TRUE(changes_of(Condition{}, 5.0).empty());
}

TEST(RealSweepTest, EveryFingerGetsADeviceWithALimitOfItsOwn) {
  core::Scene scene;
  scene.users.resize(2);
  for (int u = 0; u < 2; ++u) {
    scene.users[u].name = std::to_string(u + 1);
    scene.users[u].fingers.resize(1);
    scene.users[u].fingers[0].name = "a";
  }
  scene = with_limited_devices(scene);
  ASSERT_EQ(scene.devices.size(), 2u);
  EXPECT_NE(scene.users[0].fingers[0].device, scene.users[1].fingers[0].device);
  for (const core::DeviceParameters& device : scene.devices) EXPECT_GT(device.max_force, 0.0);
}

/// `tandem netem` on real sockets, with a sweep of our own. Nothing: it cannot run here.
class RealNetemTest : public testing::Test {
 protected:
  void SetUp() override {
    const Ended check = run_program({TANDEM_PROGRAM, "netem", "--check"});
    if (check.status != 0) GTEST_SKIP() << check.said;
    folder_ = fs::temp_directory_path() / ("tandem-netem-test-" + std::to_string(getpid()));
    fs::create_directories(folder_);
  }
  void TearDown() override {
    if (!folder_.empty()) fs::remove_all(folder_);
  }
  nlohmann::json run(const std::string& sweep) {
    std::ofstream(folder_ / "test.sweep") << sweep;
    Child program({TANDEM_PROGRAM, "netem", "--quick", "--sweep", folder_ / "test.sweep", "--json",
                   folder_ / "out.json", "--folder", folder_ / "nodes"});
    const auto status = program.wait(110.0);
    EXPECT_EQ(status, 0) << program.said();
    std::ifstream in(folder_ / "out.json");
    return nlohmann::json::parse(in, nullptr, false);
  }
  fs::path folder_;
};

TEST_F(RealNetemTest, ProbeSeesWhatWasSetAndSocketsAreOnThePredictedSide) {
  const nlohmann::json out = run(R"(
    title: "test"  knob: "delay"  unit: "ms"  scene: "axis_distributed"  style: HOLD  seconds: 3
    network { there { delay: 0.01 } back { delay: 0.02 jitter: 0.002 loss: 0.05 } }
    step { value: 10 quick: true })");
  ASSERT_TRUE(out.is_object());
  ASSERT_EQ(out["results"].size(), 1u);
  const auto& point = out["results"][0];
  EXPECT_EQ(out["failed"], 0) << out.dump(1);
  bool there = false, back = false;
  for (const auto& link : point["seen"]) {
    const double p50 = link["delay_p50_s"], sd = link["delay_sd_s"], n = link["sent"],
                 lost = link["lost"];
    if (link["from"] == "1") {
      there = true;
      EXPECT_NEAR(p50, 0.010, 0.3e-3);
      EXPECT_EQ(lost, 0.0);
      // A tick is 0.98 ms. How much more the nodes take is the guest's affair, with one processor
      // for all of them 3 to 10 ticks were seen: predictions take what was measured.
      EXPECT_GE(link["delay_ticks"].get<double>(), 10.24);
    } else {
      back = true;
      // 0.3 ms, and three standard errors of the median of normal jitter: 3 * 1.25 * 2 ms / sqrt n.
      EXPECT_NEAR(p50, 0.020, 0.3e-3 + 3.0 * 1.25 * 2e-3 / std::sqrt(n));
      EXPECT_NEAR(sd, 2e-3, 0.2e-3);
      // 99.9 % of the binomial distribution.
      EXPECT_NEAR(lost, 0.05 * n, 3.3 * std::sqrt(0.05 * 0.95 * n));
    }
  }
  EXPECT_TRUE(there && back);
  EXPECT_TRUE(point["predicted"]["judged"].get<bool>());
  EXPECT_TRUE(point["measured"]["stability"]["judged"].get<bool>());
  EXPECT_TRUE(point["measured"]["stability"]["stable"].get<bool>());
}

}  // namespace
}  // namespace tandem::harness
