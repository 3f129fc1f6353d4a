#pragma once

#include <CLI/CLI.hpp>

namespace tandem::bench {

/// `tandem bench cost [--json FILE] [--csv FILE]`: what each declared feature of a scene adds to a
/// tick of its whole session (all users, hands and modelled links). Keys: rows (feature, added_to,
/// users, tick_ns, added_ns, spread_ns), plain_axis_ns, axis_over_plain, axis_below_plane; where
/// bench_lacking is built, also undeclared (space, lacks, tick_ns, cost_ns, spread_ns,
/// instructions, cost_instructions, same_bits), undeclared_noise_ns, undeclared_most_instructions,
/// undeclared_costs_nothing.
void add_bench_cost(CLI::App& bench);

}  // namespace tandem::bench
