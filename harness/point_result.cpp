#include "harness/point_result.h"

#include <cmath>

#include <fmt/format.h>

namespace tandem::harness {

namespace {

const char* side(bool stable) { return stable ? "stable" : "not stable"; }

std::string measured(const Stability& s) {
  return std::string(side(s.stable)) + (s.reason.empty() ? "" : ": " + s.reason);
}

constexpr double kNear = 0.1;    // of the boundary in coupling
constexpr double kExact = 1e-3;  // to which it is found

/// A session at so many times the largest coupling that the analysis predicts for its own delays.
struct Side {
  bool known = false, stable = false;
};
Side expected_side(double ratio) {  // nothing of what is no number
  if (ratio <= (1.0 - kNear) * (1.0 + kExact)) return {true, true};
  if (std::isfinite(ratio) && ratio >= (1.0 + kNear) * (1.0 - kExact)) return {true, false};
  return {};
}

/// The drag of a session that blows up is that of its blowing up.
bool compares_drag(const PointResult& r) {
  return !r.failed && r.prediction.judged && r.prediction.stable && r.measures.stability.stable &&
         !(r.push_missed > kMostMissed) && std::isfinite(r.measures.drag);
}

/// Calls `say(exact, what)` for what does not agree, and counts.
template <typename Say>
void compare(const PointResult& r, Comparisons& count, Say&& say) {
  const Prediction& p = r.prediction;
  const auto with_analysis = [&](const Stability& s, Side expected, const std::string& what) {
    if (!p.judged || !s.judged) return;
    if (!expected.known) {
      ++count.near_boundary;
      return;
    }
    ++count.with_analysis;
    if (s.stable != expected.stable) say(p.exact, what + measured(s));
  };
  const auto with_twin = [&](const Stability& s, const VirtualTwin& t, const std::string& what) {
    if (!t.judged || !s.judged || t.near_boundary) return;
    ++count.with_virtual_time;
    if (s.stable != t.stable)
      say(true, fmt::format("{}virtual time over the recorded packets {}, sockets {}", what,
                            side(t.stable), measured(s)));
  };
  const Stability& s = r.measures.stability;
  const auto ran = [&](double missed) {
    if (missed > kMostMissed) ++count.missed_ticks;
    return missed <= kMostMissed;
  };
  if (ran(r.kick_missed)) {
    with_analysis(s, {!p.near_boundary, p.stable},
                  fmt::format("stability: predicted {} ({:.6f} a packet), measured ",
                              side(p.stable), p.growth_per_packet));
    with_twin(s, r.twin, "");
  }
  for (const bool above : {false, true}) {
    const BoundaryTry& t = above ? r.above : r.below;
    if (!t.done || !ran(t.missed_share)) continue;
    const double factor = above ? 1.1 : 0.9;
    const std::string what = fmt::format("at {} of the predicted largest coupling: ", factor);
    const Side expected = expected_side(t.ratio);
    with_analysis(t.stability, expected,
                  fmt::format("{}expected {}, measured ", what, side(expected.stable)));
    with_twin(t.stability, t.twin, what);
  }
}

}  // namespace

std::vector<Disagreement> disagreements(const std::vector<PointResult>& results) {
  constexpr double kDragOff = 0.1;  // of the prediction
  // Of what hold has there. Extrapolation makes up for a drag that grows with the age of the
  // samples; what is left is the error of the ages, which wanders from tick to tick with the
  // wake-ups of the force loop, by some hundredths.
  constexpr double kHoldDragOff = 0.02;
  std::vector<Disagreement> out;
  for (const PointResult& r : results) {
    if (r.failed) continue;
    Comparisons ignored;
    compare(r, ignored, [&](bool exact, const std::string& what) {
      out.push_back({exact, r.point.name, what});
    });
    const Prediction& p = r.prediction;
    const auto drag = [&](bool exact, const char* who, double wanted) {
      const double off = std::abs(r.measures.drag - wanted);
      double allowed = kDragOff * std::max(std::abs(wanted), kLeastDrag);
      if (std::isfinite(r.hold_drag) &&
          r.point.scene.reconstruction.kind == core::ReconstructionKind::kExtrapolate)
        allowed = std::max(allowed, kHoldDragOff * std::abs(r.hold_drag));
      if (std::isfinite(off) && off > allowed)
        out.push_back(
            {exact, r.point.name,
             fmt::format("drag: {} {:.4g} N s/m, measured {:.4g}", who, wanted, r.measures.drag)});
    };
    if (!compares_drag(r)) continue;
    drag(p.exact, "predicted", p.drag);
    drag(true, "virtual time over the recorded packets", r.twin.drag);
  }
  return out;
}

std::vector<Disagreement> disagreements(const std::vector<DelayBoundary>& boundaries) {
  constexpr double kOff = 0.1;
  std::vector<Disagreement> out;
  for (const DelayBoundary& b : boundaries) {
    const double bound = std::isinf(b.predicted) ? 0.0 : std::max(b.tick, kOff * b.predicted);
    const auto off = [&](double one, double other) { return one - other > bound; };
    if (b.predicted != b.in_virtual_time &&
        (off(b.predicted, b.in_virtual_time) || off(b.in_virtual_time, b.predicted)))
      out.push_back(
          {true, b.scene,
           fmt::format("boundary in delay: predicted {:.4g} ms, in virtual time {:.4g} ms",
                       1e3 * b.predicted, 1e3 * b.in_virtual_time)});
    // Stable just below the boundary, not at it.
    if (off(b.real_stable, b.predicted) || off(b.predicted, b.real_not_stable))
      out.push_back({true, b.scene,
                     fmt::format("boundary in delay: predicted {:.4g} ms, sockets stable at {:.4g} "
                                 "ms and not at {:.4g} ms",
                                 1e3 * b.predicted, 1e3 * b.real_stable, 1e3 * b.real_not_stable)});
  }
  return out;
}

Comparisons comparisons(const std::vector<PointResult>& results) {
  Comparisons count;
  for (const PointResult& r : results) {
    if (!r.failed) compare(r, count, [](bool, const std::string&) {});
    count.drags += compares_drag(r) && std::isfinite(r.prediction.drag) ? 1 : 0;
  }
  return count;
}

}  // namespace tandem::harness
