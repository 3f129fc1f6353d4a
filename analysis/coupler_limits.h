#pragma once

#include <vector>

#include "core/scene.h"

/// The exact answers beside the passivity bounds of bounds.h: one coupler between a device and a
/// wall or an object, on the lifted map of a scene of just these.
namespace tandem::analysis {

/// One line of a user's own coupler: what the bounds ask of a scene.
struct LocalCoupler {
  double stiffness = 0.0, damping = 0.0;  ///< K [N/m], B [N s/m]
  double hand_mass = 0.1;                 ///< hand and device [kg]
  double object_mass = 0.4;               ///< [kg]
  double device_damping = 0.0;            ///< b of the mechanism, to the ground [N s/m]
  double device_friction = 0.0;           ///< Coulomb [N]
  double encoder_step = 0.0;              ///< [m]
  double T = 1.0 / 1024.0;                ///< [s]
  int latency_ticks = 0;
  core::Integrator integrator = core::Integrator::kZeroOrderHold;
};

/// What may hold a device: mass, spring and damper to the ground, all passive.
struct PassiveHand {
  double mass = 0.0;       ///< hand and device [kg]
  double stiffness = 0.0;  ///< [N/m]
  double damping = 0.0;    ///< beside the device's [N s/m]
};

/// 10 g to 10 kg, free to 30 kN/m, 0 to 100 N s/m: the lightest and the most rigid grip.
[[nodiscard]] std::vector<PassiveHand> sampled_hands();

/// End of the stable interval of wall springs that begins at zero [N/m], this hand pressing a
/// bilateral wall K + B; 0 where there is none, infinite beyond 10^8.
[[nodiscard]] double stable_wall_stiffness(const LocalCoupler& c, const PassiveHand& hand);
/// The same of the coupler between this hand and a free object.
[[nodiscard]] double stable_coupler_stiffness(const LocalCoupler& c, const PassiveHand& hand);

/// The least over sampled_hands(): an upper limit of what is stable in every passive hand.
struct WorstHand {
  double stiffness = 0.0;
  PassiveHand hand;
};
[[nodiscard]] WorstHand worst_wall_stiffness(const LocalCoupler& c);
/// And over objects of 30 g to 300 kg and one that is held fast.
[[nodiscard]] WorstHand worst_coupler_stiffness(LocalCoupler c);

}  // namespace tandem::analysis
