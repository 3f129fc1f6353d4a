#include "harness/measures.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

namespace tandem::harness {

namespace {

double length_of(const core::Vec3& v) { return std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z); }

/// From the first slot to be measured.
std::size_t first_sample(const Trajectory& session, const SiteTrajectory& site) {
  const auto at =
      std::lower_bound(site.samples.begin(), site.samples.end(), session.first_slot,
                       [](const SiteSample& s, std::int64_t slot) { return s.slot < slot; });
  return static_cast<std::size_t>(at - site.samples.begin());
}

/// Sample of this slot, or of the last one before it; null before the first.
const SiteSample* sample_at(const SiteTrajectory& site, std::int64_t slot) {
  const auto after =
      std::upper_bound(site.samples.begin(), site.samples.end(), slot,
                       [](std::int64_t wanted, const SiteSample& s) { return wanted < s.slot; });
  return after == site.samples.begin() ? nullptr : &*(after - 1);
}

std::int64_t last_slot(const Trajectory& session) {
  std::int64_t last = std::numeric_limits<std::int64_t>::max();
  for (const SiteTrajectory& site : session.sites)
    last = std::min(last, site.samples.empty() ? session.first_slot : site.samples.back().slot);
  return last;
}

/// Sites that hold a copy of the object, or one of them where there is only the server's.
std::vector<const SiteTrajectory*> with_object(const Trajectory& session) {
  std::vector<const SiteTrajectory*> out;
  for (const SiteTrajectory& site : session.sites)
    if (site.has_object && !site.samples.empty()) out.push_back(&site);
  return out;
}

/// Value below which a share of them lies; `values` is reordered.
double quantile(std::vector<double>& values, double share) {
  if (values.empty()) return kNotMeasured;
  const auto at = static_cast<std::ptrdiff_t>(
      std::min(share * static_cast<double>(values.size()), static_cast<double>(values.size() - 1)));
  std::nth_element(values.begin(), values.begin() + at, values.end());
  return values[static_cast<std::size_t>(at)];
}

void measure_gap(const Trajectory& session, Measures& out) {
  const auto copies = with_object(session);
  if (copies.size() < 2) return;
  std::vector<double> gaps;
  double sum = 0.0;
  const SiteTrajectory& first = *copies.front();
  for (std::size_t k = first_sample(session, first); k < first.samples.size(); ++k) {
    const SiteSample& one = first.samples[k];
    double widest = 0.0;
    bool all = true;
    for (std::size_t i = 0; i < copies.size() && all; ++i)
      for (std::size_t j = i + 1; j < copies.size(); ++j) {
        const SiteSample* a = i == 0 ? &one : sample_at(*copies[i], one.slot);
        const SiteSample* b = sample_at(*copies[j], one.slot);
        all = a != nullptr && b != nullptr;
        if (!all) break;
        widest = std::max(widest, length_of(a->object - b->object));
      }
    if (!all) continue;
    gaps.push_back(widest);
    sum += widest * widest;
  }
  if (gaps.empty()) return;
  out.gap_rms = std::sqrt(sum / static_cast<double>(gaps.size()));
  out.gap_999 = quantile(gaps, 0.999);
}

SiteMeasures measure_site(const Trajectory& session, const SiteTrajectory& site,
                          const Trajectory* twin_session, const SiteTrajectory* twin) {
  constexpr double kLeastForce = 0.5;  // methods, section 4: below it Weber's law does not hold [N]
  SiteMeasures m;
  if (site.samples.empty()) return m;
  const std::size_t from = first_sample(session, site);
  if (from >= site.samples.size()) return m;
  const double seconds =
      static_cast<double>(site.samples.back().slot - site.samples.front().slot + 1) * session.tick;
  if (site.packets_sent > 0) {
    m.packets_per_s = static_cast<double>(site.packets_sent) / seconds;
    m.bytes_per_s = static_cast<double>(site.bytes_sent) / seconds;
  }
  double sum = 0.0, error = 0.0, weber = 0.0;
  std::int64_t n = 0, compared = 0;
  for (std::size_t k = from; k < site.samples.size(); ++k) {
    const SiteSample& s = site.samples[k];
    for (int f = 0; f < site.fingers; ++f) {
      sum += std::pow(length_of(s.force[f]), 2);
      ++n;
      if (twin == nullptr) continue;
      const SiteSample* t =
          sample_at(*twin, s.slot - session.first_slot + twin_session->first_slot);
      if (t == nullptr) continue;
      const double e = length_of(s.force[f] - t->force[f]);
      const double w = e / std::max(length_of(t->force[f]), kLeastForce);
      error += e * e;
      weber += w * w;
      ++compared;
    }
  }
  if (n > 0) m.force_rms = std::sqrt(sum / static_cast<double>(n));
  if (compared > 0) {
    m.force_error = std::sqrt(error / static_cast<double>(compared));
    m.force_error_weber = std::sqrt(weber / static_cast<double>(compared));
  }
  if (site.has_network_energy) {
    const double before = from > 0 ? site.samples[from - 1].network_energy : 0.0;
    double most = 0.0;
    for (std::size_t k = from; k < site.samples.size(); ++k)
      most = std::max(most, site.samples[k].network_energy - before);
    m.network_energy = most;
    m.network_energy_end = site.samples.back().network_energy - before;
  }
  return m;
}

}  // namespace

StabilityMeter::StabilityMeter(double seconds, double packet_period, double floor)
    : seconds_(seconds), period_(packet_period), floor_(floor) {}

void StabilityMeter::add(double time, int which, double distance) {
  if (left_) return;
  if (!(std::abs(distance) <= kBound)) {
    left_ = true;
    left_at_ = time;
    return;
  }
  if (static_cast<std::size_t>(which) >= ranges_.size())
    ranges_.resize(static_cast<std::size_t>(which) + 1);
  const int w = std::clamp(static_cast<int>(time / seconds_ * kWindows), 0, kWindows - 1);
  Range& range = ranges_[static_cast<std::size_t>(which)][static_cast<std::size_t>(w)];
  range.low = std::min(range.low, distance);
  range.high = std::max(range.high, distance);
}

Stability StabilityMeter::judge() const {
  Stability out;
  if (left_) {
    out.judged = true;
    out.stable = false;
    out.reason = fmt::format("a distance leaves {:g} m after {:.2f} s", kBound, left_at_);
    out.growth_per_s = std::numeric_limits<double>::infinity();
    out.growth_per_packet = std::numeric_limits<double>::infinity();
    return out;
  }
  std::array<double, kWindows> e{};
  for (const auto& windows : ranges_)
    for (int w = 0; w < kWindows; ++w)
      if (windows[w].high >= windows[w].low)
        e[w] = std::max(e[w], windows[w].high - windows[w].low);
  const auto widest = [&](int from, int to) {
    return *std::max_element(e.begin() + from, e.begin() + to);
  };
  const double floor = std::max(kFloor, floor_ * widest(0, kWindows));
  if (widest(0, kWindows) <= floor) return out;  // nothing moved
  out.judged = true;

  int start = 0;
  while (e[start] <= floor && start < kWindows - 1) ++start;
  // Slope of log e over the windows [from, to) that are above the floor; not a number of too few.
  const auto fitted = [&](int from, int to, int least) {
    double n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
    for (int w = from; w < to; ++w) {
      if (e[w] <= floor) continue;
      const double x = (w + 0.5) * seconds_ / kWindows, y = std::log(e[w]);
      n += 1, sx += x, sy += y, sxx += x * x, sxy += x * y;
    }
    return n >= least ? (n * sxy - sx * sy) / (n * sxx - sx * sx) : kNotMeasured;
  };
  double slope = fitted(kWindows / 2, kWindows, 4);
  // What has died out before has told its growth on the way down.
  int end = start;
  while (end < kWindows && e[end] > floor) ++end;
  const double shown = std::isfinite(slope) ? slope : fitted(start + 1, end, 3);
  if (std::isfinite(shown)) {
    out.growth_per_s = std::exp(shown);
    out.growth_per_packet = std::exp(shown * period_);
  }
  if (!std::isfinite(slope)) slope = 0.0;
  if (slope > std::log(kGrowth) && slope * 0.5 * seconds_ > std::log(kRise)) {
    out.stable = false;
    out.reason = fmt::format("the envelope grows {:.4g} times a second", out.growth_per_s);
    return out;
  }
  const int quarter = kWindows / 4;
  if (start + 2 <= kWindows - quarter) {
    const double early = widest(start, start + 2), late = widest(kWindows - quarter, kWindows);
    if (late > kSwell * early) {
      out.stable = false;
      out.reason =
          fmt::format("the last quarter moves {:.3g} times as far as the start", late / early);
    }
  }
  return out;
}

Stability judge_stability(const Trajectory& session, double floor) {
  const std::int64_t last = last_slot(session);
  const double seconds = static_cast<double>(last - session.first_slot) * session.tick;
  if (session.sites.empty() || !(seconds > 0.5)) return {};
  StabilityMeter meter(seconds, session.tick * session.ticks_per_packet, floor);
  const auto copies = with_object(session);
  if (copies.empty()) return {};
  int which = 0;
  for (const SiteTrajectory& site : session.sites) {
    for (std::size_t k = first_sample(session, site); k < site.samples.size(); ++k) {
      const SiteSample& s = site.samples[k];
      const double time = static_cast<double>(s.slot - session.first_slot) * session.tick;
      const SiteSample* own = site.has_object ? &s : sample_at(*copies.front(), s.slot);
      const SiteSample* first = sample_at(*copies.front(), s.slot);
      if (s.slot > last || own == nullptr || first == nullptr) continue;
      int at = which;
      for (int i = 0; i < 3; ++i) {
        for (int f = 0; f < site.fingers; ++f) meter.add(time, at++, s.hand[f][i] - own->object[i]);
        meter.add(time, at++, own->object[i] - first->object[i]);
      }
    }
    which += 3 * (site.fingers + 1);
  }
  return meter.judge();
}

bool has_blown_up(const Trajectory& session) {
  const Stability s = judge_stability(session);
  return !s.stable && std::isinf(s.growth_per_s);
}

Measures measure(const Trajectory& session, const Trajectory* twin) {
  Measures out;
  measure_gap(session, out);
  for (std::size_t i = 0; i < session.sites.size(); ++i)
    out.sites.push_back(
        measure_site(session, session.sites[i], twin,
                     twin != nullptr && i < twin->sites.size() ? &twin->sites[i] : nullptr));
  return out;
}

MeasuredDrag measure_drag(const Trajectory& session, int site, double force) {
  MeasuredDrag out;
  const SiteTrajectory& who = session.sites.at(static_cast<std::size_t>(site));
  const std::int64_t last = last_slot(session);
  const std::int64_t all = last - session.first_slot;
  const std::int64_t sixth = all / 6 / session.ticks_per_packet * session.ticks_per_packet;
  if (sixth <= 0) return out;
  double v[3];
  for (int i = 0; i < 3; ++i) {
    const SiteSample* from = sample_at(who, last - (3 - i) * sixth);
    const SiteSample* to = sample_at(who, last - (2 - i) * sixth);
    if (from == nullptr || to == nullptr || to->slot <= from->slot) return out;
    v[i] = (to->hand[0].x - from->hand[0].x) /
           (static_cast<double>(to->slot - from->slot) * session.tick);
  }
  const double d1 = v[1] - v[0], d2 = v[2] - v[1];
  const double scale = std::abs(v[0]) + std::abs(v[1]) + std::abs(v[2]);
  if (!std::isfinite(scale) || scale == 0.0) return out;
  out.settled = std::abs(d2) < 0.01 * std::abs(v[2]);
  // Settled: what change is left would only be extrapolated with its noise.
  if (std::abs(d1) < 0.01 * scale / 3.0) {
    out.n_s_per_m = force / v[2];
    return out;
  }
  const double q = d2 / d1;
  out.growth_per_s = std::pow(q, 1.0 / (static_cast<double>(sixth) * session.tick));
  out.n_s_per_m = force * (1.0 - q) / (v[0] * (1.0 - q) + d1);
  return out;
}

void judge_by_drag(Stability& stability, const MeasuredDrag& drag, double packet_period) {
  if (!stability.judged || !stability.stable || !(drag.n_s_per_m < -kLeastDrag)) return;
  stability.stable = false;
  stability.reason =
      fmt::format("a hand that moves freely speeds up: drag {:.3g} N s/m", drag.n_s_per_m);
  stability.growth_per_s = drag.growth_per_s;
  stability.growth_per_packet = std::pow(drag.growth_per_s, packet_period);
}

double measure_stiffness(const Trajectory& session, int site, double seconds) {
  const SiteTrajectory& who = session.sites.at(static_cast<std::size_t>(site));
  const std::int64_t last = last_slot(session);
  const std::int64_t from =
      std::max(session.first_slot, last + 1 - std::int64_t{std::llround(seconds / session.tick)});
  double n = 0, sx = 0, sf = 0, sxx = 0, sxf = 0;
  for (const SiteSample& s : who.samples) {
    if (s.slot < from || s.slot > last) continue;
    const double x = s.hand[0].x, f = -s.force[0].x;
    n += 1, sx += x, sf += f, sxx += x * x, sxf += x * f;
  }
  const double spread = n * sxx - sx * sx;
  return n > 2 && spread > 0.0 ? (n * sxf - sx * sf) / spread : kNotMeasured;
}

double motion_to_force(const Trajectory& session, int mover, int feeler, double motion,
                       double force) {
  const SiteTrajectory& moves = session.sites.at(static_cast<std::size_t>(mover));
  const SiteTrajectory& feels = session.sites.at(static_cast<std::size_t>(feeler));
  const SiteSample* start = sample_at(moves, session.first_slot);
  if (start == nullptr) return kNotMeasured;
  const core::Vec3 rest = start->hand[0];
  for (const SiteSample& m : moves.samples) {
    if (m.slot < session.first_slot || length_of(m.hand[0] - rest) <= motion) continue;
    core::Vec3 before(0.0);
    double n = 0;
    for (const SiteSample& f : feels.samples) {
      if (f.slot < session.first_slot) continue;
      if (f.slot < m.slot) {
        before += f.force[0];
        n += 1;
      } else if (length_of(f.force[0] - (n > 0 ? before * (1.0 / n) : core::Vec3(0.0))) > force) {
        return static_cast<double>(f.slot - m.slot) * session.tick;
      }
    }
    return kNotMeasured;
  }
  return kNotMeasured;
}

}  // namespace tandem::harness
