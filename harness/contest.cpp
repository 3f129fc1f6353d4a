#include "harness/contest.h"

#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>

namespace tandem::harness {

namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();

double mean_of_sites(const PointResult& r, double SiteMeasures::*what) {
  double sum = 0.0;
  int n = 0;
  for (const SiteMeasures& site : r.measures.sites)
    if (std::isfinite(site.*what)) sum += site.*what, ++n;
  return n > 0 ? sum / n : kNotMeasured;
}

Contender contender(const PointResult& r) {
  Contender c;
  c.there = true;
  c.failed = r.failed;
  if (r.failed) return c;
  const Stability& s = r.measures.stability;
  c.missed_ticks = r.kick_missed > kMostMissed;
  c.judged = s.judged && !c.missed_ticks;
  c.stable = c.judged && s.stable;
  c.near_boundary = r.prediction.judged && r.prediction.near_boundary;
  c.age = r.mean_age;
  const bool ran = !(r.missed_share > kMostMissed);
  if (c.stable && ran) {
    c.weber = mean_of_sites(r, &SiteMeasures::force_error_weber);
    c.newton = mean_of_sites(r, &SiteMeasures::force_error);
    if (std::isfinite(r.measures.drag)) c.drag = r.measures.drag;
  }
  c.coupling = r.real ? confirmed_coupling(r, c.unconfirmed) : r.largest_coupling;
  return c;
}

/// Those of the known values within kAlike of the best; `sign` 1: the larger the better. None if
/// nobody has anything (`worst`).
std::vector<int> best(const std::array<double, kReconstructions>& values, bool larger, int& known) {
  const double worst = larger ? 0.0 : kInfinite;
  double top = worst;
  known = 0;
  for (const double v : values) {
    if (std::isnan(v)) continue;
    ++known;
    top = larger ? std::max(top, v) : std::min(top, v);
  }
  std::vector<int> out;
  if (known < 2 || top == worst) return out;
  for (int i = 0; i < kReconstructions; ++i) {
    const double v = values[static_cast<std::size_t>(i)];
    if (!std::isnan(v) && (larger ? v * kAlike >= top : v <= kAlike * top)) out.push_back(i);
  }
  return out;
}

bool any_unconfirmed(const Contest& contest) {
  return std::any_of(contest.by.begin(), contest.by.end(),
                     [](const Contender& c) { return !c.unconfirmed.empty(); });
}

void judge(Contest& contest) {
  std::array<double, kReconstructions> errors{}, newtons{}, couplings{};
  double ages = 0.0;
  int n = 0;
  for (std::size_t i = 0; i < kReconstructions; ++i) {
    const Contender& c = contest.by[i];
    errors[i] = c.error();
    newtons[i] = std::isfinite(c.error()) ? c.newton : c.error();
    couplings[i] = c.coupling;
    if (std::isfinite(c.age)) ages += c.age, ++n;
  }
  if (n > 0) contest.age = ages / n;
  contest.least_newton = best(newtons, false, contest.error_known);
  contest.least_error = best(errors, false, contest.error_known);
  contest.largest_coupling = best(couplings, true, contest.coupling_known);
  // Who was not confirmed may bear more than all others.
  if (any_unconfirmed(contest)) {
    contest.largest_coupling.clear();
    contest.coupling_known = 0;
  }
}

double interpolated(const Standing& a, const Standing& b) {
  const double from = std::log(a.ratio), to = std::log(b.ratio);
  if (!std::isfinite(from) || !std::isfinite(to) || from == to) return kNotMeasured;
  return a.age + (b.age - a.age) * from / (from - to);
}

/// Over the standings from `first` to `last`, which differ, the ones between them alike: the first
/// pair of neighbours between which the ratio passes 1.
double crossing_at(const std::vector<Standing>& all, std::size_t first, std::size_t last) {
  for (std::size_t i = first; i < last; ++i)
    if ((all[first].ratio > 1.0) != (all[i + 1].ratio > 1.0))
      return interpolated(all[i], all[i + 1]);
  return kNotMeasured;
}

/// `ratio_of` is 0/0 where nobody is stable and no number where too little is known.
template <typename Ratio>
ByAge by_age(const std::vector<Contest>& contests, Ratio&& ratio_of) {
  ByAge out;
  for (const Contest& contest : contests) {
    bool none_stable = false;
    const double ratio = ratio_of(contest, none_stable);
    if (none_stable) out.none_stable.push_back(contest.label);
    if (!none_stable && !std::isnan(ratio) && std::isfinite(contest.age))
      out.standings.push_back({contest.age, contest.label, ratio});
  }
  std::stable_sort(out.standings.begin(), out.standings.end(),
                   [](const Standing& a, const Standing& b) { return a.age < b.age; });
  std::size_t last = out.standings.size();  // that won or lost
  for (std::size_t i = 0; i < out.standings.size(); ++i) {
    const Standing& s = out.standings[i];
    if (!s.wins() && !s.loses()) continue;
    if (last < i && out.standings[last].wins() != s.wins())
      out.crossings.push_back({out.standings[last], s, crossing_at(out.standings, last, i)});
    last = i;
  }
  return out;
}

double error_ratio(const Contest& contest, bool& none_stable) {
  const double own = contest.by[kExtrapolation].error();
  const double rival = std::fmin(contest.by[kHeld].error(), contest.by[kCompensation].error());
  none_stable = own == kInfinite && rival == kInfinite;
  return rival / own;
}

double coupling_ratio(const Contest& contest, bool& none_stable) {
  const double own = contest.by[kExtrapolation].coupling;
  const double rival = std::fmax(contest.by[kHeld].coupling, contest.by[kCompensation].coupling);
  if (any_unconfirmed(contest)) return kNotMeasured;
  none_stable = own == 0.0 && rival == 0.0;
  return own / rival;
}

Margin margin_of(const std::vector<Contest>& contests) {
  std::vector<double> ratios;
  Margin m;
  for (const Contest& contest : contests) {
    const double hold = contest.by[kHeld].coupling;
    const double left = contest.by[kCompensation].coupling / hold;
    if (!(hold > 0.0) || std::isinf(hold) || !std::isfinite(left)) continue;
    if (left == 0.0) {
      m.nothing_at.push_back(contest.label);
      continue;
    }
    if (ratios.empty() || left < m.least) m.least = left, m.least_at = contest.label;
    if (ratios.empty() || left > m.most) m.most = left, m.most_at = contest.label;
    ratios.push_back(left);
  }
  if (ratios.empty()) return m;
  m.known = true;
  std::sort(ratios.begin(), ratios.end());
  m.median = 0.5 * (ratios[(ratios.size() - 1) / 2] + ratios[ratios.size() / 2]);
  return m;
}

/// Not where the analysis knows no boundary for its delays.
bool ran_over_the_same(const BoundaryTry& t, double factor) {
  return t.ratio / factor < kSameNetwork && factor / t.ratio < kSameNetwork;
}

}  // namespace

double Contender::error() const {
  if (!there || failed || !judged) return kNotMeasured;
  return stable ? weber : kInfinite;
}

double confirmed_coupling(const PointResult& r, std::string& why) {
  why.clear();
  const double predicted = r.prediction.largest_coupling;
  if (!r.prediction.judged || std::isnan(predicted)) {
    why = "no prediction";
  } else if (predicted == 0.0) {
    if (r.measures.stability.judged && !r.measures.stability.stable &&
        !(r.kick_missed > kMostMissed))
      return 0.0;
    why = "predicted 0, though the session as it is was not seen to be unstable";
  } else if (!r.below.done || !r.above.done || !r.below.stability.judged ||
             !r.above.stability.judged) {
    why = "not tried at both 0.9 and 1.1 times the prediction";
  } else if (r.below.missed_share > kMostMissed || r.above.missed_share > kMostMissed) {
    why = "ticks were missed";
  } else if (!ran_over_the_same(r.below, 0.9) || !ran_over_the_same(r.above, 1.1)) {
    why = "delays of the tries were others than those predicted from";
  } else if (!r.below.stability.stable) {
    why = "not stable at 0.9 times the prediction";
  } else if (r.above.stability.stable) {
    why = "stable at 1.1 times the prediction";
  } else {
    return predicted;
  }
  return kNotMeasured;
}

std::vector<Contests> contests(const std::vector<PointResult>& results) {
  std::vector<Contests> out;
  for (const PointResult& r : results) {
    const auto style = std::find(kStyleNames.begin(), kStyleNames.end(), r.point.style);
    if (style == kStyleNames.end()) continue;
    auto group = std::find_if(out.begin(), out.end(), [&](const Contests& c) {
      return c.architecture == r.point.architecture;
    });
    if (group == out.end()) {
      group = out.insert(out.end(), Contests{});
      group->architecture = r.point.architecture;
      group->knob = r.point.knob;
      group->coupling = coupling_name(r.point.scene);
      group->real = r.real;
    }
    auto contest = std::find_if(group->at.begin(), group->at.end(),
                                [&](const Contest& c) { return c.label == r.point.label; });
    if (contest == group->at.end()) {
      contest = group->at.insert(group->at.end(), Contest{});
      contest->label = r.point.label;
    }
    contest->by[static_cast<std::size_t>(style - kStyleNames.begin())] = contender(r);
  }
  for (Contests& group : out) {
    for (Contest& contest : group.at) judge(contest);
    group.margin = margin_of(group.at);
    group.by_error = by_age(group.at, error_ratio);
    group.by_coupling = by_age(group.at, coupling_ratio);
  }
  return out;
}

}  // namespace tandem::harness
