#pragma once

#include <cmath>

#include "core/components.h"
#include "core/vec.h"

/// The faces of a box of half lengths `reach` about its own origin, in the plane and in space: face
/// 2 i is the one at +reach of axis i, 2 i + 1 that at -reach.
namespace tandem::core {

/// The nearest face, for a finger that is met inside without a past.
template <typename Vector>
[[nodiscard]] inline int nearest_face(const Vector& reach, const Vector& p_B) noexcept {
  int axis = 0;
  double least = reach[0] - std::fabs(p_B[0]);
  for (int i = 1; i < kComponents<Vector>; ++i) {
    const double depth = reach[i] - std::fabs(p_B[i]);
    if (depth < least) least = depth, axis = i;
  }
  return 2 * axis + (p_B[axis] < 0.0 ? 1 : 0);
}

/// The face through which the straight way from `from` to `to` enters, or -1. `from` is outside. A
/// way that enters is caught even when it ends beyond the opposite face (thin box, fast finger);
/// one that only clips a corner or an edge and ends beside the entered face is not.
template <typename Vector>
[[nodiscard]] inline int entered_face(const Vector& reach, const Vector& from,
                                      const Vector& to) noexcept {
  int face = -1;
  double entry = -1.0;
  for (int axis = 0; axis < kComponents<Vector>; ++axis) {
    const double a = from[axis], b = to[axis], h = reach[axis];
    if (std::fabs(a) < h) continue;  // between the two faces of this axis already
    const bool negative = a < 0.0;
    const double outside = std::fabs(a) - h;
    const double progress = negative ? b - a : a - b;
    if (!(progress > outside)) return -1;  // does not reach this slab at all
    const double when = outside / progress;
    if (when > entry) {
      entry = when;
      face = 2 * axis + (negative ? 1 : 0);
    }
  }
  if (face < 0) return -1;
  for (int axis = 0; axis < kComponents<Vector>; ++axis) {
    if (axis == face >> 1) continue;
    const double across = from[axis] + (to[axis] - from[axis]) * entry;
    if (!(std::fabs(across) <= reach[axis]) || !(std::fabs(to[axis]) < reach[axis])) return -1;
  }
  return face;
}

}  // namespace tandem::core
