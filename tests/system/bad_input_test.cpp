// What people and networks get wrong, on the running program: each a clear message or a counted
// reason, and no force felt of it.

#include <chrono>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <limits>
#include <unistd.h>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "cli/replay_recording.h"
#include "core/clock.h"
#include "net/session.h"
#include "net/state_codec.h"
#include "net/udp_socket.h"
#include "scene/load_scene.h"
#include "scene/shared_hash.h"
#include "tests/system/program.h"

namespace tandem::test {
namespace {

/// Runs to its end; checks exit status and that all of `words` are in what it said.
void expect_refused(const std::vector<std::string>& arguments,
                    const std::vector<std::string>& words, int status = 1) {
  Program program(arguments);
  EXPECT_EQ(program.wait(), status) << program.output();
  for (const std::string& word : words)
    EXPECT_NE(program.output().find(word), std::string::npos)
        << "\"" << word << "\" is not in: " << program.output();
}

std::vector<std::string> server(const std::string& address, const std::string& seconds) {
  return node({"server", "--scene", "box_central", "--bind", address, "--seconds", seconds});
}

TEST(BadInput, AddressesThatCannotBe) {
  const std::string a = free_address();
  Program first(server(a, "4"));
  ASSERT_TRUE(first.says("at " + a));
  expect_refused(server(a, "1"), {a, "in use"});
  expect_refused(server("no.such.host.invalid:7000", "1"), {"no.such.host.invalid"});
  expect_refused(server("127.0.0.1", "1"), {"127.0.0.1", "port"});
  expect_refused(node({"client", "no.such.host.invalid:7000"}), {"no.such.host.invalid"});
  const std::string nobody = free_address();
  expect_refused(node({"client", nobody, "--wait", "5.5"}), {nobody, "no answer"});
}

TEST(BadInput, WordsAndNumbersThatAreNone) {
  expect_refused({"replicate"}, {"no command 'replicate'", "did you mean 'replica'?"}, 2);
  expect_refused({"bench", "nothing"}, {"no command 'nothing'", "wakeup"}, 2);
  for (const char* option : {"--seconds", "--delay-packets", "--loss", "--jitter-ms"})
    expect_refused({"simulate", "--scene", "axis_distributed", option, "nan"}, {option, "nan"}, 2);
  expect_refused({"demo", "--seconds", "nan"}, {"--seconds", "nan"}, 2);
  expect_refused({"demo", "--scene", "box_central"}, {"--scene", "--arch"}, 2);
  expect_refused({"demo", "--arch", "distributed", "--scene", "box_central"},
                 {"--arch", "box_central", "central"}, 2);
  expect_refused({"probe", "127.0.0.1:9", "--count", "-5"}, {"--count", "10000000"}, 2);
  expect_refused({"probe", "127.0.0.1:9", "--picture", "a.png"}, {"--picture", ".svg"}, 2);
  expect_refused({"simulate", "--csv", "/nowhere/a.csv"}, {"--csv", "/nowhere"}, 2);
  expect_refused({"simulate", "--scene", "axis_single", "--seed", "-1"}, {"--seed", "-1", "0"}, 2);
}

TEST(BadInput, OptionsOfNetemThatDoNotGoTogether) {
  expect_refused({"netem", "--virtual", "--seed", "-1"}, {"--seed", "-1", "0"}, 2);
  expect_refused({"netem", "--virtual", "--host-clock"}, {"--virtual", "--host-clock"}, 2);
  expect_refused({"netem", "--sweep", "thesis", "--no-search"}, {"--no-search", "--virtual"}, 2);
  expect_refused({"netem", "--sweep", "all"}, {"--sweep", "--virtual"}, 2);
  expect_refused({"netem", "--sweep", "nonsense"}, {"nonsense", "thesis", "./nonsense"}, 2);
}

TEST(BadInput, ASweepThatCannotWriteOneFileWritesTheOthers) {
  namespace fs = std::filesystem;
  const fs::path folder = fs::temp_directory_path() / ("tandem-full-" + std::to_string(getpid()));
  fs::create_directories(folder);
  const std::string json = folder / "out.json";
  // A device that is always full.
  expect_refused(
      {"netem", "--virtual", "--quick", "--no-search", "--csv", "/dev/full", "--json", json},
      {"/dev/full", "No space left"});
  EXPECT_GT(fs::file_size(json), 1000u);
  fs::remove_all(folder);
}

TEST(BadInput, ASceneThatIsCheckedSaysItsProblemsAsJsonToo) {
  const std::string file = scratch("check.json");
  expect_refused(
      {"scene", "check", "--scene", "axis_single", "--set", "object.box.mass=0", "--json", file},
      {"object.box.mass"}, 2);
  const auto json = json_in(file);
  EXPECT_EQ(json["valid"], false);
  EXPECT_EQ(json["problems"][0]["field"], "object.box.mass");
}

TEST(BadInput, ASceneWithoutSilenceHoldsNobodysHand) {
  expect_refused(node({"replica", "--scene", "box_distributed", "--set", "silence=none", "--user",
                       "1", "--bind", free_address(), "--seconds", "1"}),
                 {"silence", "--without-silence"});
}

TEST(BadInput, ScenesThatDoNotFit) {
  expect_refused(node({"server", "--scene", "box_distributed"}), {"architecture", "replica"});
  expect_refused(node({"replica", "--scene", "box_central", "--user", "1"}),
                 {"architecture", "server"});
  expect_refused(node({"replica", "--scene", "box_distributed", "--user", "nobody"}),
                 {"nobody", "1, 2"});
  expect_refused(node({"replica", "--scene", "box_distributed", "--user", "2"}), {"--peer 1="});
  expect_refused(node({"server", "--scene", "no_such_scene"}), {"no_such_scene"}, 2);
  const std::string empty = scratch("empty.scene");
  std::ofstream(empty).close();
  expect_refused(node({"server", "--scene", empty}), {"empty.scene"}, 2);
}

TEST(BadInput, TheServerRefusesByReason) {
  const std::string a = free_address();
  Program host(server(a, "6"));
  ASSERT_TRUE(host.says("at " + a));
  expect_refused(node({"client", a, "--user", "3"}), {"3", "1", "2"});
  expect_refused(node({"client", a, "--user", "1"}), {"1"});  // sits at the server
  expect_refused(node({"client", a, "--scene", "box_central", "--set", "object.box.mass=0.5"}),
                 {"scene"});
  Program second(node({"client", a, "--user", "2", "--seconds", "3"}));
  ASSERT_TRUE(host.says("joined"));
  expect_refused(node({"client", a, "--user", "2"}), {"2"});  // taken by one that lives
  expect_refused(node({"client", a}), {"full"});
  EXPECT_EQ(second.wait(), 0) << second.output();
}

TEST(BadInput, AReplicaThatIsRefusedEndsItself) {
  const std::string a = free_address();
  Program host(node(
      {"replica", "--scene", "box_distributed", "--user", "1", "--bind", a, "--seconds", "5"}));
  ASSERT_TRUE(host.says("at " + a));
  // It runs while it asks to join; refused, it must not go on by itself as if all were well.
  Program other(node({"replica", "--scene", "box_distributed", "--set", "object.box.mass=0.5",
                      "--user", "2", "--peer", "1=" + a, "--seconds", "60"}));
  EXPECT_EQ(other.wait(10.0), 1) << other.output();
  EXPECT_NE(other.output().find("other scene"), std::string::npos) << other.output();
}

TEST(BadInput, RecordingsThatCannotBe) {
  expect_refused(node({"server", "--scene", "box_central", "--bind", free_address(), "--seconds",
                       "1", "--record", "/no/such/folder/x.h5"}),
                 {"/no/such/folder/x.h5", "folder"});
  // A disk that is full after 300 kB: the session goes on, what is safe can be read.
  const std::string file = scratch("full.h5");
  Program full(node({"server", "--scene", "box_central", "--bind", free_address(), "--seconds", "5",
                     "--record", file, "--json", scratch("full.json")}),
               300'000);
  EXPECT_EQ(full.wait(), 1) << full.output();
  EXPECT_NE(full.output().find("full.h5"), std::string::npos);
  EXPECT_NE(full.output().find("safe"), std::string::npos) << full.output();
  std::ifstream in(scratch("full.json"));
  const auto j = nlohmann::json::parse(in);
  EXPECT_GT(j["ticks"], 4000) << "the force loop went on";
  EXPECT_GT(j["recording"]["ticks"], 100);
  EXPECT_GT(j["recording"]["lost"], 0);
  const cli::ReplayResult r = cli::replay_recording(file);
  EXPECT_GE(r.ticks, 100u);
  EXPECT_FALSE(r.difference.has_value());
}

TEST(BadInput, WhatCannotBeWrittenAtTheEndIsRefusedAtTheStart) {
  expect_refused(node({"server", "--scene", "box_central", "--json", "/no/such/folder/x.json"}),
                 {"/no/such/folder"}, 2);
  expect_refused(node({"server", "--scene", "box_central", "--seconds", "-1"}),
                 {"--seconds", "-1", "at least 0"}, 2);
  expect_refused({"demo", "--out", "/proc/demo"}, {"--out", "/proc/demo"}, 2);
  expect_refused(node({"replica", "--scene", "box_distributed", "--user", "1", "--hands",
                       "recorded", "--hand-file", "/no/such/hand.csv"}),
                 {"/no/such/hand.csv", "cannot be read"});
}

/// tandem analyze COMMAND --scene SCENE ...
std::vector<std::string> analyze(const char* command, const char* scene,
                                 std::vector<std::string> more) {
  std::vector<std::string> all{"analyze", command, "--scene", scene};
  all.insert(all.end(), more.begin(), more.end());
  return all;
}

TEST(BadInput, AnalysisNamesFieldAndRange) {
  const std::string mass = "object.box.mass";
  for (const char* command : {"point", "damping", "bounds", "compensate"}) {
    expect_refused(analyze(command, "axis_single", {"--set", mass + "=0"}), {mass, "above 0"}, 2);
    expect_refused(analyze(command, "axis_single", {"--set", mass + "=nan"}), {mass}, 2);
    expect_refused(analyze(command, "axis_single", {"--delay-packets", "nan"}),
                   {"--delay-packets", "nan", "60"}, 2);
    expect_refused(analyze(command, "space_box", {}), {"SPACE"});
  }
  const auto vary = [&](const std::string& text, const std::vector<std::string>& words) {
    expect_refused(analyze("stability", "axis_distributed", {"--vary", text}), words, 2);
  };
  vary("coupler.k11.stiffness=5:1", {"k11", "go up"});
  vary("coupler.k11.stiffness=1:1", {"go up"});
  vary("coupler.k11.stiffness=nan:1", {"go up"});
  vary("coupler.k11.stiffness=-1:1", {"from 0"});
  vary("coupler.k11.stiffness=0:1:0", {"1 to 1000000"});
  vary("coupler.k11.stiffness=0:1:99999999999999", {"1 to 1000000"});
  vary("coupler.k11.stiffness", {"FROM:TO"});
  vary("coupler.nobody.stiffness=0:1", {"nobody", "k11", "ko2"});
  vary("coupler.k11.colour=0:1", {"colour", "stiffness, damping"});
  vary("object.box.mass=0:1", {"above 0", "0.001"});
  expect_refused(analyze("stability", "axis_distributed",
                         {"--vary", "coupler.k11.stiffness=0:1:20000", "--vary",
                          "coupler.k22.stiffness=0:1:20000"}),
                 {"20000 times 20000", "take fewer"}, 2);
  expect_refused(analyze("admittance", "axis_central", {"--user", "3"}), {"3", "1, 2"}, 2);
  expect_refused(analyze("admittance", "axis_central", {"--axis", "y"}), {"--axis", "only x"}, 2);
  expect_refused(analyze("admittance", "axis_central", {"--from", "nan"}), {"--from", "nan"}, 2);
  expect_refused(analyze("compensate", "axis_distributed", {"--leave", "1.5"}), {"--leave"}, 2);
  expect_refused(analyze("bounds", "axis_single", {"--device-damping", "-1"}), {"--device-damping"},
                 2);
  expect_refused(analyze("bounds", "axis_single", {"--csv", "/no/such/folder/x.csv"}),
                 {"/no/such/folder"}, 2);
  expect_refused(analyze("compensate", "box_central_table_8_1", {"--delay-packets", "1"}),
                 {"unstable without compensation"});
}

TEST(BadInput, ASignalToTheDemoEndsEverythingItStarted) {
  Program demo({"demo", "--arch", "distributed", "--seconds", "60", "--out", scratch("ended")});
  // Past the start: the nodes run, and cyclictest beside them if it is there.
  sleep_seconds(4.0);
  demo.signal(SIGTERM);
  // Everything in it ends at once; cyclictest by itself would go on for a minute.
  EXPECT_EQ(demo.wait(10.0), 1) << demo.output();
  EXPECT_NE(demo.output().find("stopped"), std::string::npos) << demo.output();
  for (const char* user : {"1", "2"}) {
    const cli::ReplayResult r =
        cli::replay_recording(scratch("ended/distributed_user_" + std::string(user) + ".h5"));
    EXPECT_TRUE(r.complete);
    EXPECT_FALSE(r.difference.has_value());
  }
}

TEST(BadInput, SignalsAtAnyMomentEndItInOrder) {
  int in_order = 0;
  for (const int signal : {SIGINT, SIGTERM})
    for (const double moment : {0.0, 0.02, 0.1, 0.3, 0.8}) {
      const std::string file = scratch("signal.h5");
      std::filesystem::remove(file);
      Program p(node({"server", "--scene", "box_central", "--bind", free_address(), "--record",
                      file, "--json", scratch("signal.json")}));
      sleep_seconds(moment);
      p.signal(signal);
      const int status = p.wait(5.0);
      // Before the node is up the signal does what it does to any program.
      EXPECT_TRUE(status == 0 || status == 128 + signal) << status << " " << p.output();
      if (status != 0) continue;
      ++in_order;
      const cli::ReplayResult r = cli::replay_recording(file);
      EXPECT_TRUE(r.complete) << "signal " << signal << " after " << moment << " s";
      EXPECT_EQ(r.records_lost, 0);
      EXPECT_FALSE(r.difference.has_value());
    }
  EXPECT_GE(in_order, 2);
}

/// A peer that speaks the protocol rightly until it is told to send something else.
class Stranger {
 public:
  explicit Stranger(const std::string& server)
      : link_("127.0.0.1:0"), session_([&] {
          net::GuestOptions o;
          o.host = link_.resolve(server);
          o.host_text = server;
          o.user_name = "2";
          o.scene_hash = scene::shared_hash(scene::load_scene("box_central"));
          o.program_version = "stranger";
          o.seed = 7;
          return o;
        }()) {}

  bool join() {
    for (int i = 0; i < 200 && session_.state() != net::GuestSession::State::kJoined; ++i) turn();
    return session_.state() == net::GuestSession::State::kJoined;
  }
  void turn() {
    core::MonotonicClock clock;
    session_.poll(clock.now_ns());
    while (auto datagram = session_.next_datagram()) link_.send(datagram->to, datagram->bytes);
    link_.wait(10'000'000);
    std::array<std::uint8_t, 2000> buffer;
    net::Endpoint from;
    while (const auto size = link_.receive(from, buffer))
      session_.on_datagram({buffer.data(), *size}, from, clock.now_ns());
    while (session_.next_event()) {
    }
  }
  /// A right packet of user 2: two fingers in the plane at rest, where the scene puts them.
  [[nodiscard]] core::StatePacket packet(std::uint64_t sequence) const {
    core::StatePacket p;
    p.sender = 1;
    p.sequence = sequence;
    p.slot = static_cast<std::int64_t>(8 * sequence);
    p.send_ns = core::monotonic_ns();
    p.value_count = 8;
    p.values = {-0.035, -0.012, 0, 0, 0.035, -0.012, 0, 0};
    return p;
  }
  void send(const core::StatePacket& packet) {
    const auto bytes = encoder_.encode(packet, session_.welcome().session);
    link_.send(session_.options().host, bytes);
  }
  void send(std::span<const std::uint8_t> bytes) { link_.send(session_.options().host, bytes); }
  [[nodiscard]] std::vector<std::uint8_t> encoded(const core::StatePacket& packet) {
    const auto bytes = encoder_.encode(packet, session_.welcome().session);
    return {bytes.begin(), bytes.end()};
  }

 private:
  net::UdpLink link_;
  net::GuestSession session_;
  net::StateEncoder encoder_;
};

TEST(BadInput, JunkAtARunningServerIsCountedByReasonAndNotFelt) {
  const std::string a = free_address();
  auto arguments = server(a, "4");
  arguments.insert(arguments.end(),
                   {"--record", scratch("junk.h5"), "--json", scratch("junk.json")});
  Program host(arguments);
  ASSERT_TRUE(host.says("at " + a));
  ASSERT_TRUE(host.says("spins"));  // from here on it takes packets
  Stranger stranger(a);
  ASSERT_TRUE(stranger.join());

  constexpr int kEach = 10;
  std::uint64_t sequence = 0;
  for (int i = 0; i < 20; ++i) {
    stranger.send(stranger.packet(++sequence));
    stranger.turn();
  }
  for (int i = 0; i < kEach; ++i) {
    core::StatePacket bad = stranger.packet(sequence + 1);
    bad.values[0] = std::numeric_limits<double>::quiet_NaN();
    stranger.send(bad);
    bad.values[0] = 1e6;  // a finger 1000 km away
    stranger.send(bad);
    bad.values[0] = 0.0;
    bad.value_count = 6;
    stranger.send(bad);
    stranger.send(stranger.packet(sequence));  // twice
    bad = stranger.packet(sequence + 1);
    bad.sender = 0;  // says it is the server's own user
    stranger.send(bad);
    auto bytes = stranger.encoded(stranger.packet(sequence + 1));
    stranger.send(std::span(bytes).first(bytes.size() / 2));  // cut off
    bytes[4] = 99;                                            // of another version
    stranger.send(bytes);
    bytes[0] = 'X';  // of another protocol
    stranger.send(bytes);
    stranger.turn();
  }
  std::uint32_t noise = 1;
  for (int i = 0; i < 2000; ++i) {  // random bytes
    std::array<std::uint8_t, 200> bytes;
    for (auto& b : bytes)
      b = static_cast<std::uint8_t>((noise = noise * 1664525u + 1013904223u) >> 24);
    stranger.send(bytes);
    if (i % 50 == 0) stranger.turn();  // or the system drops what does not fit its queue
  }
  stranger.turn();
  // An old one: number 25 overtakes number 24.
  stranger.send(stranger.packet(sequence + 5));
  stranger.send(stranger.packet(sequence + 4));
  stranger.turn();
  ASSERT_EQ(host.wait(), 0) << host.output();

  std::ifstream in(scratch("junk.json"));
  const auto j = nlohmann::json::parse(in);
  ASSERT_EQ(j["peers"].size(), 1u);
  const auto& rejected = j["peers"][0]["rejected"];
  for (const char* reason :
       {"not_finite", "out_of_range", "duplicate", "malformed", "wrong_version"})
    EXPECT_GE(rejected.value(reason, 0), kEach) << reason << " in " << rejected.dump();
  EXPECT_GE(rejected.value("wrong_magic", 0), 1000) << rejected.dump();
  int counted = 0;
  for (const auto& [reason, count] : rejected.items()) counted += count.get<int>();
  EXPECT_EQ(rejected.value("stale_sequence", 0) + rejected.value("old_sequence", 0), 1)
      << rejected.dump();
  // 8 kinds, 2000 random ones and one old; a datagram that the system drops in a flood is not seen.
  EXPECT_GE(counted, 1500);
  EXPECT_EQ(j["peers"][0]["received"], sequence + 1);
  EXPECT_EQ(j["allocations_in_force_loop"], 0);
  EXPECT_LT(j["largest_force_n"], 10.0);

  // Not felt: what the law was given is what was right, and its answer is what it gave.
  const cli::ReplayResult r = cli::replay_recording(scratch("junk.h5"));
  EXPECT_LE(r.packets, sequence + 1);
  EXPECT_FALSE(r.difference.has_value());
}

int run(const std::string& command) { return std::system((command + " 2>/dev/null").c_str()); }

TEST(Namespaces, TwoReplicasMeetAcrossAVirtualCable) {
  if (geteuid() != 0) GTEST_SKIP() << "needs root: makes network namespaces";
  const std::string id = std::to_string(getpid());
  const std::string a = "tsa" + id, b = "tsb" + id;
  struct Remove {
    std::string a, b;
    ~Remove() {
      run("ip netns del " + a);
      run("ip netns del " + b);
    }
  } const remove{a, b};
  if (run("ip netns add " + a) != 0 || run("ip netns add " + b) != 0 ||
      run("ip link add " + a + " netns " + a + " type veth peer name " + b + " netns " + b) != 0)
    GTEST_SKIP() << "no network namespaces here";
  // nsenter, not `ip netns exec`: that remounts /, which a chroot does not allow.
  const std::string in_a = "nsenter --net=/run/netns/" + a + " ";
  const std::string in_b = "nsenter --net=/run/netns/" + b + " ";
  run(in_a + "ip addr add 10.74.0.1/24 dev " + a);
  run(in_b + "ip addr add 10.74.0.2/24 dev " + b);
  run(in_a + "ip link set " + a + " up");
  run(in_b + "ip link set " + b + " up");
  const std::string common = std::string(TANDEM_PROGRAM " replica --scene box_distributed") +
                             " --seconds 4 --no-memory-lock --quiet --json ";
  const std::string one = in_a + common + scratch("ns1.json") +
                          " --user 1 --bind 10.74.0.1:7001 > " + scratch("ns1.txt");
  const std::string two = in_b + common + scratch("ns2.json") +
                          " --user 2 --bind 10.74.0.2:7002 --peer 1=10.74.0.1:7001 > " +
                          scratch("ns2.txt");
  EXPECT_EQ(run("(" + one + " & p=$!; " + two + "; s=$?; wait $p && exit $s)"), 0);
  for (const char* name : {"ns1.json", "ns2.json"}) {
    std::ifstream in(scratch(name));
    ASSERT_TRUE(in.good()) << name;
    const auto j = nlohmann::json::parse(in);
    EXPECT_GT(j["packets_received"], 400) << name;
    EXPECT_EQ(j["sequence_errors"], 0) << name;
  }
}

}  // namespace
}  // namespace tandem::test
