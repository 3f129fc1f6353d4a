#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <functional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "core/clock.h"
#include "core/periodic_schedule.h"
#include "net/peer_link.h"

namespace tandem::net {

inline constexpr std::uint64_t kHash = 77;
inline constexpr int kValues = 12;

inline HostOptions host_options(std::uint32_t own, std::vector<Seat> seats) {
  HostOptions o;
  o.own_sender = own;
  for (std::size_t i = 0; i < seats.size(); ++i) o.user_names.push_back(std::to_string(i + 1));
  o.seats = std::move(seats);
  o.scene_hash = kHash;
  o.scene_text = std::string(2500, 's');
  o.program_version = "test";
  return o;
}

inline PeerLinkOptions hosting(std::uint32_t own, std::vector<Seat> seats) {
  PeerLinkOptions o;
  o.bind = "127.0.0.1:0";
  o.host = host_options(own, std::move(seats));
  return o;
}

inline PeerLinkOptions joining(std::vector<std::string> hosts, const std::string& user,
                               std::uint64_t hash = kHash) {
  PeerLinkOptions o;
  o.bind = "127.0.0.1:0";
  o.join = std::move(hosts);
  o.user_name = user;
  o.scene_hash = hash;
  o.program_version = "test";
  return o;
}

inline std::string address_of(const PeerLink& link) { return to_string(link.local()); }

/// Waits for a condition that other threads bring about; the limit is for a stalled machine.
inline bool eventually(const std::function<bool()>& condition, double seconds = 5.0) {
  const auto end = core::monotonic_ns() + static_cast<std::int64_t>(1e9 * seconds);
  while (!condition()) {
    if (core::monotonic_ns() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return true;
}

/// Plays the force loop: at 1024 Hz it fetches what arrived, and every 8 ticks publishes a packet
/// whose values name sender and slot, so that every receiver can tell.
class ForceLoop {
 public:
  ForceLoop(PeerLink& link, std::uint32_t own, std::vector<std::uint32_t> peers,
            std::int64_t start_ns, bool frozen = false)
      : link_(link), own_(own), peers_(std::move(peers)) {
    ExchangeOptions exchange;
    exchange.own_sender = own;
    exchange.start_ns = start_ns;
    for (auto p : peers_) exchange.values_from[static_cast<std::size_t>(peer_index(p))] = kValues;
    link_.open_exchange(exchange);
    received.resize(peers_.size());
    if (!frozen) thread_ = std::thread([this, start_ns] { run(start_ns); });
  }
  ~ForceLoop() { stop(); }
  void stop() {
    stop_ = true;
    if (thread_.joinable()) thread_.join();
  }

  std::vector<std::vector<PeerSample>> received;  ///< by position in `peers`; read after stop()
  std::uint64_t published = 0;
  std::uint64_t stalls = 0;  ///< times the computer left out half a packet period or more

 private:
  void run(std::int64_t start_ns) {
    core::MonotonicClock clock;
    core::PeriodicSchedule schedule(start_ns, 1024.0);
    std::int64_t next_packet = 0, last_slot = -1;
    while (!stop_) {
      const auto wake = schedule.wait(clock);
      if (last_slot >= 0 && wake.slot - last_slot > 4) ++stalls;
      last_slot = wake.slot;
      PeerSample sample;
      for (std::size_t i = 0; i < peers_.size(); ++i)
        if (link_.inbox(peers_[i]).fetch(sample)) received[i].push_back(sample);
      if (wake.slot < next_packet) continue;
      next_packet = (wake.slot / 8 + 1) * 8;
      core::StatePacket packet;
      packet.slot = wake.slot;
      packet.value_count = kValues;
      packet.values[0] = own_;
      packet.values[1] = static_cast<double>(wake.slot % 1000);
      for (auto p : peers_) link_.outbox(p).publish(packet);
      ++published;
    }
  }

  PeerLink& link_;
  std::uint32_t own_;
  std::vector<std::uint32_t> peers_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

/// What every list of received samples must satisfy, whatever the timing.
inline void expect_consistent(const std::vector<PeerSample>& samples, std::uint32_t sender) {
  std::uint64_t sequence = 0;
  std::uint32_t epoch = 0;
  for (const auto& s : samples) {
    if (s.left) continue;
    ASSERT_EQ(s.packet.sender, sender);
    ASSERT_EQ(s.packet.values[0], sender);
    ASSERT_EQ(s.packet.values[1], static_cast<double>(s.packet.slot % 1000));
    if (s.epoch == epoch) {
      ASSERT_GT(s.packet.sequence, sequence);
    }
    ASSERT_GE(s.epoch, epoch);
    epoch = s.epoch;
    sequence = s.packet.sequence;
    ASSERT_GE(s.age_at_arrival_ns, 0);
  }
}

}  // namespace tandem::net
