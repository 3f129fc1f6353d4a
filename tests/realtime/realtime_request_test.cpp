#include <functional>
#include <sched.h>
#include <string>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

#include <gtest/gtest.h>

#include "core/periodic_schedule.h"
#include "core/realtime.h"

namespace tandem::core {
namespace {

/// Runs `body` in a child process, so that priority, identity and limits end with it; the child's
/// exit status is what `body` returns. gtest's assertions do not cross: return a code per cause.
int in_child(const std::function<int()>& body) {
  const pid_t child = fork();
  if (child == 0) _exit(body());
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

/// An ordinary user: no privilege, and no limit raised for real-time work.
bool become_ordinary_user() {
  const rlimit none{0, 0};
  const rlimit small{64 * 1024, 64 * 1024};
  setrlimit(RLIMIT_RTPRIO, &none);
  setrlimit(RLIMIT_MEMLOCK, &small);
  return getuid() != 0 || setresuid(65534, 65534, 65534) == 0;
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(RealtimeRequest, AnOrdinaryUserIsToldWhatWasNotGrantedAndHowToGetItAndRunsOn) {
  const int failed = in_child([] {
    if (!become_ordinary_user()) return 1;
    const RealtimeGrant grant = request_realtime({});
    if (grant.granted("priority") || grant.granted("memory lock")) return 2;
    if (grant.all_granted()) return 3;
    if (sched_getscheduler(0) != SCHED_OTHER) return 4;
    const std::string report = grant.report();
    for (const char* part : {"asked priority SCHED_FIFO 80: not granted: ", "to get it: ",
                             "rtprio 80", "asked memory lock", "memlock unlimited"}) {
      if (!contains(report, part)) return 5;
    }
    // Timer slack needs no privilege.
    if (!grant.granted("timer slack") || prctl(PR_GET_TIMERSLACK) != 1) return 6;
    MonotonicClock clock;
    PeriodicSchedule schedule(clock.now_ns(), 1000.0);
    std::int64_t slot = 0;
    while (slot < 20) slot = schedule.wait(clock).slot;
    return 0;
  });
  EXPECT_EQ(failed, 0);
}

TEST(RealtimeRequest, WhatIsReportedAsGrantedIsWhatTheKernelSays) {
  const int failed = in_child([] {
    const RealtimeGrant grant = request_realtime({.priority = 7, .cpu = 0});
    const bool fifo = sched_getscheduler(0) == SCHED_FIFO;
    sched_param parameters{};
    sched_getparam(0, &parameters);
    if (grant.granted("priority") != (fifo && parameters.sched_priority == 7)) return 1;
    cpu_set_t set;
    sched_getaffinity(0, sizeof(set), &set);
    if (grant.granted("affinity") != (CPU_COUNT(&set) == 1 && CPU_ISSET(0, &set))) return 2;
    if (grant.settings().size() != 5) return 3;
    return 0;
  });
  EXPECT_EQ(failed, 0);
}

TEST(RealtimeRequest, AsksNothingItWasNotToldToAsk) {
  const int failed = in_child([] {
    const RealtimeGrant grant = request_realtime(
        {.priority = 0, .lock_memory = false, .timer_slack_ns = 0, .hold_cpu_dma_latency = false});
    if (!grant.settings().empty() || !grant.report().empty() || !grant.all_granted()) return 1;
    return sched_getscheduler(0) == SCHED_OTHER ? 0 : 2;
  });
  EXPECT_EQ(failed, 0);
}

TEST(RealtimeRequest, AnImpossibleProcessorOrPriorityIsRefusedWithTheAllowedRange) {
  const int failed = in_child([] {
    const RealtimeGrant grant = request_realtime(
        {.priority = 1000, .lock_memory = false, .cpu = 100'000, .hold_cpu_dma_latency = false});
    if (grant.granted("priority") || grant.granted("affinity")) return 1;
    const std::string report = grant.report();
    if (!contains(report, "within [1, 99]")) return 2;
    return contains(report, "processors 0 to ") ? 0 : 3;
  });
  EXPECT_EQ(failed, 0);
}

}  // namespace
}  // namespace tandem::core
