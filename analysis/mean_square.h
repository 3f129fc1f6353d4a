#pragma once

#include <string>
#include <vector>

#include "analysis/matrix.h"

namespace tandem::analysis {

/// A linear system x+ = A x whose matrix hops as a Markov chain: in mode `from` the map `map` is
/// used with `probability`, and mode `to` follows. Independent draws are one mode with several
/// jumps. Modes may have different numbers of states; probabilities out of a mode add up to one.
struct JumpSystem {
  struct Jump {
    int from = 0, to = 0, map = 0;
    double probability = 0.0;
  };
  std::vector<int> states;  ///< of each mode
  std::vector<Matrix> maps;
  std::vector<Jump> jumps;
  int period = 1;  ///< the chain comes back to a mode only after multiples of this many jumps
};

struct SecondMoment {
  double radius = 0.0;  ///< growth of E[x x'] per jump; below 1: stable in the mean square
  int size = 0;         ///< of the second moment: n (n + 1) / 2 numbers a mode
  bool dense = false;   ///< by eigenvalues of the Kronecker matrix; else by applying it
  bool converged = true;
  int iterations = 0;
};

/// Spectral radius of the second moment (Costa, Fragoso, Marques: Discrete-Time Markov Jump Linear
/// Systems, theorem 3.9):  X_j+ = sum over jumps i -> j of p A X_i A'.
/// Symmetric, so half of E[A (x) A] is carried: n (n + 1) / 2 instead of n^2. Small ones by their
/// eigenvalues; others by applying the map to positive definite matrices, which it keeps positive,
/// until the growth is steady to 1e-10.
[[nodiscard]] SecondMoment second_moment(const JumpSystem& system);

/// E[x x'] of every mode after one jump, from that before (symmetric, times the mode's chance).
[[nodiscard]] std::vector<Matrix> advance_second_moment(const JumpSystem& system,
                                                        const std::vector<Matrix>& before);

}  // namespace tandem::analysis
