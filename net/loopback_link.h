#pragma once

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <vector>

#include "net/link.h"

namespace tandem::net {

class LoopbackLink;

/// A network inside one process, for tests: datagrams arrive at once and in order, unless `fate`
/// says otherwise. Endpoints are 127.0.0.1 and the port given.
class LoopbackNetwork {
 public:
  /// How many copies of a datagram arrive: 1 as a rule, 0 lost, 2 duplicated. Called under a lock.
  using Fate = std::function<int(const Endpoint& from, const Endpoint& to,
                                 std::span<const std::uint8_t> datagram)>;

  explicit LoopbackNetwork(Fate fate = {}) : fate_(std::move(fate)) {}

  /// The network must live longer than its links.
  [[nodiscard]] std::unique_ptr<LoopbackLink> open(std::uint16_t port);

  [[nodiscard]] static Endpoint endpoint(std::uint16_t port) {
    return {.ip = {127, 0, 0, 1}, .port = port, .is_v6 = false};
  }

 private:
  friend class LoopbackLink;
  struct Arrived {
    Endpoint from;
    std::vector<std::uint8_t> bytes;
  };
  Fate fate_;
  std::mutex mutex_;
  std::condition_variable arrival_;
  std::map<std::uint16_t, std::deque<Arrived>> queues_;  ///< by port
};

class LoopbackLink final : public Link {
 public:
  LoopbackLink(LoopbackNetwork& network, std::uint16_t port) : network_(network), port_(port) {}
  ~LoopbackLink() override {
    const std::lock_guard lock(network_.mutex_);
    network_.queues_.erase(port_);
  }

  bool send(const Endpoint& to, std::span<const std::uint8_t> datagram) noexcept override {
    const std::lock_guard lock(network_.mutex_);
    const auto queue = network_.queues_.find(to.port);
    const int copies = network_.fate_ ? network_.fate_(local(), to, datagram) : 1;
    if (queue == network_.queues_.end()) return true;  // nobody there: UDP does not tell either
    for (int i = 0; i < copies; ++i)
      queue->second.push_back({local(), {datagram.begin(), datagram.end()}});
    network_.arrival_.notify_all();
    return true;
  }

  [[nodiscard]] std::optional<std::size_t> receive(
      Endpoint& from, std::span<std::uint8_t> buffer) noexcept override {
    const std::lock_guard lock(network_.mutex_);
    auto& queue = network_.queues_[port_];
    if (queue.empty()) return std::nullopt;
    const auto arrived = std::move(queue.front());
    queue.pop_front();
    from = arrived.from;
    const std::size_t size = std::min(buffer.size(), arrived.bytes.size());
    std::copy_n(arrived.bytes.begin(), size, buffer.begin());
    return size;
  }

  void wait(std::int64_t timeout_ns) noexcept override {
    std::unique_lock lock(network_.mutex_);
    network_.arrival_.wait_for(lock, std::chrono::nanoseconds(timeout_ns),
                               [&] { return !network_.queues_[port_].empty(); });
  }

  [[nodiscard]] Endpoint resolve(const std::string& host_port) const override {
    return LoopbackNetwork::endpoint(parse_host_port(host_port).port);
  }

  [[nodiscard]] Endpoint local() const noexcept override {
    return LoopbackNetwork::endpoint(port_);
  }

 private:
  LoopbackNetwork& network_;
  std::uint16_t port_;
};

inline std::unique_ptr<LoopbackLink> LoopbackNetwork::open(std::uint16_t port) {
  const std::lock_guard lock(mutex_);
  queues_[port];
  return std::make_unique<LoopbackLink>(*this, port);
}

}  // namespace tandem::net
