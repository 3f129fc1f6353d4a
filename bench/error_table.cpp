#include "bench/error_table.h"

#include <algorithm>
#include <cmath>

namespace tandem::bench {

CaseResult compare_case(const std::vector<ErrorRow>& rows, int point, double scale,
                        bool only_default) {
  CaseResult out;
  out.point = point;
  out.scale = scale;
  std::vector<const ErrorRow*> ours, theirs;
  for (const ErrorRow& row : rows) {
    if (row.point != point || !row.in_tandem || !std::isfinite(row.error)) continue;
    if (row.engine != "tandem")
      theirs.push_back(&row);
    else if (row.is_default || !only_default)
      ours.push_back(&row);
  }
  if (ours.empty()) return out;
  const auto nearer = [](const ErrorRow* a, const ErrorRow* b) { return a->error < b->error; };
  const ErrorRow& best = **std::min_element(ours.begin(), ours.end(), nearer);
  out.least_error = best.error;
  for (const ErrorRow* p : theirs) {
    if (p->error > scale / 20.0) continue;
    const bool beaten = std::any_of(theirs.begin(), theirs.end(), [p](const ErrorRow* q) {
      return q != p && q->error <= p->error && q->ns_per_s < p->ns_per_s;
    });
    if (beaten) continue;
    Comparison c{point,       p->engine,     p->setting, p->hz,       p->error,
                 p->ns_per_s, best.ns_per_s, best.hz,    best.setting};
    if (best.error > p->error) {
      out.unreached.push_back(c);
      continue;
    }
    for (const ErrorRow* o : ours)
      if (o->error <= p->error && o->ns_per_s < c.tandem_ns)
        c.tandem_ns = o->ns_per_s, c.tandem_hz = o->hz, c.tandem_setting = o->setting;
    out.reached.push_back(c);
    if (!out.least || c.speedup() < out.least->speedup()) out.least = c;
  }
  return out;
}

std::optional<double> observed_order(const std::vector<ErrorRow>& rows, int point,
                                     const std::string& setting, double scale, double floor) {
  const bool own = kErrorPoints[static_cast<std::size_t>(point)].which == Case::kStickSlip;
  double n = 0.0, x = 0.0, y = 0.0, xx = 0.0, xy = 0.0;
  for (const ErrorRow& row : rows) {
    const double error = own ? row.law_error : row.error;
    if (row.point != point || row.engine != "tandem" || row.setting != setting || row.hz < 1024 ||
        !(error < scale / 20.0) || !(error > floor))
      continue;
    const double step = -std::log(static_cast<double>(row.hz)), e = std::log(error);
    n += 1.0, x += step, y += e, xx += step * step, xy += step * e;
  }
  if (n < 3.0) return std::nullopt;
  return (n * xy - x * y) / (n * xx - x * x);
}

}  // namespace tandem::bench
