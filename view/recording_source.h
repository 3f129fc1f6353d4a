#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/scene.h"
#include "recording/recording_reader.h"
#include "view/assemble.h"
#include "view/snapshot.h"

namespace tandem::view {

/// A recording as snapshots at any time, forwards and backwards.
class RecordingSource {
 public:
  /// Reads where everything is. Throws recording::RecordingError, scene::SceneError,
  /// std::runtime_error: an empty recording.
  explicit RecordingSource(const std::string& file);

  [[nodiscard]] const core::Scene& scene() const { return scene_; }
  [[nodiscard]] const std::string& user() const;
  /// Of the first and of the last tick [s].
  [[nodiscard]] double begin() const { return time_of(slots_.front()); }
  [[nodiscard]] double end() const { return time_of(slots_.back()); }
  [[nodiscard]] bool complete() const { return reader_.complete(); }

  /// What the node saw at the newest tick at or before this time (the first, before that).
  [[nodiscard]] const Snapshot& at(double time);

 private:
  struct PacketPlace {
    std::int64_t slot = 0;
    std::uint64_t index = 0;
  };
  [[nodiscard]] double time_of(std::int64_t slot) const {
    return static_cast<double>(slot) * scene_.tick();
  }

  recording::RecordingReader reader_;
  core::Scene scene_;
  std::vector<std::int64_t> slots_;
  std::array<std::vector<PacketPlace>, kSites> packets_;  ///< by peer, in order
  std::unique_ptr<Assembler> assembler_;
  std::size_t tick_ = SIZE_MAX;
  Snapshot now_;
};

}  // namespace tandem::view
