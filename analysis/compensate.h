#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/network_model.h"
#include "core/scene.h"

/// Negative damping of an object's copies that gives back the drag of the packet rate (thesis
/// 6.1), and what it costs.
namespace tandem::analysis {

/// How a loop behaves as it is: what is felt and how far it is from unstable.
struct LoopReport {
  double radius = 0.0;        ///< all users hold, a packet period
  double radius_alone = 0.0;  ///< the worst of one user alone
  /// Force per velocity along each axis (x; x, y, rotation) for each user alone, by a direct solve.
  std::vector<std::vector<double>> drag;
  double stiffness_factor = 0.0;  ///< all stiffnesses may grow by this, all users and each alone
  double damping_factor = 0.0;    ///< all dampings
  bool stiffness_open = false;    ///< stable to the end of the scan, a factor of 20
  bool damping_open = false;
  std::optional<int>
      delay_ticks;  ///< of round trip borne beyond the present; empty: over 10 packets
  [[nodiscard]] bool stable() const { return radius < 1.0 && radius_alone < 1.0; }
};
[[nodiscard]] LoopReport report_loop(const core::Scene& scene, const core::NetworkModel& network,
                                     int object);

/// The compensator of one object along its linear axes, or in rotation.
struct Compensator {
  std::string field;  ///< object.NAME.compensation or .compensation_rotation
  /// Where net damping becomes zero or the loop unstable [N s/m, N m s/rad of each copy]:
  double cancels_now = 0.0;           ///< at this delay, the least of every user alone and all
  double cancels_undelayed = 0.0;     ///< the same without network delay
  double simplified_undelayed = 0.0;  ///< force on the copies themselves (Fig 6.3), no delay
  double value = 0.0;                 ///< what the rule gives
  std::string bound_by;
};

/// The safety rule of thesis 6.1: damping is calculated without network delay (n = 0), so that it
/// is underestimated and the net damping stays positive at any delay; in rotation from the
/// simplified model where that gives less, for it does not hang on where the fingers are. Corrected
/// by the reference analysis (4.4): what counts is not the felt damping but what each copy may get
/// before the net damping of any user alone is zero, at no delay and at this one, all users holding
/// too. Of the least of these all but the part `leave` is taken.
/// In a plane drag is a matrix D: slow motion must cost work, v . D v > 0, in every direction, for
/// a hand may hold the box straight while it moves. Exact: ends of the stable interval of the
/// compensation on the lifted map, common motions out. Throws std::domain_error where the scene has
/// no free motion or is unstable as it is.
[[nodiscard]] std::vector<Compensator> compensators(const core::Scene& scene,
                                                    const core::NetworkModel& network, int object,
                                                    double leave);

/// The scene with only this object, and its couplers.
[[nodiscard]] core::Scene with_one_object(core::Scene scene, int object);
/// With the compensators set.
[[nodiscard]] core::Scene compensated(core::Scene scene, int object,
                                      const std::vector<Compensator>& found);

}  // namespace tandem::analysis
