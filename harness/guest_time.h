#pragma once

#include <atomic>
#include <cstdint>
#include <limits>

namespace tandem::harness {

/// The time of a guest kernel whose processor is never taken away and never idle: made from the
/// host's clock, which goes on while the host runs somebody else.
///
/// While the guest computes, its time goes kSlower times slower than the host's: a system call
/// costs 14 us in user-mode Linux and 1 to 2 us in a kernel of its own. From one reading to the
/// next it never goes past the timer that the guest has armed, or by kStep if that has passed: what
/// the host took away in between is not counted, so no timer is late by more than kStep. Idle time
/// is skipped. All times in ns. For one thread and the signal handlers that interrupt it.
class GuestTime {
 public:
  static constexpr std::int64_t kSlower = 8;
  static constexpr std::int64_t kStep = 20'000;

  /// Starts with the host's clock.
  explicit GuestTime(std::int64_t host_ns) noexcept : now_(host_ns), host_(host_ns) {}

  /// The guest's time when the host's is `host_ns`; never before an earlier answer.
  std::int64_t at(std::int64_t host_ns) noexcept {
    std::int64_t before = now_.load(std::memory_order_relaxed), after = before;
    do {
      const std::int64_t last = host_.load(std::memory_order_relaxed);
      const std::int64_t counted = host_ns > last ? (host_ns - last) / kSlower : 0;
      const std::int64_t timer = timer_.load(std::memory_order_relaxed);
      const std::int64_t room = timer > before + kStep ? timer - before : kStep;
      after = before + (counted < room ? counted : room);
    } while (!now_.compare_exchange_strong(before, after, std::memory_order_relaxed));
    if (host_ns > host_.load(std::memory_order_relaxed))
      host_.store(host_ns, std::memory_order_relaxed);
    return after;
  }

  /// The guest's timer is to ring after `delay_ns` of its time; 0: it has none.
  void arm(std::int64_t host_ns, std::int64_t delay_ns) noexcept {
    const std::int64_t now = at(host_ns);
    timer_.store(delay_ns > 0 ? now + delay_ns : kNever, std::memory_order_relaxed);
  }

  /// Nothing is left to do until the timer rings: false if there is none, else it is that time.
  bool skip_to_timer() noexcept {
    const std::int64_t timer = timer_.load(std::memory_order_relaxed);
    if (timer == kNever) return false;
    if (timer > now_.load(std::memory_order_relaxed)) now_.store(timer, std::memory_order_relaxed);
    return true;
  }

  /// What the host's clock did until now does not count.
  void resume(std::int64_t host_ns) noexcept { host_.store(host_ns, std::memory_order_relaxed); }

 private:
  static constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::max();

  std::atomic<std::int64_t> now_, host_, timer_{kNever};
};

}  // namespace tandem::harness
