#pragma once

#include <cstdint>

#include "core/link_model.h"

namespace tandem::core {

/// The receiving end of a modelled link: newest sequence wins, as the sequence gate of a node does.
template <typename Message>
class ModelledPort {
 public:
  ModelledPort() noexcept = default;
  explicit ModelledPort(const LinkModelParameters& parameters) noexcept : link_(parameters) {}

  void push(const Message& message, std::int64_t slot, double late = 0.0) noexcept {
    link_.push(message, slot, late);
  }

  /// The newest message accepted for this slot, nullptr if none.
  [[nodiscard]] const Message* receive(std::int64_t slot) noexcept {
    bool fresh = false;
    link_.deliver(slot, [&](const Message& m, std::int64_t send_slot, std::uint64_t sequence) {
      if (sequence <= newest_sequence_) return;
      newest_ = m;
      newest_sequence_ = sequence;
      newest_slot_ = send_slot;
      ++accepted_;
      fresh = true;
    });
    return fresh ? &newest_ : nullptr;
  }

  /// Age of the newest accepted message at `slot` [ticks]; 0 before the first.
  [[nodiscard]] std::int64_t age(std::int64_t slot) const noexcept {
    return newest_sequence_ == 0 ? 0 : slot - newest_slot_;
  }
  /// That age as the receiver reckons it [ticks], never negative: what laws are told.
  [[nodiscard]] double reckoned_age(std::int64_t slot) const noexcept {
    if (newest_sequence_ == 0) return 0.0;
    const double reckoned =
        static_cast<double>(slot - newest_slot_) + link_.parameters().age_error_ticks;
    return reckoned > 0.0 ? reckoned : 0.0;
  }
  [[nodiscard]] std::int64_t accepted() const noexcept { return accepted_; }
  [[nodiscard]] LinkModel<Message>& link() noexcept { return link_; }
  [[nodiscard]] const LinkModel<Message>& link() const noexcept { return link_; }

 private:
  LinkModel<Message> link_{};
  Message newest_{};
  std::uint64_t newest_sequence_ = 0;
  std::int64_t newest_slot_ = 0;
  std::int64_t accepted_ = 0;
};

}  // namespace tandem::core
