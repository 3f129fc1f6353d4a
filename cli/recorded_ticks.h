#pragma once

#include <span>
#include <string>
#include <vector>

#include "recording/recording_reader.h"

namespace tandem::cli {

/// Walks a recording tick by tick with the packets each tick used, reading ahead in blocks.
class RecordedTicks {
 public:
  explicit RecordedTicks(recording::RecordingReader& reader) : reader_(reader) {}

  /// False at the end.
  bool next() {
    if (tick_ + 1 < ticks_.size()) {
      ++tick_;
    } else {
      ticks_ = reader_.ticks(ticks_read_, kBlock);
      ticks_read_ += ticks_.size();
      tick_ = 0;
      if (ticks_.empty()) return false;
    }
    first_ = last_;
    take_packets();
    return true;
  }

  [[nodiscard]] const core::TickRecord& tick() const { return ticks_[tick_]; }
  [[nodiscard]] std::span<const core::PacketRecord> packets() const {
    return std::span(packets_).subspan(first_, last_ - first_);
  }

 private:
  void take_packets() {
    while (true) {
      while (last_ < packets_.size() && packets_[last_].slot <= tick().slot) ++last_;
      if (last_ < packets_.size()) return;
      auto more = reader_.packets(packets_read_, kBlock);
      if (more.empty()) return;
      packets_read_ += more.size();
      packets_.erase(packets_.begin(), packets_.begin() + static_cast<std::ptrdiff_t>(first_));
      last_ -= first_;
      first_ = 0;
      packets_.insert(packets_.end(), more.begin(), more.end());
    }
  }

  static constexpr std::uint64_t kBlock = 4096;

  recording::RecordingReader& reader_;
  std::vector<core::TickRecord> ticks_;
  std::vector<core::PacketRecord> packets_;
  std::size_t tick_ = 0, first_ = 0, last_ = 0;
  std::uint64_t ticks_read_ = 0, packets_read_ = 0;
};

}  // namespace tandem::cli
