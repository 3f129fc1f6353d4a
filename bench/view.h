#pragma once

#include <CLI/CLI.hpp>

namespace tandem::bench {

/// `tandem bench view`: the same node without and with a window, in turns.
void add_bench_view(CLI::App& bench);

}  // namespace tandem::bench
