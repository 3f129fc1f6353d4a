#include "net/probe.h"

#include <stdexcept>
#include <thread>

#include <gtest/gtest.h>

#include "net/loopback_link.h"
#include "net/udp_socket.h"

namespace tandem::net {
namespace {

/// An echo server on its own thread.
class Server {
 public:
  explicit Server(Link& link) : thread_([this, &link] { answered = serve_probe(link, stop_); }) {}
  ~Server() { join(); }
  void join() {
    stop_ = true;
    if (thread_.joinable()) thread_.join();
  }
  std::uint64_t answered = 0;

 private:
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

const std::atomic<bool> kGoOn{false};

TEST(Probe, EveryPacketComesBackOverUdp) {
  UdpLink far("127.0.0.1:0"), near("127.0.0.1:0");
  Server server(far);
  const auto r =
      run_probe(near, far.local(), {.rate_hz = 1250, .count = 500, .datagram = 200}, kGoOn);
  server.join();
  EXPECT_EQ(r.sent, 500u);
  EXPECT_EQ(r.received, 500u);
  EXPECT_EQ(r.lost(), 0u);
  EXPECT_EQ(r.duplicates + r.reordered + r.strangers, 0u);
  EXPECT_EQ(server.answered, 500u);
  // 499 periods of 0.8 ms; 2 % is 8 ms for the last packet of a busy machine to leave late.
  EXPECT_NEAR(r.achieved_rate_hz, 1250.0, 25.0);
  EXPECT_GT(r.min, 0.0);
  EXPECT_LE(r.p50, r.p99);
}

TEST(Probe, DatagramsHaveTheSizeAskedFor) {
  for (const std::size_t size : {48u, 163u, 165u, 166u, 500u, 1200u}) {
    std::size_t seen = 0;
    LoopbackNetwork network([&](auto&&, auto&&, std::span<const std::uint8_t> d) {
      seen = d.size();
      return 1;
    });
    auto near = network.open(1);
    const auto r =
        run_probe(*near, LoopbackNetwork::endpoint(2),
                  {.rate_hz = 1e5, .count = 1, .datagram = size, .patience = 0.0}, kGoOn);
    // The length of 128 bytes of padding takes a byte more than that of 127.
    EXPECT_EQ(seen, size == 165 ? 164 : size);
    EXPECT_EQ(r.datagram, seen);
    EXPECT_EQ(r.lost(), 1u);
  }
}

// Every tenth lost on the way there, every seventh of those that come back doubled: known exactly.
TEST(Probe, LossAndDuplicatesAreCountedExactly) {
  int there = 0, back = 0, lost = 0, doubled = 0;
  LoopbackNetwork network([&](const Endpoint& from, auto&&...) {
    if (from.port == 1) return ++there % 10 == 0 ? (++lost, 0) : 1;
    return ++back % 7 == 0 ? (++doubled, 2) : 1;
  });
  auto near = network.open(1), far = network.open(2);
  Server server(*far);
  const auto r =
      run_probe(*near, far->local(), {.rate_hz = 5000, .count = 1000, .patience = 0.3}, kGoOn);
  server.join();
  EXPECT_EQ(r.lost(), 100u);
  EXPECT_EQ(lost, 100);
  EXPECT_EQ(r.received, 900u);
  EXPECT_EQ(r.duplicates, static_cast<std::uint64_t>(doubled));
}

TEST(Probe, SummaryOfKnownRoundTripsIsWhatTheHandGives) {
  ProbeResult r;
  r.sent = 6;
  r.received = 4;
  r.seconds = 0.5;
  r.round_trip_ns = {3'000'000, -1, 1'000'000, 5'000'000, 3'000'000, -1};
  summarise(r);
  EXPECT_DOUBLE_EQ(r.mean, 3e-3);
  EXPECT_NEAR(r.rms_jitter, std::sqrt(2.0) * 1e-3, 1e-15);  // sqrt((0 + 4 + 4 + 0) / 4)
  EXPECT_DOUBLE_EQ(r.p10, 1e-3);
  EXPECT_DOUBLE_EQ(r.p50, 3e-3);
  EXPECT_DOUBLE_EQ(r.p90, 5e-3);
  EXPECT_DOUBLE_EQ(r.min, 1e-3);
  EXPECT_DOUBLE_EQ(r.achieved_rate_hz, 10.0);
  const std::string table = probe_table(r, "here:1");
  EXPECT_NE(table.find("3.0000 ms"), std::string::npos) << table;
  EXPECT_NE(table.find("2 packets out of 6"), std::string::npos);
  EXPECT_NE(table.find("1250 a second, not 128"), std::string::npos);
  EXPECT_NE(probe_picture(r, "a<b").find("</svg>"), std::string::npos);
  EXPECT_EQ(probe_picture(r, "a<b").find("a<b"), std::string::npos);
}

TEST(Probe, NobodyThereIsAllLostAndEndsInTime) {
  UdpLink near("127.0.0.1:0"), deaf("127.0.0.1:0");
  const auto r =
      run_probe(near, deaf.local(), {.rate_hz = 1000, .count = 20, .patience = 0.1}, kGoOn);
  EXPECT_EQ(r.lost(), 20u);
  EXPECT_EQ(probe_histogram(r), "");
  EXPECT_NE(probe_table(r, "x").find("20 packets out of 20"), std::string::npos);
}

TEST(Probe, AnInterruptedProbeGivesWhatItHas) {
  UdpLink near("127.0.0.1:0"), far("127.0.0.1:0");
  Server server(far);
  std::atomic<bool> stop{false};
  std::thread interrupt([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    stop = true;
  });
  const auto r = run_probe(near, far.local(), {.rate_hz = 500, .seconds = 60}, stop);
  interrupt.join();
  EXPECT_TRUE(r.interrupted);
  EXPECT_GT(r.received, 10u);
  EXPECT_LT(r.sent, 1000u);
  EXPECT_EQ(r.round_trip_ns.size(), r.sent);
}

TEST(Probe, LimitsAreNamed) {
  const auto refuses = [](const ProbeOptions& o, const std::string& says) {
    try {
      (void)o.packets();
    } catch (const std::invalid_argument& e) {
      EXPECT_NE(std::string(e.what()).find(says), std::string::npos) << e.what();
      return true;
    }
    return false;
  };
  EXPECT_TRUE(refuses({.rate_hz = 0, .count = 1}, "rate is 0"));
  EXPECT_TRUE(refuses({.rate_hz = std::nan(""), .count = 1}, "rate is nan"));
  EXPECT_TRUE(refuses({.rate_hz = 1e5, .seconds = 1e4}, "number of packets is 1000000000"));
  EXPECT_TRUE(refuses({.count = 1, .datagram = 20}, "48 to 1200"));
  EXPECT_TRUE(refuses({}, "number of packets or a duration"));
  EXPECT_EQ((ProbeOptions{.rate_hz = 128, .count = 1000, .seconds = 2}).packets(), 256u);
}

}  // namespace
}  // namespace tandem::net
