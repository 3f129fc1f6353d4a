#pragma once

#include "core/scene.h"

namespace tandem::cli {

/// When a session's hands do what, read from the scene's script.
struct ScriptTimes {
  double length = 0.0;        ///< of one round, to the last keyframe [s]
  bool carries = false;       ///< there is a sine along which the object is carried
  double carry_start = 0.0;   ///< [s]
  double carry_end = 0.0;     ///< [s]
  core::Vec3 direction{0.0};  ///< of the carry, unit
};
[[nodiscard]] ScriptTimes script_times(const core::Scene& scene);

/// The scene with its hands' script fitted to a run of so many seconds:
///   shorter than the script   everything in it is that much faster, so that it still ends released
///   longer                    whole rounds of it, as many as fit and as a finger's path can hold
///                             (32 keyframes, 4 sines: three rounds of the shipped scenes), then
///                             rest
/// Returns the number of rounds. Throws std::invalid_argument for less than 5 s: too fast to hold.
int fit_script(core::Scene& scene, double seconds);

/// For hands led by a recording: the script grasps, presses nothing, and lets go in the end; its
/// motion along the carry is taken out, and what comes after the carry is moved so that the script
/// ends with the run.
void leave_carry_to_recording(core::Scene& scene, double seconds);

}  // namespace tandem::cli
