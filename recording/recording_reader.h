#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/records.h"
#include "recording/record_columns.h"

namespace tandem::recording {

/// Reads a recording back, bit for bit: complete ones, and those whose program was killed or whose
/// disk was full (everything up to the last flush). For one thread, not the force thread.
class RecordingReader {
 public:
  /// Throws RecordingError if the file is missing or no recording of Tandem.
  explicit RecordingReader(const std::string& file);
  ~RecordingReader();
  RecordingReader(const RecordingReader&) = delete;
  RecordingReader& operator=(const RecordingReader&) = delete;

  [[nodiscard]] const RecordingHeader& header() const;
  [[nodiscard]] const RecordColumns& columns() const;
  /// Whether it was closed in order, as opposed to killed or cut off by a full disk.
  [[nodiscard]] bool complete() const;
  /// Records the writer knew to be lost; 0 if not complete.
  [[nodiscard]] std::int64_t records_lost() const;
  [[nodiscard]] std::uint64_t tick_count() const;
  [[nodiscard]] std::uint64_t packet_count() const;
  /// At most `count` records from the `first`-th on, in the order recorded; columns that were not
  /// stored are 0.
  [[nodiscard]] std::vector<core::TickRecord> ticks(std::uint64_t first, std::uint64_t count);
  [[nodiscard]] std::vector<core::PacketRecord> packets(std::uint64_t first, std::uint64_t count);

 private:
  struct File;
  std::unique_ptr<File> file_;
};

}  // namespace tandem::recording
