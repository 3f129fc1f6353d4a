#pragma once

#include <array>
#include <cstdint>

#include "core/latest_value.h"
#include "core/packet.h"
#include "core/records.h"

namespace tandem::core {

/// A tick for those who look on, with what happened in the ticks since the one before.
struct TappedTick {
  TickRecord tick;
  std::int64_t worst_lateness_ns = 0;
  std::int64_t missed = 0;   ///< slots that did not run, since the start
  std::uint32_t faults = 0;  ///< bits of all ticks since the one before
};

/// The newest packet used of one peer, and how many before it.
struct TappedPacket {
  PacketRecord record;
  std::int64_t count = 0;
};

/// What the force thread leaves for one onlooker (a window, or the sender of spectators'
/// snapshots): its newest tick, once every `every` ticks, and each peer's newest packet. The force
/// thread copies some hundred bytes and never waits; one other thread reads.
class ViewTap {
 public:
  explicit ViewTap(int every = 8) noexcept : every_(every > 0 ? every : 1) {}

  /// Force thread.
  void push(const TickRecord& tick) noexcept {
    const std::int64_t lateness = tick.woke_ns - tick.due_ns;
    if (lateness > next_.worst_lateness_ns) next_.worst_lateness_ns = lateness;
    if (last_slot_ >= 0) next_.missed += tick.slot - last_slot_ - 1;
    last_slot_ = tick.slot;
    next_.faults |= tick.faults;
    if (++since_ < every_) return;
    next_.tick = tick;
    ticks_.publish(next_);
    since_ = 0;
    next_.worst_lateness_ns = 0;
    next_.faults = 0;
  }
  void push(const PacketRecord& packet) noexcept {
    const std::size_t i = index_of(packet.peer);
    if (i >= packets_.size()) return;
    packets_[i].publish({packet, ++counts_[i]});
  }

  /// The onlooker's thread; false if there is nothing new.
  [[nodiscard]] bool fetch(TappedTick& out) noexcept { return ticks_.fetch(out); }
  [[nodiscard]] bool fetch(std::uint32_t peer, TappedPacket& out) noexcept {
    const std::size_t i = index_of(peer);
    return i < packets_.size() && packets_[i].fetch(out);
  }

 private:
  [[nodiscard]] static std::size_t index_of(std::uint32_t peer) noexcept {
    return peer == kServerSender ? kMaxUsers : peer;
  }

  LatestValue<TappedTick> ticks_;
  std::array<LatestValue<TappedPacket>, kMaxUsers + 1> packets_;
  std::array<std::int64_t, kMaxUsers + 1> counts_{};
  TappedTick next_;
  std::int64_t last_slot_ = -1;
  int since_ = 0, every_;
};

}  // namespace tandem::core
