#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "analysis/knob.h"
#include "analysis/sweep.h"
#include "analysis/two_sites.h"
#include "core/network_model.h"
#include "core/scene.h"

/// Where a scene is stable, as a function of its numbers. Regions need be neither convex nor
/// connected, so nothing here is found by a bisection alone.
namespace tandem::analysis {

/// Judges edits of one scene: by the Routh test where the scene has its form, else by eigenvalues
/// of the resampled map, else of the measured one. Copies may work side by side.
class StabilityJudge {
 public:
  StabilityJudge(const core::Scene& scene, const core::NetworkModel& network);

  /// Positive: stable. Smooth near zero. Its sign is checked by eigenvalues where it is close.
  [[nodiscard]] double margin(const core::Scene& scene);
  /// The same without that check, right to rounding, and what may be zero at the boundary.
  [[nodiscard]] SitesMargin rough_margin(const core::Scene& scene);
  /// Deflated spectral radius over a packet period, by eigenvalues.
  [[nodiscard]] double radius(const core::Scene& scene);
  /// The same of the map measured on the running loop, the judge of last resort.
  [[nodiscard]] double radius_on_the_loop(const core::Scene& scene) const;
  /// How margin() judges: "routh", "resampled", "measured".
  [[nodiscard]] const char* road() const;
  [[nodiscard]] std::int64_t evaluations() const { return evaluations_; }

 private:
  core::NetworkModel network_;
  std::optional<TwoSites> two_sites_;
  bool resampled_ = false;
  std::int64_t evaluations_ = 0;
};

struct Interval {
  double low = 0.0, high = 0.0;
};

struct IntervalOptions {
  int samples = 600;         ///< of the scan, half evenly and half geometrically spaced
  double tolerance = 1e-12;  ///< of an end, relative
};

/// The stable intervals of one knob within [from, to]: a scan, every sign change bracketed, the
/// maxima that stay below zero and minima above refined until they cross or are found not to, each
/// end by a bracketed secant. Ends at `from` or `to` mean: stable up to the end of the scan.
/// An interval narrower than the scan's spacing whose margin is not near a maximum can be missed.
[[nodiscard]] std::vector<Interval> stable_intervals(StabilityJudge& judge, core::Scene scene,
                                                     const Knob& knob, double from, double to,
                                                     const IntervalOptions& options = {});

/// `count` equal cells of [from, to], judged at their centres.
struct Axis {
  double from = 0.0, to = 1.0;
  int count = 100;
  [[nodiscard]] double centre(int i) const { return from + (i + 0.5) * (to - from) / count; }
};

/// What judging some points again on the running loop gave.
struct LoopCheck {
  std::int64_t points = 0;
  std::int64_t differ = 0;          ///< verdicts that differ where |rho - 1| >= 1e-9
  double largest_difference = 0.0;  ///< of the two spectral radii, relative where above one

  void add(double road, double loop, bool said_stable);
};

struct StabilityMap {
  std::vector<std::uint8_t> stable;  ///< x + count_x * y
  std::int64_t count = 0;
  int rows_apart = 0;     ///< rows (constant x, along y) with more than one interval
  int columns_apart = 0;  ///< the other way
  LoopCheck check;
};

/// Every cell judged at its centre. One point in `check_every` is judged again on the running loop;
/// 0: none, nor where the map is measured there anyway. Stage "map" of the runner.
[[nodiscard]] StabilityMap stability_map(const StabilityJudge& judge, const core::Scene& scene,
                                         const Knob& x, const Axis& across, const Knob& y,
                                         const Axis& up, SweepRunner& runner, int check_every = 0);
/// The same on this thread, unchecked.
[[nodiscard]] StabilityMap stability_map(const StabilityJudge& judge, const core::Scene& scene,
                                         const Knob& x, const Axis& across, const Knob& y,
                                         const Axis& up);
/// Bytes such a map takes.
[[nodiscard]] std::size_t map_memory(const Axis& across, const Axis& up);

}  // namespace tandem::analysis
