#pragma once

#include <CLI/CLI.hpp>

namespace tandem::bench {

/// `tandem bench analysis [--json FILE]`: the sixteen stability maps of Figs 5.1-5.4 (100 x 100,
/// d = 0..3) on one core beside batched numpy in the same run; the boundaries traced adaptively;
/// one point in a hundred judged again on the running loop; time and error of each road, at one
/// point and for a boundary. Keys: speedup_vs_numpy, counts_equal, tracing_speedup,
/// tracing_fewer_evaluations, maps, roads, accuracy.
void add_bench_analysis(CLI::App& bench);

}  // namespace tandem::bench
