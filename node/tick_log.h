#pragma once

#include "core/records.h"
#include "recording/recording_writer.h"

namespace tandem::node {

/// Where the force thread leaves what its ticks saw and did: the recording, or nowhere. Packets of
/// a tick come before the tick itself. Never waits; what does not fit is counted by the recording.
class TickLog {
 public:
  /// @param recording  nullptr: nothing is kept; must live longer
  explicit TickLog(recording::RecordingWriter* recording) : recording_(recording) {}

  void push(const core::TickRecord& tick) noexcept {
    if (recording_ != nullptr) (void)recording_->record(tick);
  }
  void push(const core::PacketRecord& packet) noexcept {
    if (recording_ != nullptr) (void)recording_->record(packet);
  }

 private:
  recording::RecordingWriter* recording_;
};

}  // namespace tandem::node
