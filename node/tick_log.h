#pragma once

#include "core/records.h"
#include "core/view_tap.h"
#include "recording/recording_writer.h"

namespace tandem::node {

/// Where the force thread leaves what its ticks saw and did: the recording, those who look on, or
/// nowhere. Packets of a tick come before the tick itself. Never waits; what does not fit is
/// counted by the recording.
class TickLog {
 public:
  /// @param recording  nullptr: nothing is kept; must live longer
  /// @param window, spectators  nullptr: nobody looks on there; must live longer
  explicit TickLog(recording::RecordingWriter* recording, core::ViewTap* window = nullptr,
                   core::ViewTap* spectators = nullptr)
      : recording_(recording), window_(window), spectators_(spectators) {}

  void push(const core::TickRecord& tick) noexcept {
    if (recording_ != nullptr) (void)recording_->record(tick);
    if (window_ != nullptr) window_->push(tick);
    if (spectators_ != nullptr) spectators_->push(tick);
  }
  void push(const core::PacketRecord& packet) noexcept {
    if (recording_ != nullptr) (void)recording_->record(packet);
    if (window_ != nullptr) window_->push(packet);
  }
  /// The hand of a further user at this node: spectators cannot know it from the network.
  void push_hand(const core::PacketRecord& hand) noexcept {
    push(hand);
    if (spectators_ != nullptr) spectators_->push(hand);
  }

 private:
  recording::RecordingWriter* recording_;
  core::ViewTap* window_;
  core::ViewTap* spectators_;
};

}  // namespace tandem::node
