#include "analysis/stability.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "analysis/lifted.h"
#include "analysis/resampled.h"
#include "analysis/roots.h"

namespace tandem::analysis {

StabilityJudge::StabilityJudge(const core::Scene& scene, const core::NetworkModel& network)
    : network_(network),
      two_sites_(TwoSites::of(scene, network)),
      resampled_(why_not_resampled(scene, network).empty()) {}

double StabilityJudge::margin(const core::Scene& scene) {
  ++evaluations_;
  if (two_sites_) {
    const double m = two_sites_->margin(scene).margin;
    if (std::abs(m) > 1e-9) return m;
  }
  const double rho = radius(scene);
  return rho < 1e300 ? 1.0 - rho : -1e300;
}

SitesMargin StabilityJudge::rough_margin(const core::Scene& scene) {
  if (!two_sites_) {
    const double m = margin(scene);
    return {m, {m, m, m, m, m, m}};
  }
  ++evaluations_;
  return two_sites_->margin(scene);
}

double StabilityJudge::radius(const core::Scene& scene) {
  return judge(resampled_ ? resampled_system(scene, network_) : measured_system(scene, network_))
      .radius;
}

double StabilityJudge::radius_on_the_loop(const core::Scene& scene) const {
  return judge(measured_system(scene, network_)).radius;
}

const char* StabilityJudge::road() const {
  return two_sites_ ? "routh" : resampled_ ? "resampled" : "measured";
}

std::vector<Interval> stable_intervals(StabilityJudge& judge, core::Scene scene, const Knob& knob,
                                       double from, double to, const IntervalOptions& options) {
  if (!(from < to) || !std::isfinite(from) || !std::isfinite(to))
    throw std::invalid_argument(knob.name() + ": the range must go up");
  const auto f = [&](double x) {
    knob.set(scene, x);
    return judge.margin(scene);
  };
  const auto exact = [&](double x) {
    knob.set(scene, x);
    return 1.0 - judge.radius(scene);
  };
  std::vector<double> x;
  const int half = std::max(options.samples / 2, 2);
  for (int i = 0; i <= half; ++i) x.push_back(from + (to - from) * i / half);
  const double low = from > 0.0 ? from : 1e-6 * to;
  for (int i = 1; low > 0.0 && i < half; ++i)
    x.push_back(low * std::pow(to / low, static_cast<double>(i) / half));
  std::sort(x.begin(), x.end());
  x.erase(std::unique(x.begin(), x.end()), x.end());

  std::vector<std::pair<double, double>> scan;
  for (const double at : x) scan.emplace_back(at, f(at));
  // What comes near zero between two of the same sign may cross it twice.
  std::vector<std::pair<double, double>> extra;
  for (std::size_t i = 0; i < scan.size(); ++i) {
    const double here = scan[i].second, side = here > 0.0 ? -1.0 : 1.0;
    const auto& before = scan[i == 0 ? 0 : i - 1];
    const auto& after = scan[std::min(i + 1, scan.size() - 1)];
    if (std::abs(here) > 0.2 || side * before.second > side * here ||
        side * after.second > side * here || (before.second > 0.0) != (here > 0.0) ||
        (after.second > 0.0) != (here > 0.0))
      continue;
    const auto top = climb([&](double at) { return side * f(at); }, before.first, after.first);
    if (top.second > 0.0) extra.emplace_back(top.first, side * top.second);
  }
  scan.insert(scan.end(), extra.begin(), extra.end());
  std::sort(scan.begin(), scan.end());

  const auto end_between = [&](const auto& p, const auto& q) {
    const auto rough = bracket_zero(f, p.first, p.second, q.first, q.second, 1e-9);
    // The last digits by eigenvalues, from a bracket a little wider.
    double a = std::min(rough.first, rough.second), b = std::max(rough.first, rough.second);
    const double room = 1e-8 * b;
    a = std::max(a - room, p.first);
    b = std::min(b + room, q.first);
    const double fa = exact(a), fb = exact(b);
    if ((fa > 0.0) == (fb > 0.0)) return 0.5 * (rough.first + rough.second);
    const auto fine = bracket_zero(exact, a, fa, b, fb, options.tolerance);
    return 0.5 * (fine.first + fine.second);
  };
  std::vector<Interval> out;
  for (std::size_t i = 0; i < scan.size(); ++i) {
    const bool stable = scan[i].second > 0.0;
    const bool was = i > 0 && scan[i - 1].second > 0.0;
    if (stable && !was) out.push_back({i == 0 ? from : end_between(scan[i - 1], scan[i]), to});
    if (!stable && was) out.back().high = end_between(scan[i - 1], scan[i]);
  }
  return out;
}

namespace {

void check_axes(const Knob& x, const Axis& across, const Knob& y, const Axis& up) {
  for (const auto& [axis, knob] : {std::pair{&across, &x}, std::pair{&up, &y}}) {
    if (!(axis->from < axis->to) || !std::isfinite(axis->from) || !std::isfinite(axis->to))
      throw std::invalid_argument(knob->name() + ": the range must go up");
    if (axis->count < 1 || axis->count > 1000000)
      throw std::invalid_argument(knob->name() + ": 1 to 1000000 cells");
  }
}

/// Cells an item of a map has: so many that it takes some tenths of a second at most.
int cells_per_item(const StabilityJudge& judge) {
  switch (judge.road()[0]) {
    case 'r':
      return judge.road()[1] == 'o' ? 20000 : 500;  // routh, resampled
    default:
      return 20;
  }
}

/// What of a row comes first; then the state of its first cell, then where it changes.
enum RowEntry { kChecked, kDiffer, kLargest, kFirst, kChanges };

}  // namespace

void LoopCheck::add(double road, double loop, bool said_stable) {
  ++points;
  const bool finite = std::isfinite(road) && std::isfinite(loop);
  if (finite)
    largest_difference = std::max(largest_difference, std::abs(road - loop) / std::max(1.0, loop));
  // So close to the boundary rounding decides, and either verdict is right.
  constexpr double kUndecided = 1e-9;
  if (said_stable != (loop < 1.0) && !(finite && std::abs(loop - 1.0) < kUndecided)) ++differ;
}

std::size_t map_memory(const Axis& across, const Axis& up) {
  return static_cast<std::size_t>(across.count) * static_cast<std::size_t>(up.count);
}

StabilityMap stability_map(const StabilityJudge& judge, const core::Scene& scene, const Knob& x,
                           const Axis& across, const Knob& y, const Axis& up, SweepRunner& runner,
                           int check_every) {
  check_axes(x, across, y, up);
  const int most = cells_per_item(judge);
  const std::int64_t per_row = (across.count + most - 1) / most;
  const bool checks = check_every > 0 && judge.road()[0] != 'm';
  const auto make_work = [&]() -> SweepWork {
    return [&, own = judge, edited = scene](std::int64_t item) mutable {
      const int j = static_cast<int>(item / per_row);
      const int first = static_cast<int>(item % per_row) * most;
      const int last = std::min(first + most, across.count);
      SweepRow row(kChanges, 0.0);
      LoopCheck check;
      y.set(edited, up.centre(j));
      bool was = false;
      for (int i = first; i < last; ++i) {
        x.set(edited, across.centre(i));
        const bool stable = own.margin(edited) > 0.0;
        if (i == first)
          row[kFirst] = stable ? 1.0 : 0.0;
        else if (stable != was)
          row.push_back(i);
        was = stable;
        // A lattice: one point in so many of every row, spread over the columns.
        if (checks && (i + 37LL * j) % check_every == 0)
          check.add(own.radius(edited), own.radius_on_the_loop(edited), stable);
      }
      row[kChecked] = static_cast<double>(check.points);
      row[kDiffer] = static_cast<double>(check.differ);
      row[kLargest] = check.largest_difference;
      return row;
    };
  };
  const std::vector<SweepRow> rows = runner.run("map", per_row * up.count, make_work);

  StabilityMap map;
  map.stable.assign(map_memory(across, up), 0);
  for (std::size_t item = 0; item < rows.size(); ++item) {
    const SweepRow& row = rows[item];
    map.check.points += static_cast<std::int64_t>(row.at(kChecked));
    map.check.differ += static_cast<std::int64_t>(row.at(kDiffer));
    map.check.largest_difference = std::max(map.check.largest_difference, row.at(kLargest));
    const auto j = static_cast<std::int64_t>(item) / per_row;
    const int first = static_cast<int>(static_cast<std::int64_t>(item) % per_row) * most;
    const int last = std::min(first + most, across.count);
    bool stable = row.at(kFirst) != 0.0;
    std::size_t change = kChanges;
    for (int i = first; i < last; ++i) {
      if (change < row.size() && row[change] == i) stable = !stable, ++change;
      map.stable[static_cast<std::size_t>(j) * across.count + i] = stable ? 1 : 0;
    }
  }
  const auto at = [&](int i, int j) {
    return map.stable[static_cast<std::size_t>(j) * across.count + i];
  };
  for (int i = 0; i < across.count; ++i) {
    int starts = 0;
    for (int j = 0; j < up.count; ++j) {
      map.count += at(i, j);
      starts += at(i, j) && (j == 0 || !at(i, j - 1)) ? 1 : 0;
    }
    map.rows_apart += starts > 1 ? 1 : 0;
  }
  for (int j = 0; j < up.count; ++j) {
    int starts = 0;
    for (int i = 0; i < across.count; ++i) starts += at(i, j) && (i == 0 || !at(i - 1, j)) ? 1 : 0;
    map.columns_apart += starts > 1 ? 1 : 0;
  }
  return map;
}

StabilityMap stability_map(const StabilityJudge& judge, const core::Scene& scene, const Knob& x,
                           const Axis& across, const Knob& y, const Axis& up) {
  ThreadedRunner alone;
  return stability_map(judge, scene, x, across, y, up, alone);
}

}  // namespace tandem::analysis
