#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "harness/measures.h"
#include "harness/point_result.h"
#include "harness/sweep.h"

/// Sessions of a sweep in virtual time: the same scenes and conditions as on real sockets, closed
/// over modelled links and hands. Same sweep, seed and revision: the same bits.
namespace tandem::harness {

/// A session from its start, tick by tick. Only as long as it is finite.
[[nodiscard]] Trajectory run_virtual(const core::Scene& scene, const core::NetworkModel& network,
                                     double seconds);

/// A `kicked` session judged on the way, without keeping it.
[[nodiscard]] Stability run_stability(const core::Scene& kicked_scene,
                                      const core::NetworkModel& network, double seconds);

/// The largest stable coupling (k_o or k_2) by search, as Prediction::largest_coupling defines it:
/// by a quarter at a time, then bisected to 1 %. `ran` adds up the virtual seconds.
[[nodiscard]] double search_largest_coupling(const core::Scene& scene,
                                             const core::NetworkModel& network, double seconds,
                                             double* ran = nullptr);

/// The scene as the ideal that force errors are taken from: a packet every tick that takes no time,
/// held, nothing compensated.
[[nodiscard]] core::Scene ideal_twin(core::Scene scene);

/// Smallest one-way delay, the same both ways, in whole ticks, with which a kicked session is not
/// stable [s]; infinite if it is up to `longest`; 0: never stable.
[[nodiscard]] double search_delay_boundary(const core::Scene& scene, double longest,
                                           double seconds);

struct VirtualOptions {
  std::uint64_t seed = 1;
  double seconds = 20.0;  ///< of each run for stability [s]
  bool search = true;     ///< largest stable coupling, by search and by analysis
  int threads = 0;        ///< 0: one a core
};

/// All measures of one point, and the prediction.
[[nodiscard]] PointResult run_virtual_point(const SweepPoint& point, const VirtualOptions& options);

/// The whole sweep, in order. `progress(done, all)` after each point, from any thread, one at a
/// time; false stops: std::runtime_error.
[[nodiscard]] std::vector<PointResult> run_virtual_sweep(
    const Sweep& sweep, const VirtualOptions& options,
    const std::function<bool(int, int)>& progress = {});

}  // namespace tandem::harness
