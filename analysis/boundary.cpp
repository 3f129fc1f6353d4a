#include "analysis/boundary.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>
#include <utility>

#include "analysis/between_points.h"
#include "analysis/marching_squares.h"

namespace tandem::analysis {

namespace detail {

namespace {

struct Point {
  double x, y;
};

/// The whole: stages one after the other, each over items that do not know of each other.
class Tracer {
 public:
  Tracer(const StabilityJudge& judge, const core::Scene& scene, const Knob& x, const Axis& across,
         const Knob& y, const Axis& up, SweepRunner& runner, const BoundaryOptions& options)
      : plane_(judge, scene, x, y),
        runner_(runner),
        options_(options),
        fine_(1 << options.levels),
        coarse_{across, up, across.count, up.count},
        squares_{across, up, across.count * fine_, up.count * fine_} {}

  Boundary trace() {
    find_corners();
    const std::vector<Point> between = look_between();
    for (const Point& p : between) {
      const double u = (p.x - squares_.x(0)) / (squares_.x(1) - squares_.x(0));
      const double v = (p.y - squares_.y(0)) / (squares_.y(1) - squares_.y(0));
      for (const double du : {-1e-6, 1e-6})  // a point on a line belongs to both sides
        for (const double dv : {-1e-6, 1e-6})
          add_narrow(static_cast<int>(std::floor(u + du)), static_cast<int>(std::floor(v + dv)));
    }
    march();
    follow_narrow();
    for (const auto& [square, segment] : marched_)
      if (narrow_.count(square) == 0) out_.segments.push_back(segment);
    cut_finely();
    out_.found_between = static_cast<int>(between.size());
    return std::move(out_);
  }

 private:
  static constexpr int kCut = 16;  ///< a square with something narrow in it is cut into so many

  void count(SweepRow& row) {
    out_.evaluations += static_cast<std::int64_t>(row.back());
    row.pop_back();
  }
  void take(const SweepRow& row) {
    for (std::size_t k = 0; k + 3 < row.size(); k += 4)
      out_.segments.push_back({row[k], row[k + 1], row[k + 2], row[k + 3]});
  }

  void find_corners() {
    margins_ = runner_.run("corners", coarse_.ny + 1, [&]() -> SweepWork {
      return [&, plane = plane_](std::int64_t j) mutable {
        SweepRow row;
        for (int i = 0; i <= coarse_.nx; ++i)
          append(plane.full(coarse_.x(i), coarse_.y(static_cast<int>(j))), row);
        row.push_back(plane.counted());
        return row;
      };
    });
    for (SweepRow& row : margins_) count(row);
  }

  std::vector<Point> look_between() {
    std::vector<Point> found;
    const auto rows = runner_.run("between", coarse_.ny + 1, [&]() -> SweepWork {
      return [&, plane = plane_](std::int64_t j) mutable {
        SweepRow row;
        Between(plane, coarse_, margins_).look(static_cast<int>(j), row);
        row.push_back(plane.counted());
        return row;
      };
    });
    for (SweepRow row : rows) {
      count(row);
      for (std::size_t k = 0; k + 1 < row.size(); k += 2) found.push_back({row[k], row[k + 1]});
    }
    return found;
  }

  void add_narrow(int i, int j) {
    if (i < 0 || j < 0 || i >= squares_.nx || j >= squares_.ny) return;
    if (narrow_.insert({i, j}).second) waiting_.emplace_back(i, j);
  }

  /// Whether the corners of a square of the coarse grid show the boundary.
  [[nodiscard]] bool shows(int i, int j) const {
    if (i < 0 || j < 0 || i >= coarse_.nx || j >= coarse_.ny) return true;  // nothing to see there
    const auto inside = [&](int a, int b) { return margin_in(margins_[b], a).margin > 0.0; };
    const bool first = inside(i, j);
    return inside(i + 1, j) != first || inside(i + 1, j + 1) != first || inside(i, j + 1) != first;
  }

  /// From squares with something narrow in them to those that it reaches into across an edge and
  /// that do not show it.
  void follow_narrow() {
    while (!waiting_.empty()) {
      const auto [i, j] = waiting_.back();
      waiting_.pop_back();
      const auto follow = [&](bool horizontal, int at_i, int at_j, int to_i, int to_j) {
        const double dx = horizontal ? squares_.x(1) - squares_.x(0) : 0.0;
        const double dy = horizontal ? 0.0 : squares_.y(1) - squares_.y(0);
        int changes = 0;
        bool before = false;
        for (int k = 0; k <= kCut; ++k) {
          const double part = static_cast<double>(k) / kCut;
          const bool now =
              plane_.at(squares_.x(at_i) + part * dx, squares_.y(at_j) + part * dy) > 0.0;
          changes += k > 0 && now != before ? 1 : 0;
          before = now;
        }
        const auto coarse = [&](int n) { return n < 0 ? -1 : n / fine_; };
        if (changes > 1 || (changes == 1 && !shows(coarse(to_i), coarse(to_j))))
          add_narrow(to_i, to_j);
      };
      follow(true, i, j, i, j - 1);
      follow(true, i, j + 1, i, j + 1);
      follow(false, i, j, i - 1, j);
      follow(false, i + 1, j, i + 1, j);
    }
    out_.evaluations += static_cast<std::int64_t>(plane_.counted());
  }

  /// Rows of i, j and the piece in that square; with nothing but i, j where a square that shows
  /// nothing has the boundary on its rim.
  void march() {
    const auto rows = runner_.run("squares", coarse_.ny, [&]() -> SweepWork {
      return [&, plane = plane_](std::int64_t item) mutable {
        const int band = static_cast<int>(item), j0 = band * fine_;
        Squares squares(plane, squares_, 0, squares_.nx, j0, j0 + fine_, options_.tolerance);
        for (int i = 0; i <= coarse_.nx; ++i) {
          squares.give(i * fine_, j0, margin_in(margins_[band], i));
          squares.give(i * fine_, j0 + fine_, margin_in(margins_[band + 1], i));
        }
        SweepRow row;
        for (int i = 0; i < coarse_.nx; ++i) {
          if (!shows(i, band)) continue;
          refine(squares, i * fine_, j0, fine_, row);
          look_at_rim(squares, i, band, row);
        }
        row.push_back(plane.counted());
        return row;
      };
    });
    for (SweepRow row : rows) {
      count(row);
      for (std::size_t k = 0; k + 5 < row.size(); k += 6) {
        const std::pair square{static_cast<int>(row[k]), static_cast<int>(row[k + 1])};
        if (std::isnan(row[k + 2]))
          add_narrow(square.first, square.second);
        else
          marched_.emplace_back(square, Segment{row[k + 2], row[k + 3], row[k + 4], row[k + 5]});
      }
    }
  }

  void refine(Squares& squares, int i, int j, int size, SweepRow& row) {
    if (!squares.crossed(i, j, size)) return;
    if (size == 1) {
      SweepRow pieces;
      squares.pieces(i, j, pieces);
      for (std::size_t k = 0; k + 3 < pieces.size(); k += 4)
        row.insert(row.end(),
                   {1.0 * i, 1.0 * j, pieces[k], pieces[k + 1], pieces[k + 2], pieces[k + 3]});
      return;
    }
    const int h = size / 2;
    for (const auto& [di, dj] : {std::pair{0, 0}, {h, 0}, {0, h}, {h, h}})
      refine(squares, i + di, j + dj, h, row);
  }

  /// What this coarse square has found on its sides, and the one beside it does not show.
  void look_at_rim(Squares& squares, int i, int j, SweepRow& row) const {
    const auto side = [&](int at_i, int at_j, bool horizontal, int to_i, int to_j) {
      if (shows(to_i, to_j)) return;
      const bool all = squares.corner(at_i, at_j) > 0.0;
      for (int k = 1; k < fine_; ++k) {
        const int ci = at_i + (horizontal ? k : 0), cj = at_j + (horizontal ? 0 : k);
        if (!squares.known(ci, cj) || (squares.corner(ci, cj) > 0.0) == all) continue;
        for (const int back : {1, 0}) {
          const int ni = horizontal ? ci - back : to_i > i ? ci : ci - 1;
          const int nj = horizontal ? (to_j > j ? cj : cj - 1) : cj - back;
          row.insert(row.end(), {1.0 * ni, 1.0 * nj, kUnknown, 0.0, 0.0, 0.0});
        }
      }
    };
    const int ci = i * fine_, cj = j * fine_;
    side(ci, cj, true, i, j - 1);
    side(ci, cj + fine_, true, i, j + 1);
    side(ci, cj, false, i - 1, j);
    side(ci + fine_, cj, false, i + 1, j);
  }

  void cut_finely() {
    if (narrow_.empty()) return;
    const std::vector<std::pair<int, int>> all(narrow_.begin(), narrow_.end());
    const Lattice lattice{squares_.across, squares_.up, squares_.nx * kCut, squares_.ny * kCut};
    const auto rows =
        runner_.run("narrow places", static_cast<std::int64_t>(all.size()), [&]() -> SweepWork {
          return [&, plane = plane_](std::int64_t item) mutable {
            const auto [i, j] = all[static_cast<std::size_t>(item)];
            const int i0 = i * kCut, j0 = j * kCut;
            Squares squares(plane, lattice, i0, i0 + kCut, j0, j0 + kCut, options_.tolerance);
            SweepRow row;
            for (int b = j0; b < j0 + kCut; ++b)
              for (int a = i0; a < i0 + kCut; ++a)
                if (squares.crossed(a, b, 1)) squares.pieces(a, b, row);
            row.push_back(plane.counted());
            return row;
          };
        });
    for (SweepRow row : rows) {
      count(row);
      take(row);
    }
  }

  Plane plane_;
  SweepRunner& runner_;
  BoundaryOptions options_;
  int fine_;
  Lattice coarse_, squares_;
  std::vector<SweepRow> margins_;
  std::vector<std::pair<std::pair<int, int>, Segment>> marched_;
  std::set<std::pair<int, int>> narrow_;      ///< squares that are cut finely
  std::vector<std::pair<int, int>> waiting_;  ///< those of them not yet followed
  Boundary out_;
};

}  // namespace

}  // namespace detail

Boundary stability_boundary(const StabilityJudge& judge, const core::Scene& scene, const Knob& x,
                            const Axis& across, const Knob& y, const Axis& up, SweepRunner& runner,
                            const BoundaryOptions& options) {
  Axis a = across, b = up;
  for (const auto& [axis, knob] : {std::pair{&a, &x}, std::pair{&b, &y}}) {
    if (!(axis->from < axis->to) || !std::isfinite(axis->from) || !std::isfinite(axis->to))
      throw std::invalid_argument(knob->name() + ": the range must go up");
    if (axis->count < 1 || axis->count > 10000)
      throw std::invalid_argument(knob->name() + ": 1 to 10000 squares");
    // With a gain of zero a spring is gone and the scene marginal: no boundary worth following.
    if (axis->from == 0.0) axis->from = 1e-4 * axis->to;
  }
  if (options.levels < 0 || options.levels > 10) throw std::invalid_argument("levels: 0 to 10");
  return detail::Tracer(judge, scene, x, a, y, b, runner, options).trace();
}

}  // namespace tandem::analysis
