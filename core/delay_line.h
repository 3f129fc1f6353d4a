#pragma once

#include <array>
#include <type_traits>

namespace tandem::core {

/// Holds each sample for a fixed whole number of pushes: y[n] = u[n - d], y = `initial` before.
/// Storage is fixed at compile time; nothing is allocated.
template <typename Sample, int kMaxDelay>
class DelayLine {
  static_assert(std::is_trivially_copyable_v<Sample>);

 public:
  DelayLine() noexcept = default;
  explicit DelayLine(int delay, const Sample& initial) noexcept
      : delay_(delay < 0 ? 0 : (delay > kMaxDelay ? kMaxDelay : delay)) {
    samples_.fill(initial);
  }

  [[nodiscard]] Sample push(const Sample& newest) noexcept {
    if (delay_ == 0) return newest;
    const Sample oldest = samples_[0];
    for (int i = 1; i < delay_; ++i) samples_[i - 1] = samples_[i];
    samples_[delay_ - 1] = newest;
    return oldest;
  }

  /// Visits the samples still in flight, oldest first; these are its states.
  template <typename Visitor>
  void visit_state(Visitor&& visitor) {
    for (int i = 0; i < delay_; ++i) visitor(samples_[i]);
  }

 private:
  std::array<Sample, kMaxDelay> samples_{};
  int delay_ = 0;
};

inline constexpr int kMaxLatencyTicks = 8;

}  // namespace tandem::core
