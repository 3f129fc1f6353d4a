#pragma once

#include <string>
#include <vector>

#include "bench/error_run.h"

namespace tandem::bench {

/// One way to step a case: a value of the scene's field `integrator`, or a scheme tried here only.
struct Scheme {
  std::string name;
  bool is_default = false;  ///< what a scene of this kind uses if it says nothing
  bool in_tandem = true;    ///< false: a candidate, here to show what it would buy
};

/// The schemes that exist for a case.
[[nodiscard]] std::vector<Scheme> schemes_of(const ErrorPoint& point);

/// Runs a case with Tandem's laws in their loop, hands and all, as `tandem simulate` does.
/// Candidates run bare, without law or hand; "bare ..." rows do the same with Tandem's integrators.
[[nodiscard]] ErrorRun run_tandem(const ErrorPoint& point, const Scheme& scheme, int hz);

}  // namespace tandem::bench
