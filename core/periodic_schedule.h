#pragma once

#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <string>

#include "core/clock.h"

namespace tandem::core {

/// Keeps a fixed rate against absolute deadlines:
///   slot k is due at  start + round(k 10^9 / rate)  ns,
/// halves rounded up, computed in integers from k itself, so nothing adds up over days.
///
/// A slot that is already due but whose successor is not runs at once, late. Older slots are
/// counted as missed and skipped, never run in a burst: a burst would integrate the object several
/// times within one held device sample. For one thread.
class PeriodicSchedule {
 public:
  static constexpr double kMinRateHz = 1.0;
  static constexpr double kMaxRateHz = 1e6;

  /// One wake-up.
  struct Wake {
    std::int64_t slot = 0;         ///< the slot to run now
    std::int64_t due_ns = 0;       ///< when that slot was due
    std::int64_t woke_ns = 0;      ///< when it is now
    std::int64_t lateness_ns = 0;  ///< woke_ns less the time the awaited slot was due, >= 0;
                                   ///< with missed slots that is more than woke_ns - due_ns
    std::int64_t missed = 0;       ///< slots skipped just before this one
  };

  /// `rate_hz` within [1, 1e6], else std::invalid_argument. The last `spin_ns` before each deadline
  /// are spent asking the clock instead of sleeping: exact, at the price of processor time.
  /// The first wait is for `first_slot`.
  PeriodicSchedule(std::int64_t start_ns, double rate_hz, std::int64_t spin_ns = 0,
                   std::int64_t first_slot = 0)
      : start_ns_(start_ns), spin_ns_(spin_ns), next_slot_(first_slot) {
    if (!(rate_hz >= kMinRateHz && rate_hz <= kMaxRateHz)) {
      throw std::invalid_argument("rate of a periodic schedule is " + std::to_string(rate_hz) +
                                  " Hz, must be within [1, 1000000] Hz");
    }
    // A double is an integer over a power of two, exactly: rate = numerator_ / 2^shift_.
    numerator_ = 1;
    shift_ = 0;
    while (rate_hz != std::floor(rate_hz)) {
      rate_hz *= 2.0;
      ++shift_;
    }
    numerator_ = static_cast<Wide>(rate_hz);
  }

  /// Sleeps to the next slot that can still be run and says which one it is.
  [[nodiscard]] Wake wait(Clock& clock) noexcept {
    const std::int64_t awaited_due = due_ns(next_slot_);
    std::int64_t now = clock.now_ns();
    if (now < awaited_due - spin_ns_) {
      clock.sleep_until(awaited_due - spin_ns_);
      now = clock.now_ns();
    }
    while (now < awaited_due) {
      relax();
      now = clock.now_ns();
    }
    Wake wake{.slot = next_slot_,
              .due_ns = awaited_due,
              .woke_ns = now,
              .lateness_ns = now - awaited_due};
    if (now >= due_ns(next_slot_ + 1)) {
      wake.slot = slot_at(now);
      wake.due_ns = due_ns(wake.slot);
      wake.missed = wake.slot - next_slot_;
      missed_ += wake.missed;
    }
    next_slot_ = wake.slot + 1;
    return wake;
  }

  /// When slot `slot` is due [ns]. Slots from 0 to 2^44 (five centuries at 1024 Hz).
  [[nodiscard]] std::int64_t due_ns(std::int64_t slot) const noexcept {
    // 44 + 30 bits, shifted by at most 52 (rate >= 1): below 2^126.
    const Wide dividend = (static_cast<Wide>(slot) * kNanosecondsPerSecond) << shift_;
    const Wide whole = dividend / numerator_;
    const Wide rest = dividend % numerator_;
    return start_ns_ + static_cast<std::int64_t>(whole) + (rest >= numerator_ - rest ? 1 : 0);
  }

  /// The newest slot that is due at `time_ns`; 0 before the start.
  [[nodiscard]] std::int64_t slot_at(std::int64_t time_ns) const noexcept {
    if (time_ns <= start_ns_) return 0;
    const Wide elapsed = static_cast<Wide>(time_ns - start_ns_);
    auto slot = static_cast<std::int64_t>(elapsed * numerator_ / (kNanosecondsPerSecond << shift_));
    while (slot > 0 && due_ns(slot) > time_ns) --slot;  // rounding moves a slot by at most half
    while (due_ns(slot + 1) <= time_ns) ++slot;         // a nanosecond: one step at most
    return slot;
  }

  [[nodiscard]] std::int64_t start_ns() const noexcept { return start_ns_; }
  /// Slots skipped since the start.
  [[nodiscard]] std::int64_t missed() const noexcept { return missed_; }

 private:
  __extension__ using Wide = unsigned __int128;
  static constexpr Wide kNanosecondsPerSecond = 1'000'000'000;

  /// Tells the processor that this is a waiting loop: saves power and the other hyper-thread.
  static void relax() noexcept {
#if defined(__x86_64__) || defined(__i386__)
    __builtin_ia32_pause();
#elif defined(__aarch64__)
    asm volatile("yield");
#endif
  }

  std::int64_t start_ns_;
  std::int64_t spin_ns_;
  std::int64_t next_slot_;
  std::int64_t missed_ = 0;
  Wide numerator_;
  unsigned shift_;
};

}  // namespace tandem::core
