#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <poll.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>
#include <vector>

/// What every peer of `tandem bench latency` is: a program of two processes on the loopback
/// interface. One sends at a fixed rate, each message with the time it was handed over; the other
/// waits for messages in its library's blocking call.
///   bench_latency_NAME RATE_HZ SECONDS BYTES
/// prints {"one_way_ns": [...]} .
namespace tandem::bench {

struct PeerRun {
  double rate_hz = 0.0, seconds = 0.0;
  int bytes = 0;  ///< of a message, >= 16
  [[nodiscard]] int count() const { return static_cast<int>(rate_hz * seconds); }
};

inline std::int64_t peer_now_ns() {
  timespec t{};
  clock_gettime(CLOCK_MONOTONIC, &t);
  return std::int64_t{t.tv_sec} * 1'000'000'000 + t.tv_nsec;
}

/// The receiver's end: hands over when it can be sent to, and what came.
class PeerReport {
 public:
  explicit PeerReport(int pipe) : pipe_(pipe) {}
  /// `port`: where it listens, or 0.
  void ready(std::int64_t port) { put(&port, sizeof port); }
  /// A message with the time it was handed over; false: that was the last one.
  [[nodiscard]] bool take(const void* message) {
    const std::int64_t now = peer_now_ns();
    std::int64_t sent = 0;
    std::memcpy(&sent, message, sizeof sent);
    if (sent < 0) return false;
    ns_.push_back(now - sent);
    return true;
  }
  void end() { put(ns_.data(), ns_.size() * sizeof ns_[0]); }

 private:
  void put(const void* data, std::size_t size) {
    for (const char* at = static_cast<const char*>(data); size > 0;) {
      const ssize_t n = write(pipe_, at, size);
      if (n <= 0) _exit(1);
      at += n, size -= static_cast<std::size_t>(n);
    }
  }
  int pipe_;
  std::vector<std::int64_t> ns_;
};

/// `receive(run, report)` in the one process: ready, then take until it says false.
/// `open(run, port)` in the other gives what is called with (message, bytes) to send one.
template <typename Receive, typename Open>
int run_peer(int words, char** word, Receive&& receive, Open&& open) {
  if (words != 4) {
    std::fprintf(stderr, "usage: %s RATE_HZ SECONDS BYTES\n`tandem bench latency` runs it\n",
                 word[0]);
    return 2;
  }
  const PeerRun run{std::atof(word[1]), std::atof(word[2]), std::max(16, std::atoi(word[3]))};
  std::array<int, 2> ends{};
  if (!(run.rate_hz > 0.0) || pipe(ends.data()) != 0) return 1;
  const pid_t child = fork();
  if (child == 0) {
    close(ends[0]);
    alarm(static_cast<unsigned>(run.seconds) + 20);
    PeerReport report(ends[1]);
    receive(run, report);
    report.end();
    std::_Exit(0);
  }
  close(ends[1]);
  const auto get = [&](void* to, std::size_t size) {
    pollfd end{ends[0], POLLIN, 0};
    return poll(&end, 1, 10'000) > 0 ? read(ends[0], to, size) : -1;
  };
  const auto fail = [&](const char* why) {
    std::fprintf(stderr, "%s: %s\n", word[0], why);
    kill(child, SIGKILL);
    waitpid(child, nullptr, 0);
    return 1;
  };
  std::int64_t port = 0;
  if (get(&port, sizeof port) != sizeof port) return fail("the receiver did not start");
  auto send = open(run, static_cast<int>(port));
  std::vector<char> message(static_cast<std::size_t>(run.bytes));
  const auto put = [&](std::int64_t stamp) {
    std::memcpy(message.data(), &stamp, sizeof stamp);
    send(message.data(), message.size());
  };
  const std::int64_t start = peer_now_ns() + 200'000'000;
  const int settle = static_cast<int>(0.2 * run.rate_hz);  // first ones fault pages in
  for (int i = 0; i < run.count() + settle; ++i) {
    const auto due = start + static_cast<std::int64_t>(1e9 * i / run.rate_hz);
    const timespec at{due / 1'000'000'000, due % 1'000'000'000};
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &at, nullptr) != 0) {
    }
    put(peer_now_ns());
  }
  for (int i = 0; i < 5; ++i) {
    usleep(20'000);
    put(-1);
  }
  std::vector<char> bytes;
  std::array<char, 65536> part{};
  for (ssize_t n; (n = get(part.data(), part.size())) > 0;)
    bytes.insert(bytes.end(), part.data(), part.data() + n);
  kill(child, SIGKILL);
  waitpid(child, nullptr, 0);
  std::vector<std::int64_t> ns(bytes.size() / sizeof(std::int64_t));
  if (!ns.empty()) std::memcpy(ns.data(), bytes.data(), ns.size() * sizeof ns[0]);
  std::printf("{\"one_way_ns\": [");
  const std::size_t skipped = std::min(ns.size(), static_cast<std::size_t>(settle));
  for (std::size_t i = skipped; i < ns.size(); ++i)
    std::printf("%s%lld", i > skipped ? "," : "", static_cast<long long>(ns[i]));
  std::printf("]}\n");
  return 0;
}

}  // namespace tandem::bench
