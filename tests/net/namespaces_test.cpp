// Two network namespaces joined by a veth pair, as two computers on a cable: what loopback hides
// (addresses of an interface, ARP, a real path between) is there. Makes and removes its own.
#include <array>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fcntl.h>
#include <sched.h>
#include <string>
#include <thread>
#include <unistd.h>

#include <gtest/gtest.h>

#include "core/clock.h"
#include "core/periodic_schedule.h"
#include "net/peer_link.h"
#include "net/probe.h"
#include "net/udp_socket.h"

namespace tandem::net {
namespace {

/// Runs a command; its output if it fails.
std::string failure_of(const std::string& command) {
  std::FILE* pipe = popen((command + " 2>&1").c_str(), "r");
  if (pipe == nullptr) return "cannot run " + command;
  std::array<char, 256> line;
  std::string output;
  while (std::fgets(line.data(), line.size(), pipe) != nullptr) output += line.data();
  return pclose(pipe) == 0 ? "" : command + ": " + output;
}

class TwoNamespaces : public testing::Test {
 protected:
  void SetUp() override {
    if (geteuid() != 0) GTEST_SKIP() << "needs root: makes network namespaces";
    const std::string id = std::to_string(getpid());
    a_ = "tandem_a_" + id;
    b_ = "tandem_b_" + id;
    const std::string cable_a = "ta" + id, cable_b = "tb" + id;
    // nsenter, not `ip -n`: that remounts /, which a chroot does not allow.
    const std::string in_a = "nsenter --net=/run/netns/" + a_ + " ";
    const std::string in_b = "nsenter --net=/run/netns/" + b_ + " ";
    for (const std::string& command :
         {"ip netns add " + a_, "ip netns add " + b_,
          "ip link add " + cable_a + " netns " + a_ + " type veth peer name " + cable_b +
              " netns " + b_,
          in_a + "ip addr add 10.73.0.1/24 dev " + cable_a,
          in_b + "ip addr add 10.73.0.2/24 dev " + cable_b, in_a + "ip link set " + cable_a + " up",
          in_b + "ip link set " + cable_b + " up"}) {
      const std::string failure = failure_of(command);
      if (!failure.empty()) GTEST_SKIP() << "no network namespaces here: " << failure;
    }
    home_ = open("/proc/self/ns/net", O_RDONLY | O_CLOEXEC);
  }

  void TearDown() override {
    if (home_ >= 0) {
      setns(home_, CLONE_NEWNET);
      close(home_);
    }
    for (const std::string& name : {a_, b_})
      if (!name.empty()) failure_of("ip netns del " + name);
  }

  /// Runs `make` with this thread inside a namespace; a socket stays where it was made.
  template <typename Make>
  auto inside(const std::string& name, Make make) {
    const int fd = open(("/run/netns/" + name).c_str(), O_RDONLY | O_CLOEXEC);
    EXPECT_EQ(setns(fd, CLONE_NEWNET), 0);
    close(fd);
    auto made = make();
    EXPECT_EQ(setns(home_, CLONE_NEWNET), 0);
    return made;
  }

  std::string a_, b_;
  int home_ = -1;
};

/// Publishes 128 packets a second to one peer and counts what it fetches.
void force_loop(PeerLink& link, std::uint32_t peer, std::int64_t start_ns,
                const std::atomic<bool>& stop, std::uint64_t& fetched) {
  core::MonotonicClock clock;
  core::PeriodicSchedule schedule(start_ns, 128.0);
  while (!stop) {
    const auto wake = schedule.wait(clock);
    PeerSample sample;
    if (link.inbox(peer).fetch(sample)) ++fetched;
    core::StatePacket packet;
    packet.slot = wake.slot;
    packet.value_count = 12;
    link.outbox(peer).publish(packet);
  }
}

TEST_F(TwoNamespaces, HandshakeSceneAndTwoSecondsOfState) {
  PeerLinkOptions server_options;
  server_options.bind = "10.73.0.1:7000";
  server_options.host = HostOptions{.user_names = {"1"},
                                    .seats = {Seat::kOpen},
                                    .scene_hash = 5,
                                    .scene_text = std::string(5000, 's'),
                                    .program_version = "test"};
  PeerLinkOptions client_options;
  client_options.bind = "10.73.0.2:0";
  client_options.join = {"10.73.0.1:7000"};
  client_options.user_name = "1";
  auto server = inside(a_, [&] { return std::make_unique<PeerLink>(server_options); });
  auto client = inside(b_, [&] { return std::make_unique<PeerLink>(client_options); });
  server->start();
  client->start();
  const JoinResult joined = client->wait_until_joined(5);
  ASSERT_TRUE(joined.joined) << joined.error;
  EXPECT_EQ(joined.scene_text.size(), 5000u);

  ExchangeOptions exchange;
  exchange.start_ns = core::monotonic_ns() + 10'000'000;
  exchange.own_sender = core::kServerSender;
  exchange.values_from[0] = 12;
  server->open_exchange(exchange);
  exchange.own_sender = 0;
  exchange.values_from[0] = -1;
  exchange.values_from[core::kMaxUsers] = 12;
  client->open_exchange(exchange);

  std::atomic<bool> stop{false};
  std::uint64_t at_server = 0, at_client = 0;
  std::thread s([&] { force_loop(*server, 0, exchange.start_ns, stop, at_server); });
  std::thread c(
      [&] { force_loop(*client, core::kServerSender, exchange.start_ns, stop, at_client); });
  std::this_thread::sleep_for(std::chrono::seconds(2));
  stop = true;
  s.join();
  c.join();
  std::this_thread::sleep_for(std::chrono::milliseconds(50));

  const LinkSnapshot up = server->statistics(0), down = client->statistics(core::kServerSender);
  for (const LinkSnapshot& t : {up, down}) {
    EXPECT_GT(t.accepted, 200u);  // 256 on a machine that is not stalled
    EXPECT_EQ(t.lost, 0u);
    EXPECT_EQ(t.by_reason.rejected(), 0u);
    EXPECT_GT(t.round_trip.count, 100u);
    EXPECT_GT(t.one_way_bound, 0.0);
  }
  EXPECT_EQ(up.accepted, down.packets_sent);
  EXPECT_EQ(down.accepted, up.packets_sent);
  EXPECT_GT(at_server, 200u);
  EXPECT_GT(at_client, 200u);
  std::printf("veth: round trip mean %.3f ms p99 %.3f ms, one way %.3f ms +- %.3f ms\n",
              1e3 * down.round_trip.mean, 1e3 * down.round_trip.p99, 1e3 * down.one_way.mean,
              1e3 * down.one_way_bound);
}

TEST_F(TwoNamespaces, ProbeFindsTheServerAndNotWhereNoneIs) {
  auto far = inside(a_, [] { return std::make_unique<UdpLink>("10.73.0.1:7001"); });
  auto near = inside(b_, [] { return std::make_unique<UdpLink>("10.73.0.2:0"); });
  std::atomic<bool> stop{false};
  std::thread server([&] { serve_probe(*far, stop); });
  const std::atomic<bool> go_on{false};
  const auto r = run_probe(*near, near->resolve("10.73.0.1:7001"), {.count = 500}, go_on);
  stop = true;
  server.join();
  EXPECT_EQ(r.lost(), 0u);
  std::printf("%s", probe_table(r, "10.73.0.1:7001").c_str());

  const auto nobody =
      run_probe(*near, near->resolve("10.73.0.1:7002"), {.count = 20, .patience = 0.1}, go_on);
  EXPECT_EQ(nobody.received, 0u);
}

TEST_F(TwoNamespaces, AnAddressOfTheOtherSideCannotBeBound) {
  inside(b_, [] {
    EXPECT_THROW(UdpLink("10.73.0.1:7000"), std::runtime_error);
    return 0;
  });
}

}  // namespace
}  // namespace tandem::net
