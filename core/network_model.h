#pragma once

#include <array>
#include <cmath>

#include "core/link_model.h"
#include "core/scene.h"

namespace tandem::core {

/// Every directed link of a session in virtual time. `link[i][j]`: from site i to site j; site
/// kMaxUsers is the server. Defaults: nothing takes time, nothing is lost.
struct NetworkModel {
  static constexpr int kServer = kMaxUsers;
  std::array<std::array<LinkModelParameters, kMaxUsers + 1>, kMaxUsers + 1> link{};
  /// Packet slots of site i come this much later than those of core/packet_slots.h.
  std::array<int, kMaxUsers + 1> phase_ticks{};
  PacketTimer packet_timer = PacketTimer::kForceLoop;

  /// The same treatment for every link, each with a seed of its own.
  void set_all(const LinkModelParameters& parameters) noexcept {
    Random seeds(parameters.seed);
    for (auto& row : link)
      for (auto& one : row) {
        one = parameters;
        one.seed = seeds.bits();
      }
  }

  /// Round trip of D packet periods, all of it on one direction of each pair: from the lower to the
  /// higher user (link 1 to 2), and central on the returned force. Only the sum matters to
  /// eigenvalues and driving-point responses when D is whole.
  void set_round_trip(double delay_packets, double ticks_per_packet) noexcept {
    double ticks = delay_packets * ticks_per_packet;
    // 25 packets of 10.24 ticks are 256 ticks, not a rounding more, which would act as 257.
    if (const double whole = std::round(ticks); std::abs(ticks - whole) < 1e-9 * whole)
      ticks = whole;
    for (int i = 0; i <= kMaxUsers; ++i)
      for (int j = 0; j <= kMaxUsers; ++j)
        link[i][j].delay_ticks = (i < j && j != kServer) || i == kServer ? ticks : 0.0;
  }
};

}  // namespace tandem::core
