#pragma once

#include <CLI/CLI.hpp>

namespace tandem::bench {

/// `tandem bench tick [--json FILE]`: one planar tick of a replica (4 fingers on a box, 2 walls
/// with 4 corners each, ground friction, coupler to the other copy) beside the same work written in
/// plain doubles. Keys: tick_ns, plain_tick_ns, ratio, fingers, walls, ticks, path_difference_m.
void add_bench_tick(CLI::App& bench);

}  // namespace tandem::bench
