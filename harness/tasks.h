#pragma once

#include "core/scene.h"
#include "harness/measures.h"

/// What people do in a session that something is measured of, as edits to the scene's hands: nodes
/// run them as loops do. Scenes in the plane keep their own hands where that is said.
namespace tandem::harness {

/// Free hands, each pushed once back and forth (a full sine of kKickHz, 1 N, one user after the
/// other from kKickStart): all modes are excited, nothing is put in after. Stability is judged of
/// it. In the plane: the linearised grasp (contacts attached), pushed along x and y.
inline constexpr double kKickStart = 0.25, kKickHz = 10.0;
[[nodiscard]] core::Scene kicked(const core::Scene& scene);

/// One hand alone, pushed along x by `force` [N] from the start; axis scenes.
[[nodiscard]] core::Scene pushed(const core::Scene& scene, int user, double force);

/// The first user leads along 0.05 sin(2 t) m by a muscle spring of 100 N/m and 2 N s/m, the others
/// hold back with the same about where they are; axis. In the plane the scene's own hands carry.
[[nodiscard]] core::Scene carried(const core::Scene& scene);

/// Two touches, every hand in the hold of a stiff muscle (20 kN/m); axis. The first user's hand is
/// moved by 5 mm within 20 ms at kStepStart: how long until another feels it. From kPressStart on
/// hand `user` is led slowly, 5 mm up and down in kPressPeriod: what stiffness it feels in the last
/// of two periods, when the session ends at kTouchSeconds.
inline constexpr double kStepStart = 0.5, kPressStart = 1.0, kPressPeriod = 2.0,
                        kTouchSeconds = 5.0;
/// From when on the hand moves [m] and the other feels it [N]: as little as numbers without noise
/// allow, or the force of the motion's start would be there before the motion is seen.
inline constexpr double kStepMotion = 1e-6, kStepForce = 1e-4;
[[nodiscard]] core::Scene touched(const core::Scene& scene, int user);
/// Fills rendered_stiffness and motion_to_force from such a session; not if it has blown up.
void measure_touch(Trajectory session, int user, Measures& measures);

}  // namespace tandem::harness
