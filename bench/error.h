#pragma once

#include <CLI/CLI.hpp>

namespace tandem::bench {

/// `tandem bench error`: work-precision diagrams of every integrator and contact scheme beside
/// Box2D, Bullet, ODE and MuJoCo, on cases with an exact or extended-precision answer. Keys:
/// least_speedup_at_equal_error with its case, where_not, cases, runs.
void add_bench_error(CLI::App& bench);

}  // namespace tandem::bench
