#pragma once

#include <cerrno>
#include <cstdint>
#include <ctime>

namespace tandem::core {

/// Where a node's time comes from; tests inject their own. Nanoseconds of a clock that never goes
/// back and is never set.
class Clock {
 public:
  virtual ~Clock() = default;
  [[nodiscard]] virtual std::int64_t now_ns() noexcept = 0;
  /// Returns at `deadline_ns` or later; at once if that has passed.
  virtual void sleep_until(std::int64_t deadline_ns) noexcept = 0;
};

/// CLOCK_MONOTONIC of this computer; sleeps to absolute deadlines. Any thread.
class MonotonicClock final : public Clock {
 public:
  [[nodiscard]] std::int64_t now_ns() noexcept override {
    timespec now{};
    clock_gettime(CLOCK_MONOTONIC, &now);
    return std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
  }

  void sleep_until(std::int64_t deadline_ns) noexcept override {
    const timespec deadline{.tv_sec = deadline_ns / 1'000'000'000,
                            .tv_nsec = deadline_ns % 1'000'000'000};
    // A signal ends the sleep early (EINTR): the deadline is absolute, so sleep on.
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &deadline, nullptr) == EINTR) {
    }
  }
};

/// Now, by the system's monotonic clock [ns].
[[nodiscard]] inline std::int64_t monotonic_ns() noexcept { return MonotonicClock().now_ns(); }

}  // namespace tandem::core
