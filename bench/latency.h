#pragma once

#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace tandem::bench {

/// What `sockperf ping-pong` said of half its round trips [us]; fraction and value. Empty: nothing
/// that could be read.
struct SockperfLine {
  double fraction = 0.0, us = 0.0;
};
struct SockperfSummary {
  double mean_us = 0.0;
  int count = 0;
  std::vector<SockperfLine> percentiles;
  [[nodiscard]] double at(double fraction) const;  ///< NaN: not said
};
[[nodiscard]] SockperfSummary read_sockperf(const std::string& said);

/// Adds `latency` to the program's `bench` command.
void add_bench_latency(CLI::App& bench);

}  // namespace tandem::bench
