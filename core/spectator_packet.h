#pragma once

#include <cstdint>

#include "core/packet.h"
#include "core/records.h"
#include "core/view_tap.h"

namespace tandem::core {

/// What a spectator needs to know to read a node's ticks: how many of each a scene has.
struct SpectatorLayout {
  int fingers = 0;      ///< of the node's own user
  int hand_values = 0;  ///< of a position: 1 axis, 2 plane, 3 space
  int objects = 0;
  int object_values = 0;  ///< of an object's state
  int users = 0;

  [[nodiscard]] int value_count() const noexcept {
    return 3 * fingers * hand_values + objects * object_values + users + 1;
  }
};

namespace detail {

/// The one order of a node's tick on its way to a spectator: own fingers' positions and velocities,
/// objects, forces on the fingers, ages of all users' samples, worst lateness [s].
template <typename Tick, typename Value>
void visit_spectator_values(Tick& t, const SpectatorLayout& l, Value&& value) {
  for (int f = 0; f < l.fingers; ++f) {
    for (int i = 0; i < l.hand_values; ++i) value(t.hands[f].position[i]);
    for (int i = 0; i < l.hand_values; ++i) value(t.hands[f].velocity[i]);
  }
  for (int o = 0; o < l.objects; ++o)
    for (int i = 0; i < l.object_values; ++i) value(t.objects[o][i]);
  for (int f = 0; f < l.fingers; ++f)
    for (int i = 0; i < l.hand_values; ++i) value(t.command[f][i]);
  for (int u = 0; u < l.users; ++u) value(t.ages[u]);
}

}  // namespace detail

/// Fills all but sender, sequence and stamps. Energy counters carry the missed slots and the fault
/// bits (WIRE_FORMAT.md).
inline void pack_spectator(const TappedTick& tapped, const SpectatorLayout& layout,
                           StatePacket& packet) noexcept {
  packet.value_count = 0;
  const auto put = [&](double x) {
    if (packet.value_count < kMaxPacketValues)
      packet.values[static_cast<std::size_t>(packet.value_count++)] = x;
  };
  detail::visit_spectator_values(tapped.tick, layout, put);
  put(1e-9 * static_cast<double>(tapped.worst_lateness_ns));
  packet.slot = tapped.tick.slot;
  packet.contact_bits = tapped.tick.contact_bits[0];
  packet.energy_in = static_cast<double>(tapped.missed);
  packet.energy_out = static_cast<double>(tapped.faults);
}

/// The way back; `packet` has layout.value_count() values.
inline void unpack_spectator(const StatePacket& packet, const SpectatorLayout& layout,
                             TappedTick& tapped) noexcept {
  int next = 0;
  const auto take = [&](double& x) {
    x = next < packet.value_count ? packet.values[static_cast<std::size_t>(next++)] : 0.0;
  };
  tapped = {};
  detail::visit_spectator_values(tapped.tick, layout, take);
  double lateness = 0.0;
  take(lateness);
  tapped.worst_lateness_ns = static_cast<std::int64_t>(1e9 * lateness);
  tapped.tick.slot = packet.slot;
  tapped.tick.contact_bits[0] = packet.contact_bits;
  tapped.missed = static_cast<std::int64_t>(packet.energy_in);
  tapped.faults = static_cast<std::uint32_t>(packet.energy_out);
  tapped.tick.faults = tapped.faults;
}

}  // namespace tandem::core
