#pragma once

#include "core/scene.h"

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

/// Hand `user` is led slowly, 5 mm at 0.5 Hz, by a stiff muscle (20 kN/m); all others are held by
/// such muscles where they are; axis.
[[nodiscard]] core::Scene pressed(const core::Scene& scene, int user);

/// Hand `user` is moved by 5 mm within 20 ms at kStepStart by a stiff muscle, others held; axis.
inline constexpr double kStepStart = 1.0;
/// From when on the hand moves [m] and the other feels it [N]: as little as numbers without noise
/// allow, or the force of the motion's start would be there before the motion is seen.
inline constexpr double kStepMotion = 1e-6, kStepForce = 1e-4;
[[nodiscard]] core::Scene stepped(const core::Scene& scene, int user);

}  // namespace tandem::harness
