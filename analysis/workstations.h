#pragma once

#include <algorithm>
#include <utility>
#include <vector>

#include "analysis/workstation.h"
#include "core/network_model.h"
#include "core/scene.h"

/// A session cut into workstations and the signals between them: what resampling starts from.
namespace tandem::analysis {

/// One number from site to site: y = c x_from + the signals in use there, held at the other end,
/// where it pushes the coordinates by `push`. With `by_age` it pushes by y times the sample's age:
/// extrapolation.
struct Signal {
  int from = 0, to = 0;
  std::vector<double> push;  ///< over the coordinates at `to`
  std::vector<double> c;
  std::vector<std::pair<int, double>> add;  ///< signals into `from` (the server's reply), factors
  int delay = 0;                            ///< [ticks]
  bool by_age = false;
  double age_error = 0.0;  ///< of the age as reckoned [ticks]
  int first_past = 0;      ///< index of its value one period ago in the whole state
  int past = 0;            ///< how many past values are states
};

/// All workstations of a session and the signals between them. A signal carries a force along one
/// coordinate or spring, so that a packet in flight is one state of each and not a whole sample.
struct Workstations {
  int ticks = 1;      ///< N, of a packet period
  double tick = 0.0;  ///< T [s]
  int states = 0;     ///< of the whole: sites one after the other, then values in flight
  std::vector<Workstation> sites;
  std::vector<Signal> signals;

  /// Value of a signal `age` packet periods ago, as a row over the whole state.
  [[nodiscard]] std::vector<double> value(const Signal& signal, int age) const;
  /// How old [packet periods] the value of a signal is that acts at tick `k` of a period.
  [[nodiscard]] int age(const Signal& signal, int k) const {
    return signal.delay / ticks + (k < signal.delay % ticks ? 1 : 0);
  }
  /// The age at tick `k` of the sample that acts then, as the receiver reckons it [ticks].
  [[nodiscard]] double reckoned_age(const Signal& signal, int k) const {
    return std::max(0.0, age(signal, k) * ticks + k + signal.age_error);
  }
  /// What the value that acts at tick `k` is multiplied by: 1, or the age of its sample [s].
  [[nodiscard]] double factor(const Signal& signal, int k) const {
    return signal.by_age ? reckoned_age(signal, k) * tick : 1.0;
  }
};

/// Axis scenes and attached grasps in the plane for which why_not_resampled() is empty.
[[nodiscard]] Workstations workstations_of(const core::Scene& scene,
                                           const core::NetworkModel& network);

}  // namespace tandem::analysis
