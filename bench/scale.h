#pragma once

#include <string>
#include <vector>

#include "bench/scale_fit.h"
#include "bench/scale_measure.h"

namespace CLI {
class App;
}

namespace tandem::bench {

/// How one quantity of one architecture grows with users or with objects, and where it meets its
/// budget.
struct Growth {
  std::string architecture, over, what, unit;
  double budget = 0.0;
  std::string of;  ///< the budget in words
  PowerLaw law;
  Knee knee;
};

/// Budgets: a tick within 1 ms; link and force thread within one processor each; the packets of a
/// site, and of the session if it were on one machine, within what one thread can send and receive
/// by sendmmsg; virtual time not slower than real time.
[[nodiscard]] std::vector<Growth> growths_of(const std::vector<ScaleRow>& rows,
                                             double sendmmsg_per_s);

/// Adds `scale` to the program's `bench` command.
void add_bench_scale(CLI::App& bench);

}  // namespace tandem::bench
