#pragma once

#include <ctime>

namespace tandem::bench {

/// Processor time of this thread [ns]: time on one core, whatever else the machine is doing.
[[nodiscard]] inline double core_ns() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e9 * static_cast<double>(now.tv_sec) + static_cast<double>(now.tv_nsec);
}
/// The same [s].
[[nodiscard]] inline double core_seconds() { return 1e-9 * core_ns(); }

}  // namespace tandem::bench
