#pragma once

#include <array>
#include <optional>

#include "core/network_model.h"
#include "core/scene.h"

namespace tandem::analysis {

/// How far from the boundary a scene is.
struct SitesMargin {
  /// Positive: stable; negative: not; at least -1 and at most 1. Its crossing of zero is smooth in
  /// the gains. Below about 1e-9 its sign should be checked.
  double margin = 1.0;
  /// What may be zero at the boundary, each smooth there and positive inside, of any scale: a pair
  /// of roots on the circle, one at z = 1, one at z = -1; of two polynomials where there are two.
  std::array<double, 6> critical{1.0, 1.0, 1.0, 1.0, 1.0, 1.0};
};

/// Where one object joins two workstations, each feels the other through one number: the force of
/// the other's couplers on its body. Then the characteristic polynomial over a packet period is
///   z^d p_1(z) p_2(z) - q_1(z) q_2(z),     q_i / p_i: from force in to force out of workstation i,
/// of degree 8 + d (distributed) or 6 + d (central), and stability is a Routh test of it: some
/// hundred multiplications instead of an eigenvalue iteration. Built in w = z - 1, where free
/// motion is w = 0 exactly and divided out; equal workstations and even d split it in two halves.
class TwoSites {
 public:
  /// Empty where the scene is not of this form: more users, fingers or objects, delays that are not
  /// whole packets, springs or dampers of the hands, extrapolation, computation delay.
  [[nodiscard]] static std::optional<TwoSites> of(const core::Scene& scene,
                                                  const core::NetworkModel& network);

  /// The scene may differ from the one given to `of` in gains, masses and compensation only.
  [[nodiscard]] SitesMargin margin(const core::Scene& scene) const noexcept;

 private:
  struct Coupler {
    int index = -1;  ///< in scene.couplers; -1: none
  };
  bool central_ = false, split_ = false, walls_ = false;
  int d_ = 0, N_ = 1;
  int local_ = 0, remote_ = 1;
  double T_ = 0.0;
  Coupler hand_[2][2];  ///< [copy][user]; central: [0][user]
  Coupler object_[2];   ///< [copy]
};

}  // namespace tandem::analysis
