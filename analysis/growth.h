#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "analysis/symmetry.h"
#include "core/network_model.h"
#include "core/random.h"
#include "core/scene.h"

namespace tandem::analysis {

struct GrowthOptions {
  int periods = 12000;
  int fit_from = 6000;
  std::uint64_t seed = 1;
  /// Size of the deviation from rest. 1 where the loop is linear; small (1e-6) where it is linear
  /// only near rest, as a planar loop with attached couplers is.
  double amplitude = 1.0;
};

inline constexpr int kLeastRepeats = 40, kMostPackets = 20000;

namespace detail {

/// Least-squares slope of y over x, point by point (Welford).
class RunningSlope {
 public:
  void add(double x, double y) noexcept {
    n_ += 1.0;
    const double dx = x - mean_x_;
    mean_x_ += dx / n_;
    mean_y_ += (y - mean_y_) / n_;
    sxx_ += dx * (x - mean_x_);
    sxy_ += dx * (y - mean_y_);
  }
  [[nodiscard]] double value() const noexcept { return sxy_ / sxx_; }

 private:
  double n_ = 0.0, mean_x_ = 0.0, mean_y_ = 0.0, sxx_ = 0.0, sxy_ = 0.0;
};

}  // namespace detail

/// What measure_growth makes of a free drift x = v t that has not been taken out: exp of the
/// least-squares slope of ln t over the fitted periods; a drift that starts from somewhere grows
/// less. Slower growth than this cannot be told from it.
[[nodiscard]] inline double drift_growth(const GrowthOptions& options) {
  detail::RunningSlope slope;
  for (int t = options.fit_from; t <= options.periods; ++t)
    slope.add(t, std::log(static_cast<double>(t > 0 ? t : 1)));
  return std::exp(slope.value());
}

struct Growth {
  /// Factor by which a deviation grows in a packet period; infinite where one period takes a
  /// deviation of norm one beyond all numbers.
  double per_packet = 0.0;
  int states = 0;                    ///< packets in flight included
  std::vector<std::string> removed;  ///< symmetries found and subtracted
};

namespace detail {

/// Packets in flight are states: lost, doubled or late ones change their number.
inline void demand_same_states(std::size_t found, std::size_t expected) {
  if (found != expected)
    throw std::invalid_argument(
        "growth: the number of states changes from period to period; a network with jitter, loss "
        "or duplicates has no growth per packet");
}

template <typename Loop>
void set_deviation(Loop& loop, const std::vector<double>& reference, const std::vector<double>& d,
                   double amplitude) {
  auto entries = states_of(loop);
  demand_same_states(entries.size(), reference.size());
  for (std::size_t i = 0; i < entries.size(); ++i)
    *entries[i].value = reference[i] + amplitude * d[i];
}

template <typename Loop>
void get_deviation(Loop& loop, const std::vector<double>& reference, std::vector<double>& d,
                   double amplitude) {
  const auto entries = states_of(loop);
  demand_same_states(entries.size(), reference.size());
  for (std::size_t i = 0; i < entries.size(); ++i)
    d[i] = (*entries[i].value - reference[i]) / amplitude;
}

/// Euclidean norm, also where squares leave the range of numbers; infinite if an entry is not
/// finite.
[[nodiscard]] inline double norm_of(const std::vector<double>& d) {
  double sum = 0.0, largest = 0.0;
  for (const double x : d) {
    if (!std::isfinite(x)) return std::numeric_limits<double>::infinity();
    sum += x * x;
    largest = std::fmax(largest, std::fabs(x));
  }
  if ((sum > 1e-290 && sum < 1e290) || largest == 0.0) return std::sqrt(sum);
  sum = 0.0;
  for (const double x : d) sum += (x / largest) * (x / largest);
  return largest * std::sqrt(sum);
}

}  // namespace detail

/// The symmetries among the candidates that the loop really keeps over one packet period; a wall
/// or a spring to the ground breaks them, and then nothing is removed.
template <typename Loop>
[[nodiscard]] std::vector<Symmetry> kept_symmetries(const Loop& at_rest,
                                                    const std::vector<double>& reference,
                                                    double amplitude) {
  Loop probe = at_rest;
  const auto entries = states_of(probe);
  std::vector<Symmetry> kept;
  for (Symmetry& s : candidate_symmetries(entries, reference)) {
    Loop moved = at_rest;
    detail::set_deviation(moved, reference, s.direction, amplitude);
    moved.advance_repeat();
    std::vector<double> after(entries.size());
    detail::get_deviation(moved, reference, after, amplitude);
    for (std::size_t i = 0; i < after.size(); ++i) after[i] -= s.direction[i];
    if (detail::norm_of(after) < 1e-4 * detail::norm_of(s.direction)) kept.push_back(s);
  }
  return kept;
}

/// Uniform motion along an axis whose translation is kept, if the loop keeps it too: a single user,
/// or packets in every tick. The free drift x = v t is then a second eigenvalue one, defective, and
/// says as little about stability as the translation does. Where held samples lag, the motion is
/// braked, and nothing is found.
template <typename Loop>
[[nodiscard]] std::optional<Symmetry> kept_drift(const Loop& at_rest,
                                                 const std::vector<double>& reference,
                                                 double amplitude, const Symmetry& translation) {
  constexpr double kKept = 1e-10;  // far below any drag that shows, far above rounding
  Loop loop = at_rest;
  const auto entries = states_of(loop);
  const int axis = entries[translation.pivot].component;
  Symmetry drift{"uniform motion " + translation.name.substr(translation.name.size() - 1),
                 std::vector<double>(entries.size(), 0.0), entries.size()};
  for (std::size_t i = 0; i < entries.size(); ++i) {
    if (entries[i].kind != StateKind::kVelocity || entries[i].component != axis) continue;
    drift.direction[i] = 1.0;
    if (drift.pivot == entries.size()) drift.pivot = i;
  }
  if (drift.pivot == entries.size()) return std::nullopt;
  const auto advance = [&](std::vector<double> d) {
    detail::set_deviation(loop, reference, d, amplitude);
    loop.advance_repeat();
    detail::get_deviation(loop, reference, d, amplitude);
    remove(translation, d);
    return d;
  };
  drift.direction = advance(drift.direction);  // held samples now lag as they do in motion
  std::vector<double> change = advance(drift.direction);
  for (std::size_t i = 0; i < change.size(); ++i) change[i] -= drift.direction[i];
  const bool kept = detail::norm_of(change) < kKept * detail::norm_of(drift.direction) &&
                    std::abs(drift.direction[drift.pivot] - 1.0) < kKept;
  return kept ? std::optional(std::move(drift)) : std::nullopt;
}

/// How fast a deviation from rest grows, measured on the running loop: a seeded random deviation of
/// every state, packets in flight included; after each packet period the common motions are
/// subtracted and the rest is scaled to norm one, the logarithm of the scale summed up. The answer
/// is exp of the least-squares slope of that sum over periods fit_from .. periods. Where the ratio
/// of the rates is not whole, this is done after each repeat of the packet ticks, and the answer is
/// the geometric mean over the packets in it.
/// Throws std::invalid_argument where packets have fates of their own (jitter, loss), and where the
/// packet ticks repeat only after more than kMostPackets.
/// `loop` must be at rest; it is run 64 periods first so that its links are full.
template <typename Loop>
[[nodiscard]] Growth measure_growth(Loop loop, const GrowthOptions& options) {
  if (loop.packet_slots().packets > kMostPackets)
    throw std::invalid_argument(
        "growth: packet ticks repeat only after " + std::to_string(loop.packet_slots().packets) +
        " packets, which is too long to measure over (at most " + std::to_string(kMostPackets) +
        "); choose rates with a simpler ratio");
  for (int i = 0; i < 64; ++i) loop.advance_packet_period();
  std::vector<double> reference;
  for (const StateEntry& e : states_of(loop)) reference.push_back(*e.value);
  auto symmetries = kept_symmetries(loop, reference, options.amplitude);
  std::vector<Symmetry> drifts;
  for (const Symmetry& s : symmetries)
    if (s.name.starts_with("translation"))
      if (auto drift = kept_drift(loop, reference, options.amplitude, s))
        drifts.push_back(std::move(*drift));
  // Drifts first: taking one out changes positions, taking a translation out no velocity.
  symmetries.insert(symmetries.begin(), drifts.begin(), drifts.end());

  core::Random random(options.seed);
  std::vector<double> d(reference.size());
  for (double& x : d) x = random.normal();

  Growth growth;
  growth.states = static_cast<int>(d.size());
  for (const Symmetry& s : symmetries) growth.removed.push_back(s.name);
  double sum = 0.0;
  detail::RunningSlope slope;
  const int packets = static_cast<int>(loop.packet_slots().packets);
  const int periods =
      packets == 1 ? options.periods : std::max(options.periods / packets, kLeastRepeats);
  const int fit_from = packets == 1 ? options.fit_from : periods / 2;
  for (int period = 0; period <= periods; ++period) {
    for (const Symmetry& s : symmetries) remove(s, d);
    const double norm = detail::norm_of(d);
    if (norm == 0.0) return growth;  // everything died out: growth 0
    if (!std::isfinite(norm)) {
      growth.per_packet = std::numeric_limits<double>::infinity();
      return growth;
    }
    sum += std::log(norm);
    for (double& x : d) x /= norm;
    if (period >= fit_from) slope.add(period, sum);
    detail::set_deviation(loop, reference, d, options.amplitude);
    loop.advance_repeat();
    detail::get_deviation(loop, reference, d, options.amplitude);
  }
  growth.per_packet = std::exp(slope.value() / packets);
  return growth;
}

/// The same for the loop that a scene declares over a network.
[[nodiscard]] Growth measure_growth(const core::Scene& scene, const core::NetworkModel& network,
                                    const GrowthOptions& options = {});

}  // namespace tandem::analysis
