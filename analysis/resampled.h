#pragma once

#include <string>
#include <vector>

#include "analysis/lifted.h"

namespace tandem::analysis {

/// Why subsystem resampling does not apply to a scene; empty if it does. What it does not do
/// (extrapolation beyond its horizon, computation delay across the network, packet phases) the
/// measured map does.
[[nodiscard]] std::string why_not_resampled(const core::Scene& scene,
                                            const core::NetworkModel& network);

/// The map over a packet period by subsystem resampling (thesis 4.1-4.11): each workstation is
/// discretised at the tick with its network inputs held (or carried on, where they are
/// extrapolated), over the packet period by recursive sums (never by (A - I)^-1, which free motion
/// makes singular), and joined to the others through delays of any number of ticks. Links carry
/// forces, one number a coordinate of a coupled object, so that a packet in flight is one state and
/// not four. Axis scenes and attached grasps in the plane, where it is their exact linearisation.
/// For more ticks a packet than doubles can hold, the map is scaled (LiftedSystem::scale).
/// Ports: fingers user by user, then object copies, named "object@user"; one a coordinate.
/// Throws std::domain_error with why_not_resampled where that is not empty.
[[nodiscard]] LiftedSystem resampled_system(const core::Scene& scene,
                                            const core::NetworkModel& network);

/// Resampled where that applies, else measured on the running loop.
[[nodiscard]] LiftedSystem lifted_system(const core::Scene& scene,
                                         const core::NetworkModel& network);

}  // namespace tandem::analysis
