/// Loaded into user-mode Linux before its C library (LD_PRELOAD): gives it GuestTime instead of the
/// host's clock. It reads its clock by clock_gettime, has one timer, and idles in sigsuspend
/// (arch/um/os-Linux/time.c); nothing from outside reaches our guests but what their own file
/// accesses return at once.
#include <cstdint>
#include <ctime>
#include <dlfcn.h>
#include <signal.h>

#include "harness/guest_time.h"

namespace {

constexpr std::int64_t kSecond = 1'000'000'000;

[[nodiscard]] std::int64_t ns_of(const timespec& t) { return t.tv_sec * kSecond + t.tv_nsec; }
[[nodiscard]] timespec timespec_of(std::int64_t ns) {
  return {.tv_sec = ns / kSecond, .tv_nsec = ns % kSecond};
}

/// The C library's own function of this name.
template <typename Function>
[[nodiscard]] Function* own(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

[[nodiscard]] std::int64_t host_now(clockid_t clock = CLOCK_MONOTONIC) {
  static const auto read = own<int(clockid_t, timespec*)>("clock_gettime");
  timespec t{};
  read(clock, &t);
  return ns_of(t);
}

struct Guest {
  tandem::harness::GuestTime time{host_now()};
  const std::int64_t date = host_now(CLOCK_REALTIME) - host_now();
  timer_t timer{};
  bool repeats = false;  ///< while it boots
};

[[nodiscard]] Guest& guest() {
  static Guest one;
  return one;
}

int set_host_timer(timer_t timer, int flags, const itimerspec& to, itimerspec* before) {
  static const auto set = own<int(timer_t, int, const itimerspec*, itimerspec*)>("timer_settime");
  return set(timer, flags, &to, before);
}

}  // namespace

extern "C" {

__attribute__((visibility("default"))) int clock_gettime(clockid_t clock, timespec* now) noexcept {
  if (clock != CLOCK_MONOTONIC && clock != CLOCK_REALTIME) {
    static const auto read = own<int(clockid_t, timespec*)>("clock_gettime");
    return read(clock, now);
  }
  *now = timespec_of(guest().time.at(host_now()) + (clock == CLOCK_REALTIME ? guest().date : 0));
  return 0;
}

__attribute__((visibility("default"))) int timer_settime(timer_t timer, int flags,
                                                         const itimerspec* to,
                                                         itimerspec* before) noexcept {
  using tandem::harness::GuestTime;
  guest().timer = timer;
  guest().repeats = ns_of(to->it_interval) > 0;
  guest().time.arm(host_now(), ns_of(to->it_value));
  if (guest().repeats) return set_host_timer(timer, flags, *to, before);
  // While the guest computes, its time goes slower.
  const itimerspec slower{.it_interval = {},
                          .it_value = timespec_of(GuestTime::kSlower * ns_of(to->it_value))};
  return set_host_timer(timer, flags, slower, before);
}

__attribute__((visibility("default"))) int sigsuspend(const sigset_t* mask) {
  static const auto wait = own<int(const sigset_t*)>("sigsuspend");
  if (guest().repeats) return wait(mask);
  (void)guest().time.at(host_now());
  // The timer itself rings, at once: a signal of ours would be taken for its signal if that is
  // already under way, and be lost with it.
  if (guest().time.skip_to_timer())
    set_host_timer(guest().timer, 0, {.it_interval = {}, .it_value = timespec_of(1)}, nullptr);
  const int result = wait(mask);
  guest().time.resume(host_now());
  return result;
}

}  // extern "C"
