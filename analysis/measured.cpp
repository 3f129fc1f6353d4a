#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>

#include "analysis/growth.h"
#include "analysis/lifted.h"
#include "analysis/period_probe.h"
#include "analysis/with_loop.h"

namespace tandem::analysis {

namespace {

constexpr std::int64_t kMostPacketsLifted = 200000;
constexpr std::int64_t kMostPeriodsKept = 5000;  ///< of a repeat, for frequency responses

/// Keeps a product of many maps within the range of numbers.
void shrink(Matrix& m, double& scale) {
  double largest = 0.0;
  for (const double x : m.values) largest = std::max(largest, std::abs(x));
  if (!(largest > 1e120) || !std::isfinite(largest)) return;
  const int e = std::ilogb(largest);
  for (double& x : m.values) x = std::ldexp(x, -e);
  scale += e;
}

template <typename Loop>
LiftedSystem measure(Loop loop, const core::Scene& scene, const core::NetworkModel& network,
                     double amplitude) {
  const core::PacketSlots& slots = loop.packet_slots();
  if (slots.packets > kMostPacketsLifted)
    throw std::domain_error(
        "rates.local_hz / rates.packet_hz: the packet ticks repeat only after " +
        std::to_string(slots.packets) + " packets (at most " + std::to_string(kMostPacketsLifted) +
        " are lifted); choose rates with a simpler ratio");
  for (int i = 0; i < 64; ++i) loop.advance_packet_period();
  const Loop start = loop;
  const std::vector<double> reference = values_of(loop);

  LiftedSystem system;
  system.packets = static_cast<int>(slots.packets);
  system.period = static_cast<double>(slots.ticks) * scene.tick();
  const bool repeats = std::all_of(network.phase_ticks.begin(), network.phase_ticks.end(),
                                   [](int phase) { return phase == 0; }) &&
                       network.packet_timer == core::PacketTimer::kForceLoop;

  constexpr int kComponents = core::kComponents<typename Loop::Vector>;
  for (int u = 0, index = 0; u < loop.user_count(); ++u)
    for (int f = 0; f < loop.hands().count(u); ++f, index += 2 * kComponents)
      for (int c = 0; c < kComponents; ++c)
        system.ports.push_back({scene.users[u].name + "." + scene.users[u].fingers[f].name,
                                {},
                                index + c,
                                index + kComponents + c});

  std::map<std::vector<std::int64_t>, int> known;
  for (int k = 0; k < system.packets; ++k, loop.advance_packet_period()) {
    const std::vector<std::int64_t> pattern = pattern_of(loop);
    const auto found = repeats ? known.find(pattern) : known.end();
    int which = found == known.end() ? static_cast<int>(system.periods.size()) : found->second;
    if (found == known.end()) {
      PeriodProbe<Loop> probe(loop, amplitude);
      PacketPeriod period{probe.map(), {}, static_cast<int>(pattern.front())};
      for (int u = 0; u < loop.user_count(); ++u)
        for (int f = 0; f < loop.hands().count(u); ++f)
          for (int c = 0; c < kComponents; ++c) period.push.push_back(probe.push(u, f, c));
      if (repeats) known.emplace(pattern, which);
      system.periods.push_back(std::move(period));
    }
    const PacketPeriod& period = system.periods[which];
    for (std::size_t p = 0; p < system.ports.size(); ++p) {
      std::vector<double>& push = system.ports[p].push;
      if (k > 0) push = multiply(period.map, push);
      push.resize(static_cast<std::size_t>(period.map.rows), 0.0);
      for (std::size_t i = 0; i < push.size(); ++i)
        push[i] += std::ldexp(period.push[p][i], -static_cast<int>(system.scale));
    }
    system.transition = k == 0 ? period.map : product(period.map, system.transition);
    if (system.packets > 1) {
      const double before = system.scale;
      shrink(system.transition, system.scale);
      for (ForcePort& port : system.ports)
        for (double& x : port.push) x = std::ldexp(x, static_cast<int>(before - system.scale));
    }
    if (system.packets > 1 && system.packets <= kMostPeriodsKept) system.order.push_back(which);
  }
  if (system.order.empty()) system.periods.clear();

  Loop at_rest = start;
  const auto entries = states_of(at_rest);
  for (const StateEntry& e : entries)
    system.velocities.push_back(e.kind == StateKind::kVelocity ? 1.0 : 0.0);
  if (amplitude == 1.0) {
    system.symmetries = candidate_symmetries(entries, reference);
  } else {
    system.symmetries = kept_symmetries(start, reference, amplitude);
    system.tolerance = 1e-4;  // found by a finite difference
  }
  return system;
}

}  // namespace

LiftedSystem measured_system(const core::Scene& scene, const core::NetworkModel& network) {
  LiftedSystem system;
  switch (scene.space) {
    case core::Space::kAxis:
      system = with_loop_of<core::AxisWorld>(
          scene, network, [&](auto& loop) { return measure(loop, scene, network, 1.0); });
      break;
    case core::Space::kPlane:
      system = with_loop_of<core::PlaneWorld>(
          scene, network, [&](auto& loop) { return measure(loop, scene, network, 1e-6); });
      break;
    case core::Space::kSpace:
      throw std::domain_error("field space: SPACE has no linear analysis; AXIS and PLANE have");
  }
  system.grounded = has_spring_to_ground(scene);
  return system;
}

}  // namespace tandem::analysis
