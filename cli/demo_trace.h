#pragma once

#include <string>
#include <vector>

#include "analysis/experiments.h"
#include "cli/demo_script.h"
#include "core/scene.h"

namespace tandem::cli {

/// One site's part in a session, slot by slot: the copy of the first object it has, and the force
/// of the hands this site evaluates (its own user's on its own copy; at a server everyone's).
struct DemoTrace {
  struct Sample {
    bool ran = false;                         ///< the slot was not missed
    core::Vec3 position{0.0}, velocity{0.0};  ///< of the object
    core::Vec3 force{0.0};                    ///< of the hands on it [N]
    double angle = 0.0;                       ///< plane only [rad]
  };
  std::vector<Sample> slots;
};

/// From a node's recording, by stepping its law again; a missed slot repeats the one before.
/// A client has no object: its trace shows what the server told it, without force.
[[nodiscard]] DemoTrace trace_recording(const std::string& file, double seconds);

/// The same session in virtual time with its simulated hands, every packet one tick on its way, as
/// between nodes whose slots are due at the same instant. One trace a site.
[[nodiscard]] std::vector<DemoTrace> trace_in_virtual_time(const core::Scene& scene,
                                                           double seconds);

/// Where the hands' own targets lead, averaged over all fingers, along the carry, slot by slot [m].
using Command = std::vector<double>;
[[nodiscard]] Command scripted_command(const core::Scene& scene, double seconds);

/// Figures of the first carry. `traces` has one of each copy.
struct DemoFigures {
  double travel_measured = 0.0, travel_commanded = 0.0;  ///< peak to peak along the carry [m]
  /// Root mean square over the last three quarters of the carry, where the object moves faster than
  /// 5 mm/s: force of all hands along the carry less ground friction, and what it should be, the
  /// whole mass times the acceleration of the object as it moved (both by central differences over
  /// a packet period each way) [N].
  /// Not a number when it never did.
  double net_force_rms = 0.0, inertial_force_rms = 0.0;
  double gap_in_carry_max = 0.0;   ///< largest distance of two copies' centres [m]
  double gap_after_release = 0.0;  ///< at the end of the run [m]
};
[[nodiscard]] DemoFigures demo_figures(const core::Scene& scene, const ScriptTimes& times,
                                       const std::vector<const DemoTrace*>& traces,
                                       const Command& command);

/// Force and path at the packet rate, for CSV and picture.
[[nodiscard]] analysis::Table demo_table(const core::Scene& scene, const ScriptTimes& times,
                                         const std::vector<const DemoTrace*>& traces,
                                         const std::vector<std::string>& names,
                                         const Command& command);

}  // namespace tandem::cli
