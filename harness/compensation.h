#pragma once

#include "core/scene.h"
#include "harness/condition.h"

namespace tandem::harness {

/// What is left of the drag that hold has, where it is compensated.
inline constexpr double kDragLeft = 0.05;

/// Negative damping of each copy that leaves kDragLeft of the predicted drag of one hand alone, at
/// that network (thesis 6.2.3: -3 N s/m at n = 1 with Table 6.1 leaves 5 % too). 0 where there is
/// no drag or the analysis does not apply [N s/m].
[[nodiscard]] double tuned_compensation(core::Scene scene, const LinkConditions& network);

}  // namespace tandem::harness
