#pragma once

#include <optional>
#include <string>

#include "core/wakeup_statistics.h"

namespace tandem::bench {

struct CyclictestRun {
  std::optional<core::WakeupStatistics> lateness;  ///< empty: it could not be run
  std::string why_not;                             ///< missing, or what it complained of
  std::string command;
};

/// Runs `cyclictest` (Debian package rt-tests) as one SCHED_FIFO thread at `priority` for `wakeups`
/// periods of `interval_us` [us], to nanosecond resolution. By itself it holds
/// /dev/cpu_dma_latency at 0. Blocks until it ends.
[[nodiscard]] CyclictestRun run_cyclictest(int priority, long interval_us, long wakeups);

}  // namespace tandem::bench
