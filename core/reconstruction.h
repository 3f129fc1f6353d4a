#pragma once

#include "core/elementary.h"
#include "core/scene.h"

namespace tandem::core {

/// How far a remote sample is carried on: position by `time` seconds of its velocity, velocity by
/// `keep`. Hold is {0, 1}.
struct Advance {
  double time = 0.0;
  double keep = 1.0;
};

/// Age-stamped extrapolation with cap and decay of a held remote sample: up to the horizon A the
/// sample moves on with its velocity; beyond it the velocity decays with time constant tau, so the
/// position comes to rest at A + tau seconds of travel:
///   age_eff = age                            age < A
///           = A + tau (1 - e^-(age-A)/tau)   beyond, velocity times e^-(age-A)/tau
[[nodiscard]] inline Advance advance_by_age(const ReconstructionParameters& p,
                                            double age) noexcept {
  if (p.kind == ReconstructionKind::kHold || !(age > 0.0)) return {};
  if (age <= p.horizon) return {age, 1.0};
  const double keep = natural_exp(-(age - p.horizon) / p.decay);
  return {p.horizon + p.decay * (1.0 - keep), keep};
}

}  // namespace tandem::core
