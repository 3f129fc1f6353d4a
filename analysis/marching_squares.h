#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "analysis/roots.h"
#include "analysis/stability.h"

/// Parts of the search for a boundary (boundary.h): the margin over a plane, and the squares of a
/// grid that the boundary passes through.
namespace tandem::analysis::detail {

inline constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

/// The margin over the plane of two knobs. Copies may work side by side.
class Plane {
 public:
  Plane(const StabilityJudge& judge, const core::Scene& scene, const Knob& x, const Knob& y)
      : judge_(judge), scene_(scene), x_(&x), y_(&y) {}

  /// The margin, right in its sign, with what may be zero at the boundary.
  SitesMargin full(double x, double y) {
    SitesMargin m = rough(x, y);
    if (std::abs(m.margin) <= 1e-9) m.margin = judge_.margin(scene_);
    return m;
  }
  double at(double x, double y) { return full(x, y).margin; }
  /// For what is followed down to zero: where only rounding decides a sign, that does no harm.
  SitesMargin rough(double x, double y) {
    ++evaluations_;
    x_->set(scene_, x);
    y_->set(scene_, y);
    return judge_.rough_margin(scene_);
  }
  /// Evaluations since the last call.
  double counted() { return static_cast<double>(std::exchange(evaluations_, 0)); }

 private:
  StabilityJudge judge_;
  core::Scene scene_;
  const Knob* x_;
  const Knob* y_;
  std::int64_t evaluations_ = 0;
};

/// Points of a lattice over the plane: (nx + 1) x (ny + 1).
struct Lattice {
  Axis across, up;
  int nx, ny;
  [[nodiscard]] double x(int i) const { return across.from + i * (across.to - across.from) / nx; }
  [[nodiscard]] double y(int j) const { return up.from + j * (up.to - up.from) / ny; }
};

/// Marching over the squares [i0, i1) x [j0, j1) of a lattice: margins at corners and zeros on
/// edges are found once each.
class Squares {
 public:
  Squares(Plane& plane, const Lattice& lattice, int i0, int i1, int j0, int j1, double tolerance)
      : plane_(plane),
        lattice_(lattice),
        i0_(i0),
        j0_(j0),
        width_(i1 - i0 + 1),
        tolerance_(tolerance),
        corners_(static_cast<std::size_t>(width_) * (j1 - j0 + 1), SitesMargin{kUnknown, {}}),
        along_x_(corners_.size(), kUnknown),
        along_y_(corners_.size(), kUnknown) {}

  void give(int i, int j, const SitesMargin& margin) { corners_[index(i, j)] = margin; }
  const SitesMargin& full(int i, int j) {
    SitesMargin& m = corners_[index(i, j)];
    if (std::isnan(m.margin)) m = plane_.full(lattice_.x(i), lattice_.y(j));
    return m;
  }
  double corner(int i, int j) { return full(i, j).margin; }
  [[nodiscard]] bool known(int i, int j) const { return !std::isnan(corners_[index(i, j)].margin); }

  /// Whether the boundary passes between the corners of the square of `size`.
  bool crossed(int i, int j, int size) {
    const bool first = corner(i, j) > 0.0;
    return (corner(i + size, j) > 0.0) != first || (corner(i + size, j + size) > 0.0) != first ||
           (corner(i, j + size) > 0.0) != first;
  }

  /// Appends x0 y0 x1 y1 of the boundary's pieces in the unit square at (i, j).
  void pieces(int i, int j, SweepRow& out) {
    const double f[4] = {corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)};
    double x[4], y[4];
    int found = 0;
    const auto take = [&](bool horizontal, int ei, int ej) {
      x[found] = horizontal ? on_edge(true, ei, ej) : lattice_.x(ei);
      y[found++] = horizontal ? lattice_.y(ej) : on_edge(false, ei, ej);
    };
    if ((f[0] > 0.0) != (f[1] > 0.0)) take(true, i, j);
    if ((f[1] > 0.0) != (f[2] > 0.0)) take(false, i + 1, j);
    if ((f[2] > 0.0) != (f[3] > 0.0)) take(true, i, j + 1);
    if ((f[3] > 0.0) != (f[0] > 0.0)) take(false, i, j);
    for (int p = 0; p + 1 < found; p += 2) out.insert(out.end(), {x[p], y[p], x[p + 1], y[p + 1]});
  }

 private:
  [[nodiscard]] std::size_t index(int i, int j) const {
    return static_cast<std::size_t>(j - j0_) * width_ + (i - i0_);
  }

  /// Where the margin is zero on the edge from (i, j) to the right or up. Depends on the edge only,
  /// so that squares on both sides of it, done by whomever, have the same bits.
  double on_edge(bool horizontal, int i, int j) {
    double& zero = (horizontal ? along_x_ : along_y_)[index(i, j)];
    if (!std::isnan(zero)) return zero;
    const double x0 = lattice_.x(i), y0 = lattice_.y(j);
    const double a = horizontal ? x0 : y0;
    const double b = horizontal ? lattice_.x(i + 1) : lattice_.y(j + 1);
    const auto at = [&](double v) {
      return horizontal ? plane_.rough(v, y0) : plane_.rough(x0, v);
    };
    // The margin is the least of several functions. The one that is zero at the boundary is
    // negative outside; it alone is smooth from end to end.
    const SitesMargin first = full(i, j), last = horizontal ? full(i + 1, j) : full(i, j + 1);
    const auto& outside = (first.margin > 0.0 ? last : first).critical;
    const auto which = static_cast<std::size_t>(
        std::find_if(outside.begin(), outside.end() - 1, [](double f) { return f < 0.0; }) -
        outside.begin());
    const auto follow = [&](const SitesMargin& m) {
      const double f = m.critical[which];
      return m.margin > 0.0 ? std::max(f, 1e-300) : f < 0.0 ? f : m.margin;
    };
    const double fa = follow(first), fb = follow(last);
    if ((fa > 0.0) == (fb > 0.0))  // rounding decides at one end: the boundary is there
      zero = std::abs(fa) < std::abs(fb) ? a : b;
    else
      zero = zero_between([&](double v) { return follow(at(v)); }, a, fa, b, fb, tolerance_);
    return zero;
  }

  Plane& plane_;
  const Lattice& lattice_;
  int i0_, j0_, width_;
  double tolerance_;
  std::vector<SitesMargin> corners_;
  std::vector<double> along_x_, along_y_;
};

}  // namespace tandem::analysis::detail
