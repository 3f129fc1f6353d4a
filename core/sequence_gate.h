#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace tandem::core {

/// What the gate says of one sequence number.
enum class Gate : std::uint8_t {
  kAccept,     ///< newer than everything before: use it
  kOld,        ///< first arrival, but a newer one was used already: reordered, drop it
  kDuplicate,  ///< arrived before, or too old to tell
  kLeap,       ///< absurdly far ahead: taking it would lock out every true packet after it
};

/// Newest wins: a packet passes only if its number is larger than all that passed before. Nothing
/// is buffered. Numbers start at 1 in every session; `reset` begins a new one.
///
/// Old and duplicate are told apart within the last kWindow numbers (a ring of bits, RFC 6479).
class SequenceGate {
 public:
  static constexpr std::uint64_t kWindow = 256;
  static constexpr std::uint64_t kMaxLeap = 1ull << 20;  ///< 2 h of silence at 128 Hz

  struct Counts {
    std::uint64_t accepted = 0;
    std::uint64_t old = 0;
    std::uint64_t duplicate = 0;
    std::uint64_t leap = 0;
  };

  [[nodiscard]] Gate admit(std::uint64_t sequence) noexcept {
    const Gate answer = judge(sequence);
    switch (answer) {
      case Gate::kAccept:
        ++counts_.accepted;
        break;
      case Gate::kOld:
        ++counts_.old;
        break;
      case Gate::kDuplicate:
        ++counts_.duplicate;
        break;
      case Gate::kLeap:
        ++counts_.leap;
        break;
    }
    return answer;
  }

  /// New session: the next number may be 1 again. Counts go on unless asked otherwise.
  void reset(bool counts_too = false) noexcept {
    lost_before_ += lost_in_session();
    newest_ = lowest_ = first_arrivals_ = 0;
    seen_ = {};
    if (counts_too) {
      counts_ = {};
      lost_before_ = 0;
    }
  }

  [[nodiscard]] std::uint64_t newest() const noexcept { return newest_; }  ///< 0: none yet
  [[nodiscard]] const Counts& counts() const noexcept { return counts_; }
  /// Numbers between the first and the newest arrival that never came, all sessions together:
  /// whoever starts to listen late has lost nothing. A packet still on its way behind a faster one
  /// counts as lost until it comes.
  [[nodiscard]] std::uint64_t lost() const noexcept { return lost_before_ + lost_in_session(); }

 private:
  [[nodiscard]] Gate judge(std::uint64_t sequence) noexcept {
    if (sequence > newest_) {
      if (sequence - newest_ > kMaxLeap) return Gate::kLeap;
      const std::uint64_t clear_from = sequence - newest_ > kWindow ? sequence - kWindow : newest_;
      for (std::uint64_t s = clear_from + 1; s <= sequence; ++s) mark(s, false);
      newest_ = sequence;
      arrive(sequence);
      return Gate::kAccept;
    }
    if (sequence == 0 || newest_ - sequence >= kWindow || seen(sequence)) return Gate::kDuplicate;
    arrive(sequence);
    return Gate::kOld;
  }

  void arrive(std::uint64_t sequence) noexcept {
    mark(sequence, true);
    if (first_arrivals_ == 0 || sequence < lowest_) lowest_ = sequence;
    ++first_arrivals_;
  }

  [[nodiscard]] std::uint64_t lost_in_session() const noexcept {
    return first_arrivals_ == 0 ? 0 : newest_ - lowest_ + 1 - first_arrivals_;
  }

  [[nodiscard]] bool seen(std::uint64_t s) const noexcept {
    return (seen_[(s % kWindow) / 64] >> (s % 64) & 1u) != 0;
  }
  void mark(std::uint64_t s, bool value) noexcept {
    const std::uint64_t bit = 1ull << (s % 64);
    std::uint64_t& word = seen_[(s % kWindow) / 64];
    word = value ? word | bit : word & ~bit;
  }

  std::uint64_t newest_ = 0;
  std::uint64_t lowest_ = 0;          ///< smallest that arrived in this session
  std::uint64_t first_arrivals_ = 0;  ///< of this session
  std::uint64_t lost_before_ = 0;     ///< in earlier sessions
  std::array<std::uint64_t, kWindow / 64> seen_{};
  Counts counts_;
};

}  // namespace tandem::core
