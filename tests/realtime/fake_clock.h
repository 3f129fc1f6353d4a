#pragma once

#include <algorithm>
#include <cstdint>

#include "core/clock.h"

namespace tandem::test {

/// Time that passes only when it is asked for or slept through.
class FakeClock final : public core::Clock {
 public:
  explicit FakeClock(std::int64_t now_ns = 0) : now_ns_(now_ns) {}

  std::int64_t now_ns() noexcept override { return now_ns_ += per_look_ns_; }
  void sleep_until(std::int64_t deadline_ns) noexcept override {
    ++sleeps_;
    last_deadline_ns_ = deadline_ns;
    now_ns_ = std::max(now_ns_, deadline_ns + oversleep_ns_);
    oversleep_ns_ = 0;
  }

  void advance(std::int64_t ns) { now_ns_ += ns; }
  void oversleep_once(std::int64_t ns) { oversleep_ns_ = ns; }  ///< negative: wakes early
  void set_cost_of_a_look(std::int64_t ns) { per_look_ns_ = ns; }
  [[nodiscard]] int sleeps() const { return sleeps_; }
  [[nodiscard]] std::int64_t last_deadline_ns() const { return last_deadline_ns_; }

 private:
  std::int64_t now_ns_;
  std::int64_t per_look_ns_ = 0;
  std::int64_t oversleep_ns_ = 0;
  std::int64_t last_deadline_ns_ = 0;
  int sleeps_ = 0;
};

}  // namespace tandem::test
