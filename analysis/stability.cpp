#include "analysis/stability.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <mutex>
#include <stdexcept>
#include <thread>
#include <unordered_map>

#include "analysis/lifted.h"
#include "analysis/resampled.h"

namespace tandem::analysis {

namespace {

/// Zero of `f` between a and b, where f(a) and f(b) differ in sign: secants kept in the bracket
/// (Anderson and Bjorck), halved whenever three of them did not halve it. Returns the last bracket.
template <typename F>
Interval bracket_zero(F&& f, double a, double fa, double b, double fb, double tolerance) {
  double width = std::abs(b - a);
  for (int i = 0, slow = 0; i < 200; ++i) {
    if (std::abs(b - a) <= tolerance * std::max(std::abs(a), std::abs(b))) break;
    double x = b - fb * (b - a) / (fb - fa);
    const double least = 0.25 * tolerance * std::max(std::abs(a), std::abs(b));
    const double low = std::min(a, b), high = std::max(a, b);
    if (slow >= 3 || !(x > low && x < high)) x = 0.5 * (a + b), slow = 0;
    x = std::clamp(x, low + least, high - least);
    if (!(x > low && x < high)) break;
    const double fx = f(x);
    if ((fx > 0.0) == (fb > 0.0)) {
      const double m = 1.0 - fx / fb;
      fa *= m > 0.0 ? m : 0.5;
    } else {
      a = b, fa = fb;
    }
    b = x, fb = fx;
    if (std::abs(b - a) <= 0.5 * width)
      width = std::abs(b - a), slow = 0;
    else
      ++slow;
  }
  return {a, b};
}

/// Maximum of f in [a, b] by golden section, or the first point found where f > 0.
template <typename F>
std::pair<double, double> climb(F&& f, double a, double b) {
  constexpr double kGolden = 0.6180339887498949;
  double x1 = b - kGolden * (b - a), x2 = a + kGolden * (b - a), f1 = f(x1), f2 = f(x2);
  for (int i = 0; i < 60 && f1 <= 0.0 && f2 <= 0.0; ++i) {
    if (std::abs(b - a) < 1e-13 * std::max(std::abs(a), std::abs(b))) break;
    if (f1 > f2) {
      b = x2, x2 = x1, f2 = f1;
      x1 = b - kGolden * (b - a), f1 = f(x1);
    } else {
      a = x1, x1 = x2, f1 = f2;
      x2 = a + kGolden * (b - a), f2 = f(x2);
    }
  }
  return f1 > f2 ? std::pair{x1, f1} : std::pair{x2, f2};
}

}  // namespace

StabilityJudge::StabilityJudge(const core::Scene& scene, const core::NetworkModel& network)
    : network_(network),
      two_sites_(TwoSites::of(scene, network)),
      resampled_(why_not_resampled(scene, network).empty()) {}

double StabilityJudge::margin(const core::Scene& scene) {
  ++evaluations_;
  if (two_sites_) {
    const double m = two_sites_->margin(scene);
    if (std::abs(m) > 1e-9) return m;
  }
  const double rho = radius(scene);
  return rho < 1e300 ? 1.0 - rho : -1e300;
}

double StabilityJudge::radius(const core::Scene& scene) {
  return judge(resampled_ ? resampled_system(scene, network_) : measured_system(scene, network_))
      .radius;
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
    const Interval rough = bracket_zero(f, p.first, p.second, q.first, q.second, 1e-9);
    // The last digits by eigenvalues, from a bracket a little wider.
    double a = std::min(rough.low, rough.high), b = std::max(rough.low, rough.high);
    const double room = 1e-8 * b;
    a = std::max(a - room, p.first);
    b = std::min(b + room, q.first);
    const double fa = exact(a), fb = exact(b);
    if ((fa > 0.0) == (fb > 0.0)) return 0.5 * (rough.low + rough.high);
    const Interval fine = bracket_zero(exact, a, fa, b, fb, options.tolerance);
    return 0.5 * (fine.low + fine.high);
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

StabilityMap stability_map(const StabilityJudge& judge, const core::Scene& scene, const Knob& x,
                           const Axis& across, const Knob& y, const Axis& up, int threads,
                           const std::function<bool(int, int)>& progress) {
  for (const auto& [axis, knob] : {std::pair{&across, &x}, std::pair{&up, &y}}) {
    if (!(axis->from < axis->to) || !std::isfinite(axis->from) || !std::isfinite(axis->to))
      throw std::invalid_argument(knob->name() + ": the range must go up");
    if (axis->count < 1 || axis->count > 100000)
      throw std::invalid_argument(knob->name() + ": 1 to 100000 cells");
  }
  if (1.0 * across.count * up.count > 1e9)
    throw std::invalid_argument("the map has more than 10^9 cells; take fewer");
  StabilityMap map;
  map.stable.assign(static_cast<std::size_t>(across.count) * up.count, 0);
  std::atomic<int> next{0}, done{0};
  std::atomic<bool> stop{false};
  std::mutex reporting;
  const auto work = [&] {
    StabilityJudge own = judge;
    core::Scene edited = scene;
    for (int j = next++; j < up.count && !stop; j = next++) {
      y.set(edited, up.centre(j));
      for (int i = 0; i < across.count; ++i) {
        x.set(edited, across.centre(i));
        map.stable[static_cast<std::size_t>(j) * across.count + i] =
            own.margin(edited) > 0.0 ? 1 : 0;
      }
      const int so_far = ++done;
      if (!progress) continue;
      const std::lock_guard lock(reporting);
      if (!progress(so_far, up.count)) stop = true;
    }
  };
  std::vector<std::thread> others;
  for (int t = 1; t < threads; ++t) others.emplace_back(work);
  work();
  for (std::thread& t : others) t.join();
  if (stop) throw std::runtime_error("stopped before the map was complete");
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

namespace {

/// Squares that know their corners' margins, refined where the boundary passes.
class Tracer {
 public:
  Tracer(StabilityJudge& judge, core::Scene scene, const Knob& x, const Axis& across, const Knob& y,
         const Axis& up, int levels, double tolerance)
      : judge_(judge),
        scene_(std::move(scene)),
        x_(x),
        y_(y),
        across_(across),
        up_(up),
        fine_(1 << levels),
        tolerance_(tolerance) {
    // With a gain of zero a spring is gone and the scene marginal: no boundary worth following.
    if (across_.from == 0.0) across_.from = 1e-4 * across_.to;
    if (up_.from == 0.0) up_.from = 1e-4 * up_.to;
  }

  std::vector<Segment> trace() {
    for (int j = 0; j < up_.count; ++j)
      for (int i = 0; i < across_.count; ++i) square(i * fine_, j * fine_, fine_);
    return std::move(segments_);
  }

 private:
  [[nodiscard]] double x_at(double i) const {
    return across_.from + i * (across_.to - across_.from) / (across_.count * fine_);
  }
  [[nodiscard]] double y_at(double j) const {
    return up_.from + j * (up_.to - up_.from) / (up_.count * fine_);
  }
  double at(double x, double y) {
    x_.set(scene_, x);
    y_.set(scene_, y);
    return judge_.margin(scene_);
  }
  double corner(int i, int j) {
    const auto key = static_cast<std::uint64_t>(i) << 32 | static_cast<std::uint32_t>(j);
    const auto found = corners_.find(key);
    if (found != corners_.end()) return found->second;
    return corners_[key] = at(x_at(i), y_at(j));
  }

  void square(int i, int j, int size) {
    const double f[4] = {corner(i, j), corner(i + size, j), corner(i + size, j + size),
                         corner(i, j + size)};
    const double low = *std::min_element(f, f + 4), high = *std::max_element(f, f + 4);
    const bool crossed = low <= 0.0 && high > 0.0;
    // Close to zero beside how much it changes: the boundary may dip in between the corners.
    const double nearest = low > 0.0 ? low : -high;
    const bool suspicious =
        !crossed && size == fine_ && nearest < 0.15 * (high - low) && nearest < 0.02;
    if (size > 1 && (crossed || suspicious)) {
      const int h = size / 2;
      for (const auto& [di, dj] : {std::pair{0, 0}, {h, 0}, {0, h}, {h, h}})
        square(i + di, j + dj, h);
      return;
    }
    if (!crossed) return;
    const int ci[4] = {i, i + size, i + size, i}, cj[4] = {j, j, j + size, j + size};
    std::vector<std::pair<double, double>> points;
    for (int e = 0; e < 4; ++e) {
      const int n = (e + 1) % 4;
      if ((f[e] > 0.0) != (f[n] > 0.0)) points.push_back(edge(ci[e], cj[e], ci[n], cj[n]));
    }
    for (std::size_t p = 0; p + 1 < points.size(); p += 2)
      segments_.push_back(
          {points[p].first, points[p].second, points[p + 1].first, points[p + 1].second});
  }

  std::pair<double, double> edge(int i0, int j0, int i1, int j1) {
    if (i1 < i0 || j1 < j0) std::swap(i0, i1), std::swap(j0, j1);
    const auto key = (static_cast<std::uint64_t>(i0) << 32 | static_cast<std::uint32_t>(j0)) * 2 +
                     (i1 > i0 ? 1 : 0);
    const auto found = edges_.find(key);
    if (found != edges_.end()) return found->second;
    const double x0 = x_at(i0), y0 = y_at(j0), x1 = x_at(i1), y1 = y_at(j1);
    const bool along_x = i1 > i0;
    const Interval zero =
        bracket_zero([&](double v) { return along_x ? at(v, y0) : at(x0, v); }, along_x ? x0 : y0,
                     corner(i0, j0), along_x ? x1 : y1, corner(i1, j1), tolerance_);
    const double v = zero.high;  // the last point looked at
    return edges_[key] = along_x ? std::pair{v, y0} : std::pair{x0, v};
  }

  StabilityJudge& judge_;
  core::Scene scene_;
  const Knob& x_;
  const Knob& y_;
  Axis across_, up_;
  int fine_;
  double tolerance_;
  std::unordered_map<std::uint64_t, double> corners_;
  std::unordered_map<std::uint64_t, std::pair<double, double>> edges_;
  std::vector<Segment> segments_;
};

}  // namespace

std::vector<Segment> stability_boundary(StabilityJudge& judge, core::Scene scene, const Knob& x,
                                        const Axis& across, const Knob& y, const Axis& up,
                                        int levels, double tolerance) {
  return Tracer(judge, std::move(scene), x, across, y, up, levels, tolerance).trace();
}

}  // namespace tandem::analysis
