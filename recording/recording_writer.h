#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "core/records.h"
#include "core/spsc_ring.h"
#include "recording/record_columns.h"

namespace tandem::recording {

struct RecordingStatus {
  std::uint64_t ticks_safe = 0;    ///< in the file, flushed
  std::uint64_t packets_safe = 0;  ///< in the file, flushed
  std::uint64_t lost = 0;          ///< records lost: ring full, or after the file failed
  std::string failure;             ///< empty: the file is well
};

/// Records a session into an HDF5 file. The force thread hands fixed-size records over; a thread of
/// its own, which never holds the force thread up, writes them and flushes every half second, so
/// that killing the program (SIGKILL) loses at most the last second.
///
/// When the file cannot be written any more (disk full) the session goes on: everything flushed so
/// far stays readable, later records are counted as lost, `status().failure` says why, once.
/// It needs no clean end, but `close` (or the destructor) marks the file complete.
class RecordingWriter {
 public:
  /// Makes the file, replacing an older one. Throws RecordingError if it cannot be made, and
  /// std::invalid_argument for impossible columns.
  RecordingWriter(const std::string& file, const RecordingHeader& header,
                  const RecordColumns& columns);
  ~RecordingWriter();
  RecordingWriter(const RecordingWriter&) = delete;
  RecordingWriter& operator=(const RecordingWriter&) = delete;

  /// Force thread only. Never waits, allocates or throws; false if the record was lost (counted).
  bool record(const core::TickRecord& tick) noexcept { return ticks_.push(tick); }
  bool record(const core::PacketRecord& packet) noexcept { return packets_.push(packet); }

  /// Any thread but the force thread.
  [[nodiscard]] RecordingStatus status() const;

  /// Writes what is left and marks the file complete. Call when the force thread has stopped.
  void close();

 private:
  class File;

  void run(File& file, const std::string& path);

  // Four seconds of ticks at 1024 Hz, and of packets of seven peers at 128 Hz.
  core::SpscRing<core::TickRecord, 4096> ticks_;
  core::SpscRing<core::PacketRecord, 4096> packets_;
  std::atomic<bool> stop_{false};
  mutable std::mutex status_mutex_;  // never taken by the force thread
  RecordingStatus status_;
  std::uint64_t written_ = 0;  // records given to the file; writer's thread only
  std::thread thread_;
};

}  // namespace tandem::recording
