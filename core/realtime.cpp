#include "core/realtime.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <linux/capability.h>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

namespace tandem::core {
namespace {

constexpr const char* kLimitsFile = "/etc/security/limits.d/tandem.conf";

std::string words_of(int error) { return std::strerror(error); }

bool may_lock_memory() {
  rlimit limit{};
  if (getrlimit(RLIMIT_MEMLOCK, &limit) == 0 && limit.rlim_cur == RLIM_INFINITY) return true;
  __user_cap_header_struct header{.version = _LINUX_CAPABILITY_VERSION_3, .pid = 0};
  __user_cap_data_struct data[_LINUX_CAPABILITY_U32S_3]{};
  if (syscall(SYS_capget, &header, data) != 0) return false;
  return (data[0].effective & (1u << CAP_IPC_LOCK)) != 0;
}

RealtimeSetting ask_priority(int priority) {
  RealtimeSetting setting{.name = kPriority, .asked = "SCHED_FIFO " + std::to_string(priority)};
  const sched_param parameters{.sched_priority = priority};
  const int error = pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters);
  setting.granted = error == 0;
  if (setting.granted) return setting;
  setting.refusal = words_of(error);
  setting.to_get_it = error == EINVAL ? "ask for a priority within [1, 99]"
                                      : "run as root, or put \"@USER - rtprio " +
                                            std::to_string(std::clamp(priority, 1, 99)) +
                                            "\" into " + kLimitsFile + " and log in again";
  return setting;
}

RealtimeSetting ask_memory_lock() {
  RealtimeSetting setting{.name = kMemoryLock, .asked = "all pages, now and later"};
  // Under a finite limit mlockall may succeed now and make a later allocation or thread fail:
  // worse than not locking.
  if (!may_lock_memory()) {
    setting.refusal = "the limit on locked memory is finite";
  } else if (mlockall(MCL_CURRENT | MCL_FUTURE) != 0) {
    setting.refusal = words_of(errno);
  } else {
    setting.granted = true;
  }
  if (!setting.granted) {
    setting.to_get_it = std::string("run as root, or put \"@USER - memlock unlimited\" into ") +
                        kLimitsFile + " and log in again";
  }
  return setting;
}

RealtimeSetting ask_affinity(int cpu) {
  RealtimeSetting setting{.name = kAffinity, .asked = "processor " + std::to_string(cpu)};
  if (cpu < 0 || cpu >= CPU_SETSIZE) {
    setting.refusal = words_of(EINVAL);
  } else {
    cpu_set_t set;
    CPU_ZERO(&set);
    CPU_SET(static_cast<std::size_t>(cpu), &set);
    const int error = pthread_setaffinity_np(pthread_self(), sizeof(set), &set);
    setting.granted = error == 0;
    if (error != 0) setting.refusal = words_of(error);
  }
  if (!setting.granted) {
    setting.to_get_it = "choose one of the processors 0 to " +
                        std::to_string(sysconf(_SC_NPROCESSORS_ONLN) - 1) +
                        " that this process may use (taskset -p)";
  }
  return setting;
}

RealtimeSetting ask_timer_slack(std::int64_t slack_ns) {
  RealtimeSetting setting{.name = kTimerSlack, .asked = std::to_string(slack_ns) + " ns"};
  setting.granted = slack_ns > 0 && prctl(PR_SET_TIMERSLACK, static_cast<unsigned long>(slack_ns),
                                          0ul, 0ul, 0ul) == 0;
  if (!setting.granted) {
    setting.refusal = words_of(slack_ns > 0 ? errno : EINVAL);
    setting.to_get_it = "ask for 1 ns or more";
  }
  return setting;
}

RealtimeSetting ask_dma_latency(int& descriptor) {
  constexpr const char* kFile = "/dev/cpu_dma_latency";
  RealtimeSetting setting{.name = kCpuDmaLatency, .asked = "0 us"};
  const std::int32_t microseconds = 0;
  descriptor = open(kFile, O_WRONLY | O_CLOEXEC);
  if (descriptor >= 0 && write(descriptor, &microseconds, sizeof(microseconds)) ==
                             static_cast<ssize_t>(sizeof(microseconds))) {
    setting.granted = true;
    return setting;
  }
  const int error = errno;
  setting.refusal = std::string(kFile) + ": " + words_of(error);
  setting.to_get_it =
      error == ENOENT
          ? "use a kernel with CONFIG_PM (a virtual machine's processors may not sleep at all)"
          : "run as root, or a udev rule: KERNEL==\"cpu_dma_latency\", GROUP=\"realtime\", "
            "MODE=\"0660\"; or let the loop spin instead";
  if (descriptor >= 0) close(descriptor);
  descriptor = -1;
  return setting;
}

}  // namespace

RealtimeGrant::~RealtimeGrant() {
  if (dma_latency_ >= 0) close(dma_latency_);
}

bool RealtimeGrant::all_granted() const {
  return std::all_of(settings_.begin(), settings_.end(),
                     [](const RealtimeSetting& s) { return s.granted; });
}

bool RealtimeGrant::granted(const std::string& name) const {
  return std::any_of(settings_.begin(), settings_.end(),
                     [&](const RealtimeSetting& s) { return s.name == name && s.granted; });
}

std::string RealtimeGrant::report() const {
  std::string text;
  for (const RealtimeSetting& s : settings_) {
    text += "real-time: asked " + s.name + " " + s.asked + ": ";
    text += s.granted ? "granted\n"
                      : "not granted: " + s.refusal + "; to get it: " + s.to_get_it + "\n";
  }
  return text;
}

RealtimeGrant request_realtime(const RealtimeRequest& request) {
  RealtimeGrant grant;
  if (request.timer_slack_ns != 0) {
    grant.settings_.push_back(ask_timer_slack(request.timer_slack_ns));
  }
  if (request.cpu) grant.settings_.push_back(ask_affinity(*request.cpu));
  if (request.lock_memory) grant.settings_.push_back(ask_memory_lock());
  if (request.hold_cpu_dma_latency) {
    grant.settings_.push_back(ask_dma_latency(grant.dma_latency_));
  }
  // Last: an ordinary thread may be refused what a SCHED_FIFO one never gets round to.
  if (request.priority != 0) grant.settings_.push_back(ask_priority(request.priority));
  return grant;
}

}  // namespace tandem::core
