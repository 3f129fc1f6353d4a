// 01 - One finger touches a wall, in one process and without hardware.
//
//   hand ──► finger ──│ wall │
//
// Shows:   a scene, the central loop with one local user, the simulated hand.
// Run:     ./build/release/examples/01_touch_a_wall
// You see: one line every tenth of a second, and at the end how far the finger sank in, which is
//          force over stiffness.

#include <cmath>
#include <cstdio>
#include <exception>

#include "arch_central/central_loop.h"
#include "core/axis_world.h"
#include "scene/load_scene.h"

int main() try {
  const tandem::core::Scene scene = tandem::scene::load_scene("wall_single");
  const tandem::core::WallParameters& wall = scene.walls.front();
  tandem::central::CentralLoop<tandem::core::AxisWorld> loop(scene);

  double position = 0.0, force = 0.0;
  std::printf("   t [s]   finger [mm]   force on it [N]\n");
  while (loop.time() < 3.0) {
    loop.tick();
    position = loop.hands().finger(0, 0).position();
    force = loop.output(0).forces[0];
    if (loop.slot() % 256 == 0)
      std::printf("%8.3f %13.3f %17.3f\n", loop.time(), 1e3 * position, force);
  }
  const double depth = (wall.point.x - position) * (wall.normal.x < 0.0 ? -1.0 : 1.0);
  std::printf("resting %.3f mm inside the wall; force / stiffness is %.3f mm\n", 1e3 * depth,
              1e3 * std::abs(force) / wall.gain.stiffness);
  return std::abs(depth - std::abs(force) / wall.gain.stiffness) < 1e-5 ? 0 : 1;
} catch (const std::exception& e) {
  std::fprintf(stderr, "%s\n", e.what());
  return 2;
}
