#include "bench/boundary_accuracy.h"

#include <cmath>
#include <vector>

#include <fmt/format.h>

#include "analysis/boundary.h"
#include "analysis/roots.h"
#include "bench/processor_time.h"
#include "scene/load_scene.h"

namespace tandem::bench {

namespace {

using analysis::Axis;
using analysis::Knob;

/// Fig 5.4, one packet of delay: for each stiffness between copies (x) the largest one to the other
/// hand (y). It has one boundary in each column.
struct Line {
  core::Scene scene = scene::load_scene("axis_distributed");
  core::NetworkModel network;
  Axis x{0.0, 6000.0, 100};
  double from = 0.6, to = 6000.0;
  Knob copies, other;

  Line()
      : copies(scene, "coupler.ko1.stiffness,coupler.ko2.stiffness"),
        other(scene, "coupler.k12.stiffness,coupler.k21.stiffness") {
    for (core::CouplerParameters& c : scene.couplers) c.gain.damping = 10.0;
    Knob(scene, "coupler.k11.stiffness,coupler.k22.stiffness").set(scene, 2000.0);
    network.set_round_trip(1, scene.ticks_per_packet());
  }

  /// Zero of margin(scene) along column i by bracketed steps; not-a-number without a boundary.
  template <typename Margin>
  double boundary(int i, double tolerance, Margin&& margin) const {
    core::Scene edited = scene;
    copies.set(edited, x.centre(i));
    const auto f = [&](double v) {
      other.set(edited, v);
      return margin(edited);
    };
    const double a = f(from), b = f(to);
    if ((a > 0.0) == (b > 0.0)) return std::nan("");
    const auto found = analysis::bracket_zero(f, from, a, to, b, tolerance);
    return 0.5 * (found.first + found.second);
  }
};

}  // namespace

nlohmann::ordered_json accuracy_table(const nlohmann::json& peer, std::string& text) {
  const Line line;
  analysis::StabilityJudge judge(line.scene, line.network);
  const auto by_eigenvalues = [&](const core::Scene& s) { return 1.0 - judge.radius(s); };
  const auto on_the_loop = [&](const core::Scene& s) { return 1.0 - judge.radius_on_the_loop(s); };
  const auto by_routh = [&](const core::Scene& s) { return judge.margin(s); };
  std::vector<double> exact;
  for (int i = 0; i < line.x.count; ++i) exact.push_back(line.boundary(i, 1e-13, by_eigenvalues));

  nlohmann::ordered_json out = nlohmann::ordered_json::array();
  text += "time of one boundary point of Fig 5.4, d = 1, and its largest relative error\n";
  const auto tell = [&](const std::string& method, double asked, double us, double error) {
    text += fmt::format("  {:28} asked {:7.0e}  {:10.1f} us  error {:8.1e}\n", method, asked, us,
                        error);
    out.push_back(
        {{"method", method}, {"tolerance", asked}, {"us_per_point", us}, {"error", error}});
  };
  const auto worst = [&](const std::vector<double>& found, int step) {
    double error = 0.0;
    for (std::size_t k = 0; k < found.size(); ++k) {
      const double right = exact[k * static_cast<std::size_t>(step)];
      if (!std::isnan(right)) error = std::max(error, std::abs(found[k] - right) / right);
    }
    return error;
  };
  for (const auto& run : peer)
    tell("numpy, batched bisection", run.at("tolerance"),
         1e6 * run.at("seconds").get<double>() / line.x.count, worst(run.at("found"), 1));
  const auto along = [&](const std::string& method, int step, auto&& margin) {
    for (const double tolerance : {1e-2, 1e-4, 1e-6, 1e-9}) {
      std::vector<double> found;
      const double start = core_seconds();
      for (int i = 0; i < line.x.count; i += step)
        found.push_back(line.boundary(i, tolerance, margin));
      const double us = 1e6 * (core_seconds() - start) / static_cast<double>(found.size());
      tell(method, tolerance, us, worst(found, step));
    }
  };
  along("measured on the loop (c)", 20, on_the_loop);
  along("resampled, eigenvalues (a)", 1, by_eigenvalues);
  along("resampled, Routh test", 1, by_routh);

  // The whole curve, wherever it goes: ends on the grid's lines, each against eigenvalues there.
  Axis across = line.x, up{0.0, 6000.0, 16};
  across.count = 16;
  for (const double tolerance : {1e-2, 1e-4, 1e-6, 1e-9}) {
    analysis::BoundaryOptions options;
    options.tolerance = tolerance;
    analysis::ThreadedRunner alone;
    constexpr int kTimes = 5;
    analysis::Boundary found;
    const double start = core_seconds();
    for (int k = 0; k < kTimes; ++k)
      found = analysis::stability_boundary(judge, line.scene, line.copies, across, line.other, up,
                                           alone, options);
    const double seconds = (core_seconds() - start) / kTimes;
    double error = 0.0;
    core::Scene edited = line.scene;
    for (const analysis::Segment& s : found.segments)
      for (const auto& [x, y] : {std::pair{s.x0, s.y0}, std::pair{s.x1, s.y1}}) {
        // Along x or y, whichever line of the grid the end is on: the nearer of the two zeros.
        double nearest = 1.0;
        for (const bool in_x : {true, false}) {
          const auto f = [&, x = x, y = y](double v) {
            line.copies.set(edited, in_x ? v : x);
            line.other.set(edited, in_x ? y : v);
            return by_eigenvalues(edited);
          };
          const double at = in_x ? x : y, a = at * (1.0 - 2.0 * tolerance),
                       b = at * (1.0 + 2.0 * tolerance), fa = f(a), fb = f(b);
          if ((fa > 0.0) == (fb > 0.0)) continue;
          const auto zero = analysis::bracket_zero(f, a, fa, b, fb, 1e-13);
          nearest = std::min(nearest, std::abs(0.5 * (zero.first + zero.second) / at - 1.0));
        }
        error = std::max(error, nearest);
      }
    tell("traced, whole boundary", tolerance,
         1e6 * seconds / static_cast<double>(found.segments.size()), error);
  }
  return out;
}

}  // namespace tandem::bench
