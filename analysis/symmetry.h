#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "analysis/state_vector.h"

namespace tandem::analysis {

/// A direction in state space that the loop must carry to itself: everything moved along one axis,
/// or, in a plane, everything turned about the origin. An eigenvector of eigenvalue one that says
/// nothing about stability; it is removed before judging.
struct Symmetry {
  std::string name;
  std::vector<double> direction;  ///< one number a state
  std::size_t pivot = 0;          ///< state whose value measures the motion, direction[pivot] = 1
};

/// Subtracts the motion along `symmetry` from the deviation `d` exactly: d -= (d[pivot]) t.
inline void remove(const Symmetry& symmetry, std::vector<double>& d) {
  const double amount = d[symmetry.pivot];
  for (std::size_t i = 0; i < d.size(); ++i) d[i] -= amount * symmetry.direction[i];
}

/// The symmetries a loop at rest in `reference` could have: translation along each axis it has,
/// rotation about z if it has angles. Rotation comes first: removing it disturbs no translation.
[[nodiscard]] inline std::vector<Symmetry> candidate_symmetries(
    const std::vector<StateEntry>& entries, const std::vector<double>& reference) {
  std::vector<Symmetry> found;
  for (std::size_t i = 0; i < entries.size() && found.empty(); ++i) {
    if (entries[i].kind != StateKind::kAngle) continue;
    Symmetry turn{"rotation", std::vector<double>(entries.size(), 0.0), i};
    for (std::size_t j = 0; j < entries.size(); ++j) {
      if (entries[j].kind == StateKind::kAngle) turn.direction[j] = 1.0;
      if (entries[j].kind != StateKind::kPosition) continue;
      // x and y of one point stand side by side.
      turn.direction[j] = entries[j].component == 0 ? -reference[j + 1] : reference[j - 1];
    }
    found.push_back(turn);
  }
  for (int axis = 0; axis < 3; ++axis) {
    Symmetry move{std::string("translation ") + "xyz"[axis],
                  std::vector<double>(entries.size(), 0.0), entries.size()};
    for (std::size_t i = 0; i < entries.size(); ++i) {
      if (entries[i].kind != StateKind::kPosition || entries[i].component != axis) continue;
      move.direction[i] = 1.0;
      if (move.pivot == entries.size()) move.pivot = i;
    }
    if (move.pivot != entries.size()) found.push_back(move);
  }
  return found;
}

}  // namespace tandem::analysis
