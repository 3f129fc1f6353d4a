#include "analysis/packet_fates.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace tandem::analysis {

namespace {

/// Chance that the jitter is at most x [ticks].
double chance_below(const core::LinkModelParameters& link, double x) {
  const double width = link.jitter_ticks;
  switch (link.jitter) {
    case core::JitterKind::kNone:
      break;
    case core::JitterKind::kUniform:
      return std::clamp(0.5 * (x / width + 1.0), 0.0, 1.0);
    case core::JitterKind::kNormal:
      return 0.5 * std::erfc(-x / (width * std::sqrt(2.0)));
    case core::JitterKind::kExponential:
      return x <= 0.0 ? 0.0 : -std::expm1(-x / width);
  }
  return x >= 0.0 ? 1.0 : 0.0;
}

}  // namespace

FatesOfLink fates_of(const core::LinkModelParameters& link) {
  FatesOfLink out;
  PacketFates& fates = out.fates;
  if (link.first_in_first_out && (link.jitter != core::JitterKind::kNone || !link.recorded.empty()))
    out.why = "in a first-in-first-out link a packet waits for those before it";
  if (link.duplicate > 0.0) out.why = "packets are doubled";
  if (link.outage_length > 0) out.why = "an outage has its time, not a chance";
  fates.burst_enter = link.burst_enter;
  fates.burst_leave = link.burst_leave;
  fates.loss = link.loss;

  if (!link.recorded.empty()) {
    std::map<std::int64_t, double> counts;
    double lost = 0.0;
    const double each = 1.0 / static_cast<double>(link.recorded.size());
    for (const double delay : link.recorded)
      if (delay >= 0.0)
        counts[static_cast<std::int64_t>(std::ceil(delay + link.delay_ticks))] += each;
      else
        lost += each;
    for (const auto& [ticks, p] : counts) fates.delays.push_back({ticks, p / (1.0 - lost)});
    fates.loss = 1.0 - (1.0 - fates.loss) * (1.0 - lost);
    return out;
  }
  if (link.jitter == core::JitterKind::kNone || link.jitter_ticks == 0.0) {
    fates.delays.push_back({static_cast<std::int64_t>(std::ceil(link.delay_ticks)), 1.0});
    return out;
  }
  // A delay below zero acts as none, one of t - 1 < delay <= t as t.
  double below = 0.0, sum = 0.0;
  for (std::int64_t t = 0; 1.0 - below > kLeastChance; ++t) {
    const double up_to = chance_below(link, static_cast<double>(t) - link.delay_ticks);
    if (up_to - below > kLeastChance) fates.delays.push_back({t, up_to - below});
    below = up_to;
  }
  for (const PacketFates::Delay& d : fates.delays) sum += d.probability;
  for (PacketFates::Delay& d : fates.delays) d.probability /= sum;
  return out;
}

}  // namespace tandem::analysis
