#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <type_traits>

namespace tandem::core {

/// Hands the newest value from one writer thread to one reader thread; older values are
/// overwritten. Neither side ever waits: a triple buffer, one slot each for the writer, the reader
/// and the value between them, exchanged by one atomic instruction.
///
/// `publish` may be called by one thread, `fetch` by one (other or same) thread. Nothing can be
/// fetched before the first publish.
template <typename T>
class LatestValue {
  static_assert(std::is_trivially_copyable_v<T>, "copied on the force thread");

 public:
  LatestValue() = default;
  LatestValue(const LatestValue&) = delete;
  LatestValue& operator=(const LatestValue&) = delete;

  /// Writer thread.
  void publish(const T& value) noexcept {
    slots_[write_slot_].value = value;
    const std::uint32_t taken = between_.exchange(write_slot_ | kFresh, std::memory_order_acq_rel);
    write_slot_ = taken & kSlotMask;
  }

  /// Reader thread. Copies the newest value into `out`; false, and `out` untouched, if nothing was
  /// published since the last fetch.
  [[nodiscard]] bool fetch(T& out) noexcept {
    if ((between_.load(std::memory_order_relaxed) & kFresh) == 0) return false;
    const std::uint32_t taken = between_.exchange(read_slot_, std::memory_order_acq_rel);
    read_slot_ = taken & kSlotMask;
    out = slots_[read_slot_].value;
    return true;
  }

 private:
  static constexpr std::uint32_t kSlotMask = 3;
  static constexpr std::uint32_t kFresh = 4;
  static constexpr std::size_t kCacheLine = 64;  // keeps writer, reader and exchange word apart

  struct alignas(kCacheLine) Slot {
    T value{};
  };

  std::array<Slot, 3> slots_{};
  alignas(kCacheLine) std::atomic<std::uint32_t> between_{1};
  alignas(kCacheLine) std::uint32_t write_slot_ = 0;  // writer only
  alignas(kCacheLine) std::uint32_t read_slot_ = 2;   // reader only
};

}  // namespace tandem::core
