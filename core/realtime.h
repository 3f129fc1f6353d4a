#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace tandem::core {

/// What a thread asks the operating system for. Everything is a wish: what is not granted is
/// reported, and the thread runs all the same.
struct RealtimeRequest {
  int priority = 80;                 ///< SCHED_FIFO, 1 to 99; 0: stay an ordinary thread
  bool lock_memory = true;           ///< mlockall, whole process: no page is ever swapped out
  std::optional<int> cpu{};          ///< run this thread on this processor only
  std::int64_t timer_slack_ns = 1;   ///< how much the kernel may delay a wake-up; 0: leave as is
  bool hold_cpu_dma_latency = true;  ///< keep processors out of deep sleep, whole machine
};

/// How long before its deadline a loop stops sleeping and asks the clock instead (the `spin_ns` of
/// PeriodicSchedule). Sound defaults, measured by `tandem bench wakeup`: a wake-up from light sleep
/// needs a shorter window than one from deep sleep.
inline constexpr std::int64_t kSpinLightSleepNs = 50'000;
inline constexpr std::int64_t kSpinDeepSleepNs = 120'000;

/// Names of the settings, as in the report.
inline constexpr const char* kPriority = "priority";
inline constexpr const char* kMemoryLock = "memory lock";
inline constexpr const char* kAffinity = "affinity";
inline constexpr const char* kTimerSlack = "timer slack";
inline constexpr const char* kCpuDmaLatency = "cpu dma latency";

/// One thing asked for, and what became of it.
struct RealtimeSetting {
  std::string name{};   ///< "priority"
  std::string asked{};  ///< "SCHED_FIFO 80"
  bool granted = false;
  std::string refusal{};    ///< when not granted: the operating system's words
  std::string to_get_it{};  ///< when not granted: what the person can do
};

/// The answer to a RealtimeRequest. Holds /dev/cpu_dma_latency open, hence at 0, while it lives:
/// keep it as long as the loop runs. Movable, not copyable.
class RealtimeGrant {
 public:
  RealtimeGrant() = default;
  RealtimeGrant(RealtimeGrant&& other) noexcept
      : settings_(std::move(other.settings_)),
        dma_latency_(std::exchange(other.dma_latency_, -1)) {}
  RealtimeGrant& operator=(RealtimeGrant&& other) noexcept {
    std::swap(settings_, other.settings_);
    std::swap(dma_latency_, other.dma_latency_);
    return *this;
  }
  ~RealtimeGrant();

  /// In the order asked; what was not asked for is not here.
  [[nodiscard]] const std::vector<RealtimeSetting>& settings() const { return settings_; }
  [[nodiscard]] bool all_granted() const;
  /// Whether this one was asked for and granted.
  [[nodiscard]] bool granted(const std::string& name) const;
  /// The spin window that suits what was granted [ns].
  [[nodiscard]] std::int64_t default_spin_ns() const {
    return granted(kCpuDmaLatency) ? kSpinLightSleepNs : kSpinDeepSleepNs;
  }
  /// One line each: "real-time: asked priority SCHED_FIFO 80: granted", or "... not granted:
  /// Operation not permitted; to get it: ...". Empty when nothing was asked for.
  [[nodiscard]] std::string report() const;

 private:
  friend RealtimeGrant request_realtime(const RealtimeRequest&);

  std::vector<RealtimeSetting> settings_;
  int dma_latency_ = -1;  // file descriptor
};

/// Asks for the calling thread (memory and dma latency: for the process, for the machine). Call it
/// on the thread that will run the loop, before the loop starts; it allocates and makes system
/// calls. Never throws for a refusal.
[[nodiscard]] RealtimeGrant request_realtime(const RealtimeRequest& request);

}  // namespace tandem::core
