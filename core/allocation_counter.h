#pragma once

#include <atomic>
#include <cstdint>

/// Counts what the force loop allocates. A node marks its force thread with `CountAllocations`; a
/// program that links `tandem::allocation_hook` has every malloc and operator new of a marked
/// thread counted, at the cost of one thread-local load and branch an allocation. Without the hook
/// nothing is counted, nothing costs anything, and `allocation_hook_linked()` says so.
namespace tandem::core {

namespace detail {
inline constinit thread_local bool counting_allocations = false;
inline constinit std::atomic<std::uint64_t> counted_allocations{0};
inline constinit bool allocation_hook = false;  // set by the hook before main
}  // namespace detail

/// While it lives, allocations of the thread that made it are counted. Nesting is allowed.
class CountAllocations {
 public:
  CountAllocations() noexcept : before_(detail::counting_allocations) {
    detail::counting_allocations = true;
  }
  ~CountAllocations() { detail::counting_allocations = before_; }
  CountAllocations(const CountAllocations&) = delete;
  CountAllocations& operator=(const CountAllocations&) = delete;

 private:
  bool before_;
};

/// Allocations by marked threads since the program started. Any thread.
[[nodiscard]] inline std::uint64_t counted_allocations() noexcept {
  return detail::counted_allocations.load(std::memory_order_relaxed);
}

/// Whether this program can count at all; if not, a count of 0 means nothing.
[[nodiscard]] inline bool allocation_hook_linked() noexcept { return detail::allocation_hook; }

}  // namespace tandem::core
