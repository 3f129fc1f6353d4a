#pragma once

#include <vector>

#include "analysis/matrix.h"
#include "core/network_model.h"
#include "core/scene.h"

/// A session cut into workstations and the signals between them: what resampling starts from.
namespace tandem::analysis {

/// A mass of one workstation.
struct Body {
  bool is_hand = false;
  int user = -1, finger = -1, object = -1;
  int state = 0;  ///< index of its position in the site; velocity follows; delayed forces after all
};

/// A workstation over one tick: x+ = a x + sum_b b_l u_l with the inputs of its links held.
struct Site {
  int user = -1;  ///< whose copies these are; -1: the server
  std::vector<Body> bodies;
  Matrix a;         ///< one tick
  Matrix coupled;   ///< column b: change of the state by 1 N of coupler force on body b
  Matrix external;  ///< column b: by 1 N applied from outside
  int offset = 0;   ///< of its states in the whole

  [[nodiscard]] int body_of_hand(int u, int f) const {
    for (std::size_t i = 0; i < bodies.size(); ++i)
      if (bodies[i].is_hand && bodies[i].user == u && bodies[i].finger == f)
        return static_cast<int>(i);
    return -1;
  }
  [[nodiscard]] int body_of_object(int o) const {
    for (std::size_t i = 0; i < bodies.size(); ++i)
      if (!bodies[i].is_hand && bodies[i].object == o) return static_cast<int>(i);
    return -1;
  }
};

/// One signal from site to site: y = c x_from - sum of the signals in use there, held at the other
/// end, where it acts as a force on one body.
struct Signal {
  int from = 0, to = 0, body = 0;
  std::vector<double> c;
  std::vector<int> subtract;  ///< numbers of signals into `from` (the server's reply)
  int delay = 0;              ///< [ticks]
  int first_past = 0;         ///< index of its value one period ago in the whole state
  int past = 0;               ///< how many past values are states
};

/// All workstations of a session and the signals between them. A signal carries a force, one number
/// a coupled object, so that a packet in flight is one state and not four.
struct Workstations {
  int ticks = 1;      ///< N, of a packet period
  double tick = 0.0;  ///< T [s]
  int states = 0;     ///< of the whole: sites one after the other, then values in flight
  std::vector<Site> sites;
  std::vector<Signal> signals;

  /// Value of a signal `age` packet periods ago, as a row over the whole state.
  [[nodiscard]] std::vector<double> value(const Signal& signal, int age) const;
  /// How old [packet periods] the value of a signal is that acts at tick `k` of a period.
  [[nodiscard]] int age(const Signal& signal, int k) const {
    return signal.delay / ticks + (k < signal.delay % ticks ? 1 : 0);
  }
};

/// Axis scenes, linear, for which why_not_resampled() is empty.
[[nodiscard]] Workstations workstations_of(const core::Scene& scene,
                                           const core::NetworkModel& network);

}  // namespace tandem::analysis
