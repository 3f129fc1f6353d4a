#pragma once

#include <cmath>
#include <cstdint>

namespace tandem::core {

/// When packets leave: with the force loop, or by a timer of their own.
enum class PacketTimer {
  kForceLoop,  ///< in the first tick at or after k / packet_hz, with that tick's state
  /// At k / packet_hz exactly, between two ticks, with the state of the last tick at or before: so
  /// a network thread with its own timer sends (reference analysis, H8). Models only; nodes send
  /// with the force loop. The same where the ratio of the rates is whole.
  kOwn,
};

/// Which ticks send a packet, in whole numbers: `packets` packets every `ticks` ticks, the ratio of
/// the rates in lowest terms. Packet k leaves in tick ceil(k ticks / packets), so tick t sends if
/// (t packets) mod ticks < packets: t mod N = 0 for a whole ratio N. With a timer of its own: the
/// floor. The pattern repeats exactly, for ever: nothing is added up that could drift.
struct PacketSlots {
  std::int64_t ticks = 8;
  std::int64_t packets = 1;
  PacketTimer timer = PacketTimer::kForceLoop;

  /// The fraction of smallest denominator within 1e-12 of local_hz / packet_hz, or the whole number
  /// within 1e-9: a rate typed with 15 digits means the fraction it stands for.
  [[nodiscard]] static PacketSlots of(double local_hz, double packet_hz) noexcept;

  /// Number of the newest packet that has left by tick `slot` (>= 0).
  [[nodiscard]] std::int64_t packet_at(std::int64_t slot) const noexcept {
    const std::int64_t in = slot % ticks;
    return slot / ticks * packets +
           (timer == PacketTimer::kOwn ? (in + 1) * packets - 1 : in * packets) / ticks;
  }
  /// The tick whose state packet number `packet` (>= 0) carries.
  [[nodiscard]] std::int64_t tick_of(std::int64_t packet) const noexcept {
    const std::int64_t in = packet % packets;
    return packet / packets * ticks +
           (timer == PacketTimer::kOwn ? in * ticks : in * ticks + packets - 1) / packets;
  }
  [[nodiscard]] bool sends(std::int64_t slot) const noexcept {
    return tick_of(packet_at(slot)) == slot;
  }
  /// Ticks from `slot` to where the next packet period is as far on: to its start, from a start.
  [[nodiscard]] std::int64_t period_from(std::int64_t slot) const noexcept {
    if (packets == 1) return ticks;
    const std::int64_t packet = packet_at(slot);
    return tick_of(packet + 1) - tick_of(packet);
  }
  [[nodiscard]] double ticks_per_packet() const noexcept {
    return static_cast<double>(ticks) / static_cast<double>(packets);
  }
};

/// The packet ticks of one sender, one after the other, without a division: the remainder of
/// k ticks / packets is carried along.
class PacketTicks {
 public:
  PacketTicks() noexcept = default;
  explicit PacketTicks(const PacketSlots& slots, std::int64_t first = 0) noexcept
      : whole_(slots.ticks / slots.packets),
        rest_(slots.ticks % slots.packets),
        packets_(slots.packets),
        next_(first),
        own_(slots.timer == PacketTimer::kOwn) {}

  /// True in a packet tick, once; to be asked in every tick.
  [[nodiscard]] bool due(std::int64_t slot) noexcept {
    if (slot != next_) return false;
    late_ = over_;
    next_ += whole_;
    over_ += rest_;
    if (own_ ? over_ >= packets_ : over_ > 0) {
      ++next_;
      over_ -= packets_;
    }
    return true;
  }

  /// How long after its tick the packet that was due last leaves [ticks], below 1.
  [[nodiscard]] double late() const noexcept {
    return own_ ? static_cast<double>(late_) / static_cast<double>(packets_) : 0.0;
  }

 private:
  std::int64_t whole_ = 8, rest_ = 0, packets_ = 1;
  std::int64_t next_ = 0;
  /// k ticks - packets next_: 0 .. packets - 1 with an own timer, 1 - packets .. 0 without.
  std::int64_t over_ = 0, late_ = 0;
  bool own_ = false;
};

inline PacketSlots PacketSlots::of(double local_hz, double packet_hz) noexcept {
  const double ratio = local_hz / packet_hz;
  if (!(ratio >= 1.0) || !(ratio < 1e6)) return {1, 1};  // outside what a scene may say
  const double nearest = std::round(ratio);
  if (std::abs(ratio - nearest) <= 1e-9 * ratio) return {static_cast<std::int64_t>(nearest), 1};
  // Convergents of the continued fraction. One that is not yet within 1e-12 has a denominator below
  // 10^6 and no next term that could overflow.
  std::int64_t n0 = 1, d0 = 0, n1 = static_cast<std::int64_t>(std::floor(ratio)), d1 = 1;
  double rest = ratio - std::floor(ratio);
  while (std::abs(static_cast<double>(n1) / static_cast<double>(d1) - ratio) > 1e-12 * ratio) {
    const double next = 1.0 / rest;
    const auto term = static_cast<std::int64_t>(std::floor(next));
    rest = next - std::floor(next);
    const std::int64_t n2 = term * n1 + n0, d2 = term * d1 + d0;
    n0 = n1, d0 = d1, n1 = n2, d1 = d2;
  }
  return {n1, d1};
}

}  // namespace tandem::core
