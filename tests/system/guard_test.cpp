// What nodes do about a delay that the scene's prediction does not bear, over a relay that holds
// every packet back.

#include <arpa/inet.h>
#include <atomic>
#include <chrono>
#include <deque>
#include <netinet/in.h>
#include <poll.h>
#include <regex>
#include <stdexcept>
#include <sys/socket.h>
#include <thread>
#include <unistd.h>

#include <gtest/gtest.h>

#include "tests/system/program.h"

namespace tandem::test {
namespace {

/// Passes datagrams on between one address and whoever else sends to it, so much later each way.
class Relay {
 public:
  Relay(const std::string& to, std::chrono::milliseconds delay)
      : to_(address(std::stoi(to.substr(to.find(':') + 1)))),
        delay_(delay),
        socket_(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in own = address(0);
    socklen_t size = sizeof own;
    auto* const raw = reinterpret_cast<sockaddr*>(&own);
    if (bind(socket_, raw, size) != 0 || getsockname(socket_, raw, &size) != 0)
      throw std::runtime_error("relay: no port");
    port_ = ntohs(own.sin_port);
    thread_ = std::thread([this] { pass_on(); });
  }
  ~Relay() {
    ended_ = true;
    thread_.join();
    close(socket_);
  }
  Relay(const Relay&) = delete;
  Relay& operator=(const Relay&) = delete;

  [[nodiscard]] std::string where() const { return "127.0.0.1:" + std::to_string(port_); }

 private:
  using Clock = std::chrono::steady_clock;
  struct Datagram {
    Clock::time_point due;
    sockaddr_in to;
    std::string bytes;
  };

  static sockaddr_in address(int port) {
    sockaddr_in out{};
    out.sin_family = AF_INET;
    out.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    out.sin_port = htons(static_cast<std::uint16_t>(port));
    return out;
  }

  void pass_on() {
    sockaddr_in guest{};
    std::deque<Datagram> held;
    char buffer[2048];
    while (!ended_) {
      pollfd readable{.fd = socket_, .events = POLLIN, .revents = 0};
      if (poll(&readable, 1, 1) > 0) {
        sockaddr_in from{};
        socklen_t size = sizeof from;
        const ssize_t got =
            recvfrom(socket_, buffer, sizeof buffer, 0, reinterpret_cast<sockaddr*>(&from), &size);
        if (got >= 0) {
          const bool back = from.sin_port == to_.sin_port;
          if (!back) guest = from;
          held.push_back({Clock::now() + delay_, back ? guest : to_,
                          std::string(buffer, static_cast<std::size_t>(got))});
        }
      }
      for (; !held.empty() && held.front().due <= Clock::now(); held.pop_front())
        sendto(socket_, held.front().bytes.data(), held.front().bytes.size(), 0,
               reinterpret_cast<const sockaddr*>(&held.front().to), sizeof(sockaddr_in));
    }
  }

  sockaddr_in to_;
  std::chrono::milliseconds delay_;
  int socket_, port_ = 0;
  std::atomic<bool> ended_{false};
  std::thread thread_;
};

struct Pair {
  int status_1 = 0, status_2 = 0;
  std::string output_1, output_2;
};

/// Two workstations of box_distributed, user 2 behind the relay.
Pair run_pair(std::chrono::milliseconds each_way, const std::string& on_unstable) {
  const std::string a = free_address();
  const Relay relay(a, each_way);
  const auto replica = [&](const std::string& user, const std::string& bind) {
    std::vector<std::string> out{"replica", "--scene", "box_distributed", "--user",    user,
                                 "--bind",  bind,      "--on-unstable",   on_unstable, "--seconds",
                                 "3"};
    if (user == "2") out.insert(out.end(), {"--peer", "1=" + relay.where()});
    return node(out);
  };
  Program one(replica("1", a)), two(replica("2", free_address()));
  Pair out;
  out.status_1 = one.wait();
  out.status_2 = two.wait();
  out.output_1 = one.output();
  out.output_2 = two.output();
  return out;
}

// A round trip of two packet periods is unstable (resampled 1.030483), 50 ms are three times that.
constexpr std::chrono::milliseconds kTooLate{25}, kHarmless{0};

TEST(Guard, ADelayBeyondThePredictionIsRefusedWithTheGainToLower) {
  const Pair p = run_pair(kTooLate, "refuse");
  // Whoever measures it first says so and leaves; the other may be alone then, and end in order.
  EXPECT_TRUE(p.status_1 == 1 || p.status_2 == 1) << p.output_1 << p.output_2;
  const std::string& said = p.status_2 == 1 ? p.output_2 : p.output_1;
  EXPECT_NE(said.find("predicted"), std::string::npos) << said;
  EXPECT_NE(said.find("refused: the measured delay is outside"), std::string::npos) << said;
  EXPECT_TRUE(std::regex_search(
      said, std::regex("round trip (5[0-9]|6[0-9])\\.[0-9] ms.*growth 1\\.[0-9]+.*unstable")))
      << said;
  EXPECT_TRUE(std::regex_search(
      said, std::regex("lower coupler\\.[a-z0-9.]+ from [0-9.]+ to [0-9.]+.*--set coupler\\.")))
      << said;
}

TEST(Guard, AskedToWarnItGoesOn) {
  const Pair p = run_pair(kTooLate, "warn");
  EXPECT_EQ(p.status_1, 0) << p.output_1;
  EXPECT_EQ(p.status_2, 0) << p.output_2;
  for (const std::string& said : {p.output_1, p.output_2}) {
    EXPECT_NE(said.find("unstable"), std::string::npos) << said;
    EXPECT_NE(said.find("lower coupler."), std::string::npos) << said;
    EXPECT_EQ(said.find("refused"), std::string::npos) << said;
  }
}

TEST(Guard, ARelayWithoutDelayIsNoReason) {
  const Pair p = run_pair(kHarmless, "refuse");
  EXPECT_EQ(p.status_1, 0) << p.output_1;
  EXPECT_EQ(p.status_2, 0) << p.output_2;
  EXPECT_EQ(p.output_2.find("unstable."), std::string::npos) << p.output_2;
  EXPECT_NE(p.output_2.find("are borne"), std::string::npos) << p.output_2;
}

}  // namespace
}  // namespace tandem::test
