#pragma once

#include <vector>

#include "core/components.h"

namespace tandem::analysis {

/// What a common motion of everything does to a state.
enum class StateKind { kPosition, kVelocity, kAngle, kAngularVelocity, kOrientation, kForce };

/// One number of a loop's state, where it lives.
struct StateEntry {
  double* value = nullptr;
  StateKind kind = StateKind::kPosition;
  int component = 0;  ///< x, y, z
};

/// Collects the states of a loop in the loop's own order. The pointers hold until the next tick.
class StateCollector {
 public:
  explicit StateCollector(std::vector<StateEntry>& out) : out_(&out) {}

  template <typename V>
  void position(V& x) {
    all(x, StateKind::kPosition);
  }
  template <typename V>
  void velocity(V& x) {
    all(x, StateKind::kVelocity);
  }
  template <typename V>
  void force(V& x) {
    all(x, StateKind::kForce);
  }
  void angle(double& x) { out_->push_back({&x, StateKind::kAngle, 0}); }
  template <typename V>
  void angular_velocity(V& x) {
    all(x, StateKind::kAngularVelocity);
  }
  void orientation(core::Quat& q) {
    for (double* part : {&q.w, &q.x, &q.y, &q.z})
      out_->push_back({part, StateKind::kOrientation, 0});
  }
  void wrench(double& force) { this->force(force); }
  template <typename Wrench>
  void wrench(Wrench& w) {
    this->force(w.force);
    all(w.torque, StateKind::kForce);
  }

 private:
  template <typename V>
  void all(V& x, StateKind kind) {
    for (int i = 0; i < core::kComponents<V>; ++i)
      out_->push_back({&core::component(x, i), kind, i});
  }

  std::vector<StateEntry>* out_;
};

template <typename Loop>
[[nodiscard]] std::vector<StateEntry> states_of(Loop& loop) {
  std::vector<StateEntry> entries;
  loop.visit_state(StateCollector(entries));
  return entries;
}

}  // namespace tandem::analysis
