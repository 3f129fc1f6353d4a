#include "harness/point_result.h"

#include <cmath>

#include <fmt/format.h>

namespace tandem::harness {

namespace {

const char* side(bool stable) { return stable ? "stable" : "not stable"; }

}  // namespace

std::vector<Disagreement> disagreements(const std::vector<PointResult>& results) {
  constexpr double kDragOff = 0.1;     // of the prediction
  constexpr double kLeastDrag = 0.05;  // below it a tenth means nothing [N s/m]
  std::vector<Disagreement> out;
  for (const PointResult& r : results) {
    const Prediction& p = r.prediction;
    if (r.failed || !p.judged) continue;
    const Stability& s = r.measures.stability;
    if (s.judged && !p.near_boundary && s.stable != p.stable)
      out.push_back({p.exact, r.point.name,
                     fmt::format("stability: predicted {} ({:.6f} a packet), measured {}{}",
                                 side(p.stable), p.growth_per_packet, side(s.stable),
                                 s.reason.empty() ? "" : ": " + s.reason)});
    if (r.tried_below && r.below.judged && !r.below.stable)
      out.push_back({p.exact, r.point.name,
                     "at 0.9 of the predicted largest coupling: not stable, " + r.below.reason});
    if (r.tried_above && r.above.judged && r.above.stable)
      out.push_back({p.exact, r.point.name, "at 1.1 of the predicted largest coupling: stable"});
    // The drag of a session that blows up is that of its blowing up.
    const double off = std::abs(r.measures.drag - p.drag);
    if (p.stable && s.stable && std::isfinite(off) &&
        off > kDragOff * std::max(std::abs(p.drag), kLeastDrag))
      out.push_back(
          {p.exact, r.point.name,
           fmt::format("drag: predicted {:.4g} N s/m, measured {:.4g}", p.drag, r.measures.drag)});
  }
  return out;
}

}  // namespace tandem::harness
