#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "analysis/two_sites.h"
#include "core/network_model.h"
#include "core/scene.h"

/// Where a scene is stable, as a function of its numbers. Regions need be neither convex nor
/// connected, so nothing here is found by a bisection alone.
namespace tandem::analysis {

/// Sets one or several numbers of a scene alike: "coupler.k12.stiffness,coupler.k21.stiffness".
/// Fields: coupler.NAME.stiffness|damping and, in a plane, their normal., tangential. and rotation.
/// kinds (normal. and linear. are the first), object.NAME.mass|inertia|compensation|
/// compensation_rotation, user.NAME.mass, wall.NAME.stiffness|damping. coupler.*.stiffness|damping
/// is a factor on all of them, in every direction.
class Knob {
 public:
  /// Throws std::invalid_argument naming the field and what there is.
  Knob(const core::Scene& scene, const std::string& fields);
  void set(core::Scene& scene, double value) const {
    for (const Place& place : places_) *place.at(scene) = value * place.unit;
  }
  [[nodiscard]] double value(core::Scene& scene) const {
    return *places_.front().at(scene) / places_.front().unit;
  }
  [[nodiscard]] const std::string& name() const { return name_; }

 private:
  struct Place {
    std::function<double*(core::Scene&)> at;
    double unit = 1.0;
  };
  void add_coupler(const core::Scene& scene, const std::string& field, const std::string& name,
                   const std::string& what);
  std::string name_;
  std::vector<Place> places_;
};

/// Judges edits of one scene: by the Routh test where the scene has its form, else by eigenvalues
/// of the resampled map, else of the measured one. Copies may work side by side.
class StabilityJudge {
 public:
  StabilityJudge(const core::Scene& scene, const core::NetworkModel& network);

  /// Positive: stable. Smooth near zero. Its sign is checked by eigenvalues where it is close.
  [[nodiscard]] double margin(const core::Scene& scene);
  /// Deflated spectral radius over a packet period, by eigenvalues.
  [[nodiscard]] double radius(const core::Scene& scene);
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

struct StabilityMap {
  std::vector<std::uint8_t> stable;  ///< x + count_x * y
  std::int64_t count = 0;
  double least_distance = 0.0;  ///< smallest |rho - 1| looked at; only with `radii`
  int rows_apart = 0;           ///< rows (constant x, along y) with more than one interval
  int columns_apart = 0;        ///< the other way
};

/// `progress(done, all)` after each row; returning false stops the map (std::runtime_error).
[[nodiscard]] StabilityMap stability_map(const StabilityJudge& judge, const core::Scene& scene,
                                         const Knob& x, const Axis& across, const Knob& y,
                                         const Axis& up, int threads = 1,
                                         const std::function<bool(int, int)>& progress = {});

/// A piece of the boundary between stable and unstable, both ends exact.
struct Segment {
  double x0, y0, x1, y1;
};

/// The boundary in [x.from, x.to] x [y.from, y.to] as segments whose ends are on it to `tolerance`
/// relative. Squares are refined only where the boundary is or may be: the cost follows the
/// boundary. A range from zero is followed from a ten-thousandth of its end. `across.count`,
/// `up.count`: squares of the coarse grid; each is halved `levels` times.
[[nodiscard]] std::vector<Segment> stability_boundary(StabilityJudge& judge, core::Scene scene,
                                                      const Knob& x, const Axis& across,
                                                      const Knob& y, const Axis& up, int levels = 1,
                                                      double tolerance = 1e-6);

}  // namespace tandem::analysis
