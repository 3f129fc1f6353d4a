#pragma once

#include <pthread.h>
#include <stdexcept>

namespace tandem::net {

/// A mutex whose holder runs at the priority of whoever waits for it (PTHREAD_PRIO_INHERIT): a
/// thread of ordinary priority that looks at statistics does not keep a real-time thread waiting
/// for the processor. Locked like std::mutex.
class InheritingMutex {
 public:
  InheritingMutex() {
    pthread_mutexattr_t kind;
    pthread_mutexattr_init(&kind);
    pthread_mutexattr_setprotocol(&kind, PTHREAD_PRIO_INHERIT);
    const int failed = pthread_mutex_init(&mutex_, &kind);
    pthread_mutexattr_destroy(&kind);
    if (failed != 0) throw std::runtime_error("no mutex with priority inheritance");
  }
  ~InheritingMutex() { pthread_mutex_destroy(&mutex_); }
  InheritingMutex(const InheritingMutex&) = delete;
  InheritingMutex& operator=(const InheritingMutex&) = delete;

  void lock() noexcept { pthread_mutex_lock(&mutex_); }
  void unlock() noexcept { pthread_mutex_unlock(&mutex_); }

 private:
  pthread_mutex_t mutex_;
};

}  // namespace tandem::net
