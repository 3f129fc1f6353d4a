#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

namespace CLI {
class App;
}

namespace tandem::bench {

struct WakeupBenchOptions {
  double rate_hz = 1024.0;
  double seconds = 10.0;  ///< of each variant, all rounds together, > 0
  int rounds = 5;         ///< variants take turns, so that all see the same machine
  int priority = 80;      ///< SCHED_FIFO of the real-time variants and of cyclictest
};

/// One way of waiting. Percentiles are medians over the rounds; max and missed are over all.
struct WakeupRow {
  std::string name;
  bool node_default = false;  ///< the way a node waits unless told otherwise
  double p50_us = 0.0, p99_us = 0.0, p999_us = 0.0, max_us = 0.0;
  std::int64_t wakeups = 0, missed = 0;
  double processor_fraction = 0.0;  ///< of one processor, used by the waiting thread
  std::string not_granted;          ///< what the operating system refused; empty: nothing
};

struct WakeupBenchResults {
  std::vector<WakeupRow> rows;
  double p99_us = 0.0;  ///< of the node's default way
  std::optional<double> cyclictest_p99_us;
  std::string cyclictest;  ///< its command line, or why it could not be run
};

/// Measures how late a loop at `rate_hz` wakes under each way of waiting and under cyclictest,
/// interleaved. Blocks for about 6 times `seconds`.
[[nodiscard]] WakeupBenchResults run_wakeup_bench(const WakeupBenchOptions& options);

[[nodiscard]] nlohmann::json to_json(const WakeupBenchResults& results);
[[nodiscard]] std::string to_text(const WakeupBenchResults& results);

/// Adds `wakeup` to the program's `bench` command.
void add_bench_wakeup(CLI::App& bench);

}  // namespace tandem::bench
