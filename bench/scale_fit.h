#pragma once

#include <limits>
#include <vector>

namespace tandem::bench {

struct ScalePoint {
  double n = 0.0;  ///< users or objects, > 0
  double y = 0.0;  ///< what grows, > 0
};

/// y = factor n^exponent.
struct PowerLaw {
  double exponent = std::numeric_limits<double>::quiet_NaN();
  double factor = std::numeric_limits<double>::quiet_NaN();
  double spread = 0.0;  ///< largest |y / law - 1| of the points it was fitted to
  int points = 0;
};

/// Least squares of log y over log n, over the points with n >= `from`: the first ones are ruled by
/// what does not grow. NaN with fewer than two different n.
[[nodiscard]] PowerLaw fit_power_law(const std::vector<ScalePoint>& points, double from = 0.0);

/// Where something grows beyond what there is.
struct Knee {
  double n = std::numeric_limits<double>::infinity();
  bool measured = false;  ///< between two points that were measured; else by the law beyond them
};

/// The n at which y reaches `budget`: on the line through the logarithms of the two points around
/// it, or, if no point reaches it, from the law. Points with rising n. Infinite: never, or more
/// than a hundred times beyond the last point.
[[nodiscard]] Knee find_knee(const std::vector<ScalePoint>& points, const PowerLaw& law,
                             double budget);

}  // namespace tandem::bench
