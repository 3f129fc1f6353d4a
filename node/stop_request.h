#pragma once

#include <atomic>
#include <csignal>
#include <span>

#include "devices/haptic_device.h"

/// How a node ends from outside: SIGINT and SIGTERM ask it to end in order; SIGSEGV, SIGABRT,
/// SIGBUS, SIGFPE and SIGILL switch the motors off as well as a broken process can, then die as
/// they would have.
namespace tandem::node {

/// Set by SIGINT and SIGTERM, or by a node's own supervisor. Any thread.
class StopRequest {
 public:
  [[nodiscard]] bool requested() const noexcept { return asked_.load(std::memory_order_relaxed); }
  /// The signal that asked; 0: none did.
  [[nodiscard]] int signal() const noexcept { return signal_.load(std::memory_order_relaxed); }
  void request(int signal = 0) noexcept {
    signal_.store(signal, std::memory_order_relaxed);
    asked_.store(true, std::memory_order_relaxed);
  }

 private:
  static_assert(std::atomic<bool>::is_always_lock_free, "set in a signal handler");
  std::atomic<bool> asked_{false};
  std::atomic<int> signal_{0};
};

/// While it lives the signals above go to `request` and `devices`. One at a time in a process.
/// A second SIGINT or SIGTERM stops the devices and ends the process at once.
class SignalGuard {
 public:
  SignalGuard(StopRequest& request, std::span<devices::HapticDevice* const> devices);
  ~SignalGuard();
  SignalGuard(const SignalGuard&) = delete;
  SignalGuard& operator=(const SignalGuard&) = delete;

 private:
  static constexpr int kSignals[] = {SIGINT, SIGTERM, SIGSEGV, SIGABRT, SIGBUS, SIGFPE, SIGILL};
  static constexpr std::size_t kCount = std::size(kSignals);
  struct sigaction before_[kCount];
};

}  // namespace tandem::node
