#pragma once

#include <CLI/CLI.hpp>

namespace tandem::bench {

/// `tandem bench tick [--json FILE]`: one planar tick of a replica (4 fingers on a box, 2 walls
/// with 4 corners each, ground friction, coupler to the other copy) beside the same work written in
/// plain doubles; and how much faster than real time the loops of two shipped scenes run. Keys:
/// tick_ns, plain_tick_ns, ratio, fingers, walls, path_difference_m, virtual_speed_box_distributed,
/// virtual_speed_axis_distributed.
void add_bench_tick(CLI::App& bench);

}  // namespace tandem::bench
