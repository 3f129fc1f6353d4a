#pragma once

#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "core/scene.h"

/// What a node knows of the stability of its scene, and what it does when the network leaves it. A
/// node knows no analysis: who starts it hands the prediction in.
namespace tandem::node {

/// What was predicted for a scene. Delays are round trips, in ticks of the force loop.
struct StabilityPrediction {
  std::string text;                         ///< for people, printed at the start; lines
  bool known = false;                       ///< false: the scene has no prediction, text says why
  int largest_stable_ticks = -1;            ///< -1: not even without delay
  bool looked_no_further = false;           ///< it was stable as far as was looked
  double grows_from = 1.0;                  ///< a growth of this and more is unstable
  std::function<double(int ticks)> growth;  ///< a packet period; may take a second
  std::function<std::string(int ticks)> advice;  ///< which gain to lower, and to what; the same
};

/// Median of the round trips of the last second, so that one late packet does nothing.
class DelayMedian {
 public:
  static constexpr double kSpan = 1.0;  ///< [s]
  void record(double now, double round_trip);
  /// Empty until it has seen nearly a whole span.
  [[nodiscard]] std::optional<double> value() const;

 private:
  std::deque<std::pair<double, double>> seen_;
};

/// Compares the measured delay with the prediction.
class StabilityGuard {
 public:
  StabilityGuard(StabilityPrediction prediction, bool refuses, double tick)
      : prediction_(std::move(prediction)), refuses_(refuses), tick_(tick) {}

  struct Finding {
    std::string text;      ///< for people; empty: nothing new
    bool refuses = false;  ///< the network coupling has to go
  };
  /// What there is to say before anything is measured.
  [[nodiscard]] Finding at_start() const;
  /// `round_trip` [s]: the longest of all peers at `now` [s]; not given: no peer is measured.
  [[nodiscard]] Finding look(double now, std::optional<double> round_trip);

  /// Delay in the loop for a round trip on the wire: on each way a packet waits half a tick on
  /// average until it is used, so a tick more [ticks].
  [[nodiscard]] double ticks(double round_trip) const { return round_trip / tick_ + 1.0; }

 private:
  [[nodiscard]] bool stable_at(int ticks);
  [[nodiscard]] std::string said(double round_trip) const;

  StabilityPrediction prediction_;
  bool refuses_;
  double tick_;
  DelayMedian median_;
  std::map<int, double> growth_;
  bool told_ = false, outside_ = false;
};

/// Makes the guard of a session's scene; may return none.
using GuardMaker = std::function<std::unique_ptr<StabilityGuard>(const core::Scene&)>;

}  // namespace tandem::node
