#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "core/network_model.h"
#include "core/scene.h"

namespace tandem::python {

/// What a session did, one row every `every` ticks, flat, row by row.
struct Trajectory {
  std::size_t users = 0, objects = 0;
  std::size_t pose_width =
      0;  ///< axis 1: x; plane 3: x, y, angle; space 7: x, y, z, qw, qx, qy, qz
  std::size_t components = 0;           ///< of positions and forces: 1, 2 or 3
  std::vector<std::string> fingers;     ///< "user.finger", user by user
  std::vector<double> time;             ///< of the tick's end [s]
  std::vector<double> poses;            ///< time x users x objects x pose_width [m], [rad]
  std::vector<double> positions;        ///< time x fingers x components [m]
  std::vector<double> forces;           ///< on the fingers, time x fingers x components [N]
  std::int64_t sent = 0, accepted = 0;  ///< packets
};

/// Runs the session in virtual time with the laws and simulated hands of the scene. `go_on` is
/// asked every 1024 ticks; false ends the run there.
[[nodiscard]] Trajectory run_session(const core::Scene& scene, const core::NetworkModel& network,
                                     double seconds, int every, const std::function<bool()>& go_on);

}  // namespace tandem::python
