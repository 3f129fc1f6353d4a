#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <type_traits>

namespace tandem::core {

/// First-in-first-out ring from one writer thread to one reader thread. Neither side waits; when
/// the ring is full the newest value is dropped and counted, what is already queued stays.
///
/// Storage is allocated and touched once, in the constructor, so a push from the force thread
/// neither allocates nor faults a page in.
template <typename T, std::size_t kCapacity>
class SpscRing {
  static_assert(std::is_trivially_copyable_v<T>, "copied on the force thread");
  static_assert(kCapacity > 0 && (kCapacity & (kCapacity - 1)) == 0, "a power of two");

 public:
  SpscRing() : slots_(std::make_unique<T[]>(kCapacity)) {}
  SpscRing(const SpscRing&) = delete;
  SpscRing& operator=(const SpscRing&) = delete;

  /// Writer thread. False if the ring was full: the value is lost and counted.
  bool push(const T& value) noexcept {
    const std::uint64_t tail = tail_.load(std::memory_order_relaxed);
    if (tail - head_seen_ == kCapacity) {
      head_seen_ = head_.load(std::memory_order_acquire);
      if (tail - head_seen_ == kCapacity) {
        // One writer, so no read-modify-write instruction is needed.
        dropped_.store(dropped_.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
        return false;
      }
    }
    slots_[tail & (kCapacity - 1)] = value;
    tail_.store(tail + 1, std::memory_order_release);
    return true;
  }

  /// Reader thread. Oldest value first; false, and `out` untouched, when the ring is empty.
  [[nodiscard]] bool pop(T& out) noexcept {
    const std::uint64_t head = head_.load(std::memory_order_relaxed);
    if (head == tail_seen_) {
      tail_seen_ = tail_.load(std::memory_order_acquire);
      if (head == tail_seen_) return false;
    }
    out = slots_[head & (kCapacity - 1)];
    head_.store(head + 1, std::memory_order_release);
    return true;
  }

  /// Values lost since the start because the ring was full. Any thread.
  [[nodiscard]] std::uint64_t dropped() const noexcept {
    return dropped_.load(std::memory_order_relaxed);
  }

 private:
  static constexpr std::size_t kCacheLine = 64;  // keeps the two sides' words apart

  std::unique_ptr<T[]> slots_;
  alignas(kCacheLine) std::atomic<std::uint64_t> tail_{0};  // written by the writer
  std::uint64_t head_seen_ = 0;                             // writer's last look at head_
  std::atomic<std::uint64_t> dropped_{0};
  alignas(kCacheLine) std::atomic<std::uint64_t> head_{0};  // written by the reader
  std::uint64_t tail_seen_ = 0;                             // reader's last look at tail_
};

}  // namespace tandem::core
