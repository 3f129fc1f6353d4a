// Networks on this machine: namespaces, conditions that change, and a short sweep on real sockets
// behind netem or in user-mode Linux.
#include <algorithm>
#include <cmath>
#include <csignal>
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
#include "harness/recorded_session.h"
#include "harness/session_batches.h"
#include "scene/load_scene.h"

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
  for (const char* site : {"-2", "-7"}) {  // ours to be, and one more than we make
    const std::string taken = name + site;
    if (run_program({"ip", "netns", "add", taken}).status != 0)
      GTEST_SKIP() << "no network namespaces here";
    try {
      const Namespaces network(name, 2);
      ADD_FAILURE() << taken << " was there already, and was taken";
    } catch (const HarnessError& e) {
      EXPECT_NE(std::string(e.what()).find(taken), std::string::npos) << e.what();
    }
    EXPECT_EQ(namespaces_of(name), std::vector<std::string>{taken});
    remove_namespaces({taken});
    EXPECT_TRUE(namespaces_of(name).empty());
  }
}

TEST(NamespacesTest, OnlyNamesThatWeGiveAreLeftOfKilledRuns) {
  if (geteuid() != 0) GTEST_SKIP() << "needs root: makes network namespaces";
  // Of a process that cannot be: above the largest number there is.
  const std::vector<std::string> ours{"tandem-4194999-a-1", "tandem-4194999-b-bridge"},
      others{"tandem-4194999-mylab", "tandem-4194999-a-x", "tandem-4194999-1"};
  for (const auto& names : {ours, others})
    for (const std::string& name : names)
      if (run_program({"ip", "netns", "add", name}).status != 0)
        GTEST_SKIP() << "no network namespaces here";
  const std::vector<std::string> left = left_namespaces();
  for (const std::string& name : ours) EXPECT_EQ(std::count(left.begin(), left.end(), name), 1);
  for (const std::string& name : others) EXPECT_EQ(std::count(left.begin(), left.end(), name), 0);
  remove_namespaces(ours);
  remove_namespaces(others);
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

TEST(MeasuredNetworkTest, HasTheDelaysThePhasesAndTheAgesOfTheSession) {
  std::vector<MeasuredLink> links(2);
  links[0].to = links[1].from = 1;
  links[0].phase_ticks = 3;
  links[0].steady_ticks = 5.5;
  links[1].steady_ticks = 2.0;
  links[0].age_error_ticks = -1.25;
  links[1].age_error_ticks = 1.5;
  links[0].fates = {5.0, -1.0, 6.0};
  const core::NetworkModel mean = measured_network(links), each = replayed_network(links);
  EXPECT_EQ(mean.link[0][1].delay_ticks, 5.5);
  EXPECT_EQ(mean.link[1][0].delay_ticks, 2.0);
  ASSERT_EQ(each.link[0][1].recorded.size(), 3u);
  EXPECT_EQ(each.link[0][1].recorded[1], -1.0);
  for (const core::NetworkModel* network : {&mean, &each}) {
    EXPECT_EQ(network->phase_ticks[0], 3);
    EXPECT_EQ(network->link[0][1].age_error_ticks, -1.25);
    EXPECT_EQ(network->link[1][0].age_error_ticks, 1.5);
  }
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

/// Two points without a condition: they need network namespaces, but no netem.
Sweep two_clear_points() {
  Sweep sweep;
  sweep.name = "test";
  for (const char* name : {"axis_distributed", "axis_distributed_split"}) {
    SweepPoint& point = sweep.points.emplace_back();
    point.name = point.scene_name = name;
    point.scene = scene::load_scene(name);
    point.seconds = 2.0;
  }
  return sweep;
}

class ClearNetworkTest : public testing::Test {
 protected:
  void SetUp() override {
    if (geteuid() != 0) GTEST_SKIP() << "needs root: makes network namespaces";
    try {
      const Namespaces network(own_network_name() + "-try", 2);
    } catch (const HarnessError& e) {
      GTEST_SKIP() << e.what();
    }
    folder_ = fs::temp_directory_path() / ("tandem-clear-test-" + std::to_string(getpid()));
    fs::create_directories(folder_);
    options_.program.file = TANDEM_PROGRAM;
    options_.name = own_network_name();
    options_.folder = folder_;
    options_.at_once = 2;
    options_.most_nodes = 4;
    options_.carry = options_.push = options_.touch = options_.probe = options_.tries = false;
  }
  void TearDown() override {
    if (!folder_.empty()) fs::remove_all(folder_);
  }
  fs::path folder_;
  RealOptions options_;
};

TEST_F(ClearNetworkTest, ANodeThatDiesMarksItsPointAndTheSweepGoesOn) {
  // Stands for the program: replica 2 of the first point is killed in the middle of its session.
  const fs::path stand_in = folder_ / "stand-in";
  std::ofstream(stand_in) << "#!/bin/sh\n"
                             "case \"$*\" in *001_kick_user_2*)\n"
                             "  echo its last words\n"
                             "  (sleep 1.7; kill -9 $$) >/dev/null 2>&1 &\n"
                             "esac\n"
                             "exec " TANDEM_PROGRAM " \"$@\"\n";
  fs::permissions(stand_in, fs::perms::owner_all);
  options_.program.file = stand_in;
  const std::vector<PointResult> results = run_real_sweep(two_clear_points(), options_);
  ASSERT_EQ(results.size(), 2u);
  EXPECT_TRUE(results[0].failed);
  EXPECT_NE(results[0].log.find("replica 2 ended with 137"), std::string::npos) << results[0].log;
  EXPECT_NE(results[0].log.find("its last words"), std::string::npos) << results[0].log;
  EXPECT_FALSE(results[1].failed) << results[1].log;
  // Sockets cost at least a tick each way, and on an idle machine little more; but a tick that the
  // machine held up can use a packet of its own slot.
  ASSERT_EQ(results[1].seen.size(), 2u);
  for (const SeenLink& link : results[1].seen) EXPECT_GE(link.delay_ticks, 0.9);
  ASSERT_TRUE(results[1].prediction.judged) << results[1].prediction.note;
  // Predicted is this network with its ticks, not one that takes no time.
  EXPECT_GT(results[1].prediction.drag,
            1.05 * predicted_drag(results[1].point.scene, core::NetworkModel{}));
  EXPECT_TRUE(results[1].measures.stability.stable) << results[1].measures.stability.reason;
  EXPECT_TRUE(results[1].twin.judged && results[1].twin.stable);
  EXPECT_TRUE(namespaces_of(own_network_name() + "-a").empty());
}

// Receivers refuse its numbers then, and the samples in use grow old; the network is as before.
TEST_F(ClearNetworkTest, ASessionThatBlowsUpKeepsTheDelaysOfItsNetwork) {
  Sweep sweep = two_clear_points();
  sweep.points.resize(1);
  sweep.points[0].scene = with_coupling(sweep.points[0].scene, 3e4);
  const std::vector<PointResult> results = run_real_sweep(sweep, options_);
  ASSERT_EQ(results.size(), 1u);
  ASSERT_FALSE(results[0].failed) << results[0].log;
  EXPECT_FALSE(results[0].measures.stability.stable);
  EXPECT_TRUE(results[0].twin.judged && !results[0].twin.stable);
  // A tick or a few each way, and half a packet period: 5 ms; blown up it was 0.7 s.
  EXPECT_LT(results[0].mean_age, 0.02);
}

TEST_F(ClearNetworkTest, NodesThatCannotWriteSayWhatTheyCouldNot) {
  fs::create_directories(folder_ / "001_kick_user_1.h5" / "in the way");
  Sweep sweep = two_clear_points();
  sweep.points.resize(1);
  const std::vector<PointResult> results = run_real_sweep(sweep, options_);
  ASSERT_EQ(results.size(), 1u);
  EXPECT_TRUE(results[0].failed);
  EXPECT_NE(results[0].log.find("001_kick_user_1.h5"), std::string::npos) << results[0].log;
}

TEST(RealNetemWords, WithoutNetemAndUserModeLinuxItSaysWhatItNeeds) {
  // Where nothing else sees it, both programs are covered up.
  const Ended ended =
      run_program({"unshare", "-m", "sh", "-c",
                   "for program in tc linux.uml; do\n"
                   "  path=$(PATH=$PATH:/usr/sbin:/sbin command -v $program) || continue\n"
                   "  mount --bind /dev/null $(readlink -f $path) || exit 99\n"
                   "done\n"
                   "exec " TANDEM_PROGRAM " netem --sweep thesis --quick"});
  if (ended.status == 99 || ended.said.find("unshare") != std::string::npos)
    GTEST_SKIP() << "needs root: covers programs up in a mount namespace; " << ended.said;
  EXPECT_NE(ended.status, 0);
  for (const char* word : {"user-mode-linux", "sch_netem", "iproute2", "--virtual"})
    EXPECT_NE(ended.said.find(word), std::string::npos) << word << " in\n" << ended.said;
}

TEST(RealNetemWords, AFolderThatAGuestCannotStartFromIsNamed) {
  if (run_program({TANDEM_PROGRAM, "netem", "--check"}).said.find("user-mode") == std::string::npos)
    GTEST_SKIP() << "sessions do not run in user-mode Linux here";
  const fs::path folder = fs::temp_directory_path() / ("a b" + std::to_string(getpid()));
  fs::create_directories(folder);
  const Ended ended = run_program({"env", "-C", folder, "TMPDIR=" + folder.string(), TANDEM_PROGRAM,
                                   "netem", "--sweep", "thesis", "--quick"});
  EXPECT_NE(ended.status, 0);
  EXPECT_NE(ended.said.find(folder.string()), std::string::npos) << ended.said;
  EXPECT_NE(ended.said.find("TMPDIR"), std::string::npos) << ended.said;
  fs::remove_all(folder);
}

/// `tandem netem` on real sockets, with a sweep of our own. Nothing: it cannot run here.
class RealNetemTest : public testing::Test {
 protected:
  void SetUp() override {
    const Ended check = run_program({TANDEM_PROGRAM, "netem", "--check"});
    if (check.status != 0) GTEST_SKIP() << check.said;
    in_guest_ = check.said.find("user-mode Linux") != std::string::npos;
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
  bool in_guest_ = false;
};

TEST_F(RealNetemTest, ProbeSeesWhatWasSetAndSocketsAreWhereAnalysisAndVirtualTimeSay) {
  const std::string sweep = R"(
    title: "test"  knob: "delay"  unit: "ms"  scene: "axis_distributed"  style: HOLD  seconds: 3
    network { there { delay: 0.005 } back { delay: 0.01 jitter: 0.002 loss: 0.05 } }
    step { value: 5 quick: true })";
  const nlohmann::json out = run(sweep);
  ASSERT_TRUE(out.is_object());
  ASSERT_EQ(out["results"].size(), 1u);
  const auto& point = out["results"][0];
  ASSERT_EQ(out["failed"], 0) << out.dump(1);
  bool there = false, back = false;
  double age_errors = 0.0;
  for (const auto& link : point["seen"]) {
    age_errors += link["age_error_ticks"].get<double>();
    const double p50 = link["delay_p50_s"], sd = link["delay_sd_s"], n = link["sent"],
                 lost = link["lost"];
    if (link["from"] == "1") {
      there = true;
      EXPECT_NEAR(p50, 0.005, 0.3e-3);
      EXPECT_EQ(lost, 0.0);
      // A tick is 0.98 ms. How much more the nodes take is the guest's affair: predictions take
      // what was measured.
      EXPECT_GE(link["delay_ticks"].get<double>(), 5.12);
    } else {
      back = true;
      // 0.3 ms, and three standard errors of the median of normal jitter: 3 * 1.25 * 2 ms / sqrt n.
      EXPECT_NEAR(p50, 0.010, 0.3e-3 + 3.0 * 1.25 * 2e-3 / std::sqrt(n));
      EXPECT_NEAR(sd, 2e-3, 0.2e-3);
      // 99.9 % of the binomial distribution.
      EXPECT_NEAR(lost, 0.05 * n, 3.3 * std::sqrt(0.05 * 0.95 * n));
    }
  }
  EXPECT_TRUE(there && back);
  // What two clocks are off by makes one's ages too high and the other's too low.
  EXPECT_NEAR(age_errors, 0.0, 0.5);
  EXPECT_EQ(out["conditions_not_as_set"].size(), 0u) << out["conditions_not_as_set"];
  const auto& measured = point["measured"];
  EXPECT_TRUE(point["predicted"]["judged"].get<bool>());
  EXPECT_TRUE(measured["stability"]["stable"].get<bool>());
  EXPECT_TRUE(point["virtual_time_over_recorded_packets"]["stable"].get<bool>());
  EXPECT_FALSE(measured["at_1.1_of_predicted"].is_null());
  EXPECT_GT(measured["largest_coupling_n_per_m"].get<double>(), 0.0);
  // Felt at 0.5 Hz, predicted at rest.
  const double stiffness = point["predicted"]["rendered_stiffness_n_per_m"];
  EXPECT_NEAR(measured["rendered_stiffness_n_per_m"].get<double>(), stiffness, 0.02 * stiffness);
  // The delay there, up to a packet period, and a tick each for sending, use and what is felt.
  const double first_felt = measured["motion_to_force_s"];
  EXPECT_GE(first_felt, 0.005);
  EXPECT_LE(first_felt, 0.005 + 1.0 / 128 + 3.0 / 1024);
  if (in_guest_) {  // it cannot be stalled
    EXPECT_EQ(out["verdicts_compared"]["missed_ticks"], 0);
  }
  EXPECT_GE(out["verdicts_compared"]["with_virtual_time"], 2);
  // Jitter and loss: the analysis has a steady network in their place, virtual time the packets.
  EXPECT_EQ(out["disagreements"], 0) << out["disagreement_list"].dump(1);
}

TEST_F(RealNetemTest, KilledInTheMiddleItLeavesNothing) {
  for (const int number : {SIGKILL, SIGINT}) {
    Child program({TANDEM_PROGRAM, "netem", "--quick", "--sweep", "thesis", "--folder",
                   (folder_ / "nodes").string()});
    for (int i = 0; i < 300 && !fs::exists(folder_ / "nodes"); ++i) program.listen(50);
    ASSERT_TRUE(fs::exists(folder_ / "nodes")) << program.said();
    const std::string own = std::to_string(program.pid());
    const auto left = [&] {
      std::vector<std::string> found = namespaces_of("tandem-" + own + "-a");
      for (const auto& entry : fs::directory_iterator(fs::temp_directory_path()))
        if (entry.path().filename().string().starts_with("tandem-guest-" + own + "-"))
          found.push_back(entry.path());
      return found;
    };
    EXPECT_FALSE(left().empty());
    std::vector<pid_t> guests;
    for (const std::string& one : left())
      if (std::ifstream in(one + "/pid"); in) in >> guests.emplace_back();
    program.signal(number);
    const auto status = program.wait(10.0);
    EXPECT_TRUE(status && *status != 0);
    for (int i = 0; i < 100 && !left().empty(); ++i) usleep(50'000);  // the caretaker's time
    EXPECT_TRUE(left().empty()) << left().front();
    for (const pid_t guest : guests) {
      const std::string file = "/proc/" + std::to_string(guest) + "/exe";
      std::error_code gone;  // one that nobody has waited for yet has no program any more either
      for (int i = 0; i < 100 && (void(fs::read_symlink(file, gone)), !gone); ++i)
        usleep(50'000);  // killed, it gives its memory back
      EXPECT_TRUE(gone) << guest << " still runs";
    }
    fs::remove_all(folder_ / "nodes");
  }
}

}  // namespace
}  // namespace tandem::harness
