#pragma once

#include <vector>

#include "analysis/stability.h"

namespace tandem::analysis {

/// A piece of the boundary between stable and unstable, both ends exact.
struct Segment {
  double x0, y0, x1, y1;
};

struct BoundaryOptions {
  int levels = 1;           ///< how often a square of the coarse grid is halved at the boundary
  double tolerance = 1e-6;  ///< of a segment's ends, relative
};

struct Boundary {
  std::vector<Segment> segments;
  std::int64_t evaluations = 0;
  /// Places that the coarse grid alone would have missed: found from extrema between its points.
  int found_between = 0;
};

/// The boundary in [x.from, x.to] x [y.from, y.to] as segments whose ends are on it. Squares are
/// refined only where the boundary passes: the cost follows the boundary. `across.count`,
/// `up.count`: squares of the coarse grid. A range from zero is followed from a ten-thousandth of
/// its end.
///
/// What lies between grid points is looked for where the margin has an extremum along a line of the
/// grid, or over the plane, that may reach the other side: it is climbed, and if it crosses, the
/// squares there are cut finely. An island smaller than a square that does not show in the margin
/// of the grid points round it can be missed.
///
/// Bits do not depend on the runner. Stages "corners", "between", "squares", "narrow places".
[[nodiscard]] Boundary stability_boundary(const StabilityJudge& judge, const core::Scene& scene,
                                          const Knob& x, const Axis& across, const Knob& y,
                                          const Axis& up, SweepRunner& runner,
                                          const BoundaryOptions& options = {});

}  // namespace tandem::analysis
