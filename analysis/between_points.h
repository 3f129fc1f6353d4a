#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <tuple>
#include <vector>

#include "analysis/marching_squares.h"

/// A part of the search for a boundary (boundary.h): what the points of the coarse grid do not
/// show.
namespace tandem::analysis::detail {

/// Margins along a line of the coarse grid, as a row of a sweep.
inline constexpr int kStride =
    1 + static_cast<int>(std::tuple_size_v<decltype(SitesMargin::critical)>);

inline void append(const SitesMargin& m, SweepRow& row) {
  row.push_back(m.margin);
  row.insert(row.end(), m.critical.begin(), m.critical.end());
}
inline SitesMargin margin_in(const SweepRow& row, int i) {
  const auto at = row.begin() + static_cast<std::ptrdiff_t>(i) * kStride;
  SitesMargin m{*at, {}};
  std::copy_n(at + 1, m.critical.size(), m.critical.begin());
  return m;
}

/// From m between a and b, where f is greatest of the three: up until it is positive, or seen not
/// to get there. Returns whether it did; `m` is where it got.
template <typename F>
bool climbs_over_zero(F&& f, double a, double fa, double& m, double fm, double b, double fb) {
  constexpr int kSteps = 16;
  for (int i = 0; i < kSteps; ++i) {
    // What f changes by about its top bounds how much higher the top may be: an eighth of it for a
    // parabola, half of it for an even roof.
    if (-fm > 0.5 * std::max(fm - fa, fm - fb)) return false;
    // The top of the parabola, or into the longer side where it says nothing.
    const double p = (m - a) * (fm - fb), q = (m - b) * (fm - fa);
    double x = p != q ? m - 0.5 * ((m - a) * p - (m - b) * q) / (p - q) : m;
    if (i % 3 == 2 || !(x > a && x < b) || std::abs(x - m) < 1e-3 * (b - a))
      x = m - a > b - m ? m - 0.4 * (m - a) : m + 0.4 * (b - m);
    const double fx = f(x);
    if (fx > fm) {
      (x > m ? a : b) = m;
      (x > m ? fa : fb) = fm;
      m = x, fm = fx;
      if (fm > 0.0) return true;
    } else {
      (x > m ? b : a) = x;
      (x > m ? fb : fa) = fx;
    }
  }
  return false;
}

/// Looks between the points of the coarse grid, where nothing at the points shows a boundary. What
/// may be zero there is smooth, so that its curvature at the points says where it may cross
/// between.
class Between {
 public:
  Between(Plane& plane, const Lattice& grid, const std::vector<SweepRow>& margins)
      : plane_(plane), grid_(grid), margins_(margins) {}

  /// Appends x, y of points on the other side, beside row j: from it to the right and upwards.
  void look(int j, SweepRow& out) {
    for (int i = 0; i <= grid_.nx; ++i) {
      if (i < grid_.nx) look(true, i, j, out);
      if (j < grid_.ny) look(false, i, j, out);
    }
  }

 private:
  static constexpr std::size_t kFunctions = std::tuple_size_v<decltype(SitesMargin::critical)>;

  void look(bool along_x, int i, int j, SweepRow& out) {
    const auto at = [&](int k) {  // k from -1 to 2
      const int ik = along_x ? i + k : i, jk = along_x ? j : j + k;
      return ik < 0 || jk < 0 || ik > grid_.nx || jk > grid_.ny ? SitesMargin{kUnknown, {}}
                                                                : margin_in(margins_[jk], ik);
    };
    const SitesMargin f[4] = {at(-1), at(0), at(1), at(2)};
    const bool inside = f[1].margin > 0.0;
    if ((f[2].margin > 0.0) != inside) return;
    int outside = -1;
    for (std::size_t k = 0; k < kFunctions && !inside; ++k)
      if (f[1].critical[k] < 0.0 || f[2].critical[k] < 0.0) {
        if (outside >= 0) return;  // more than one boundary away
        outside = static_cast<int>(k);
      }
    const double side = inside ? -1.0 : 1.0;
    for (std::size_t k = 0; k < kFunctions; ++k) {
      if (!inside && static_cast<int>(k) != outside) continue;
      // Where the scene has one function only, it stands at every place.
      if (k > 0 && f[1].critical[k] == f[1].critical[0] && f[2].critical[k] == f[2].critical[0])
        continue;
      const auto v = [&](int n) {
        return std::isnan(f[n].margin) ? kUnknown : side * f[n].critical[k];
      };
      const double part = crossing_part(v(0), v(1), v(2), v(3));
      if (part > 0.0 && climb(along_x, i, j, k, side, part, v(1), v(2), out)) return;
    }
  }

  /// Between the second and third of four even values, both negative: where the parabola is
  /// highest, as a part of the way, if that may be over zero with as much curvature again; else 0.
  static double crossing_part(double before, double a, double b, double after) {
    if (!(a < 0.0 && b < 0.0)) return 0.0;
    const double first = before - 2.0 * a + b, second = a - 2.0 * b + after;
    const double curvature = std::fmin(first, second);  // of which one may be unknown
    if (!(curvature < 0.0)) return 0.0;
    const double part = 0.5 - (b - a) / curvature;
    if (!(part > 0.0 && part < 1.0)) return 0.0;
    const double top = a + (b - a) * part + 0.5 * curvature * part * (part - 1.0);
    return top - 0.125 * curvature > 0.0 ? part : 0.0;
  }

  bool climb(bool along_x, int i, int j, std::size_t k, double side, double part, double fa,
             double fb, SweepRow& out) {
    const auto f = [&](double x, double y) {
      const SitesMargin m = plane_.full(x, y);
      const bool over = (m.margin > 0.0) == (side > 0.0);
      const double value = side * m.critical[k];
      return over ? std::max(value, 1e-300) : std::min(value, -1e-300);
    };
    double x = grid_.x(i), y = grid_.y(j);
    const double a = along_x ? x : y;
    const double b = along_x ? grid_.x(i + 1) : grid_.y(j + 1);
    double& moving = along_x ? x : y;
    double& still = along_x ? y : x;
    double at = a + part * (b - a);
    const auto on_line = [&](double v) {
      moving = v;
      return f(x, y);
    };
    const auto found = [&] {
      out.insert(out.end(), {x, y});
      return true;
    };
    double fm = on_line(at);
    if (fm > 0.0) return found();
    if (fm < fa || fm < fb) return false;
    if (climbs_over_zero(on_line, a, fa, at, fm, b, fb)) return found();
    // Along the line it does not get there. From its top across, half a square either way.
    fm = on_line(at);
    const double line = still,
                 half = along_x ? 0.5 * (grid_.y(1) - grid_.y(0)) : 0.5 * (grid_.x(1) - grid_.x(0));
    const auto across = [&](double v) {
      still = v;
      return f(x, y);
    };
    for (const double step : {-half, half}) {
      const double near = across(line + step);
      if (near > 0.0) return found();
      if (near < fm) continue;
      const double far = across(line + 2.0 * step);
      if (far > 0.0) return found();
      if (near < far) continue;
      double top = line + step;
      const bool up = step > 0.0;
      return climbs_over_zero(across, up ? line : line + 2.0 * step, up ? fm : far, top, near,
                              up ? line + 2.0 * step : line, up ? far : fm) &&
             (across(top), found());
    }
    return false;
  }

  Plane& plane_;
  const Lattice& grid_;
  const std::vector<SweepRow>& margins_;
};

}  // namespace tandem::analysis::detail
