#pragma once

#include <cstdint>
#include <optional>
#include <stop_token>
#include <string>

#include "core/wakeup_statistics.h"

namespace tandem::bench {

struct CyclictestOptions {
  int priority = 80;
  long interval_us = 977;  ///< of every thread [us]
  long wakeups = 1;        ///< of every thread
  int threads = 1;
  /// Resolution of a nanosecond up to 1 ms late, else of a microsecond up to 1 s late.
  bool nanoseconds = true;
};

struct CyclictestRun {
  std::optional<core::WakeupStatistics> lateness;  ///< of all threads; empty: it could not be run
  std::int64_t late_wakeups = 0;                   ///< by a period or more
  std::int64_t periods_missed = 0;                 ///< whole periods that these slept through
  std::string why_not;                             ///< missing, or what it complained of
  std::string command;
};

/// Runs `cyclictest` (Debian package rt-tests) with SCHED_FIFO threads. By itself it holds
/// /dev/cpu_dma_latency at 0. Blocks until it ends; `stop` ends it early, and so does the end of
/// the calling thread.
[[nodiscard]] CyclictestRun run_cyclictest(const CyclictestOptions& options,
                                           const std::stop_token& stop = {});

}  // namespace tandem::bench
