#include "node/stability_guard.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace tandem::node {

namespace {

/// Back inside only so much below the limit [ticks]: a delay at the limit is not told of again and
/// again.
constexpr double kHysteresis = 0.5;

}  // namespace

void DelayMedian::record(double now, double round_trip) {
  seen_.emplace_back(now, round_trip);
  while (seen_.front().first < now - kSpan) seen_.pop_front();
}

std::optional<double> DelayMedian::value() const {
  constexpr std::size_t kLeast = 10;
  if (seen_.size() < kLeast || seen_.back().first - seen_.front().first < 0.9 * kSpan) return {};
  std::vector<double> sorted;
  for (const auto& [when, delay] : seen_) sorted.push_back(delay);
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  return *middle;
}

StabilityGuard::Finding StabilityGuard::at_start() const {
  Finding out{prediction_.text, false};
  if (!prediction_.known || prediction_.largest_stable_ticks >= 0) return out;
  out.refuses = refuses_;
  out.text +=
      "\nthe scene is predicted to be unstable whatever the network does; " + prediction_.advice(0);
  return out;
}

bool StabilityGuard::stable_at(int ticks) {
  if (ticks <= prediction_.largest_stable_ticks) return true;
  const auto found = growth_.find(ticks);
  if (found != growth_.end()) return found->second < prediction_.grows_from;
  return (growth_[ticks] = prediction_.growth(ticks)) < prediction_.grows_from;
}

std::string StabilityGuard::said(double round_trip) const {
  return fmt::format("round trip {:.1f} ms (median of {:.0f} s): {:.1f} ticks of delay in the loop",
                     1e3 * round_trip, DelayMedian::kSpan, ticks(round_trip));
}

StabilityGuard::Finding StabilityGuard::look(double now, std::optional<double> round_trip) {
  if (!prediction_.known || prediction_.largest_stable_ticks < 0) return {};
  if (round_trip) median_.record(now, *round_trip);
  const std::optional<double> median = median_.value();
  if (!median || !round_trip) return {};
  const double measured = ticks(*median);
  const bool outside =
      outside_ ? !stable_at(std::max(0, static_cast<int>(std::lround(measured + kHysteresis))))
               : !stable_at(static_cast<int>(std::lround(measured)));
  if (!told_ && !outside) {
    told_ = true;
    const double left = prediction_.largest_stable_ticks + 0.5 - measured;
    return {
        said(*median) + (left >= 0.0 ? fmt::format("; {:.1f} more are borne{}", left,
                                                   prediction_.looked_no_further ? " at least" : "")
                                     : "; stable"),
        false};
  }
  if (outside == outside_) return {};
  outside_ = outside;
  told_ = true;
  if (!outside) return {said(*median) + "; back in the stable region", false};
  const int at = static_cast<int>(std::lround(measured));
  return {fmt::format("{}; predicted growth {:.4f} a packet period: unstable.\n{}", said(*median),
                      prediction_.growth(at), prediction_.advice(at)),
          refuses_};
}

}  // namespace tandem::node
