#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/link_model.h"

namespace tandem::analysis {

/// What can happen to a packet of one directed link, as whole ticks between the tick that sends it
/// and the one that uses it: a modelled link's fractions act as the next whole tick.
struct PacketFates {
  struct Delay {
    std::int64_t ticks = 0;
    double probability = 0.0;  ///< given that it arrives
  };
  std::vector<Delay> delays;  ///< shortest first
  double loss = 0.0;          ///< outside bursts
  double burst_enter = 0.0, burst_leave = 1.0;

  [[nodiscard]] bool has_bursts() const { return burst_enter > 0.0; }
  [[nodiscard]] bool fixed() const { return delays.size() == 1 && loss == 0.0 && !has_bursts(); }
};

/// Tails of a distribution beyond this are left out; no run is long enough to see them.
inline constexpr double kLeastChance = 1e-12;

/// Empty `why` if every packet's fate is drawn by itself (bursts: from a chain of two states), so
/// that the mean square is exact; else why it is not, and `fates` means nothing.
struct FatesOfLink {
  PacketFates fates;
  std::string why;
};
/// Recorded delays count as independent draws from their histogram.
[[nodiscard]] FatesOfLink fates_of(const core::LinkModelParameters& link);

}  // namespace tandem::analysis
