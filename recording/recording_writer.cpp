#include "recording/recording_writer.h"

#include <chrono>
#include <csignal>
#include <ctime>
#include <fcntl.h>
#include <future>
#include <unistd.h>
#include <utility>
#include <vector>

#include <hdf5.h>

#include "recording/hdf5_id.h"
#include "recording/record_table.h"

namespace tandem::recording {
namespace {

using namespace std::chrono_literals;

constexpr auto kDrainEvery = 50ms;
constexpr auto kFlushEvery = 500ms;
constexpr std::size_t kRowsPerWrite = 1024;

std::int64_t read_clock(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

void write_header(hid_t file, const RecordingHeader& header, const RecordColumns& columns) {
  write_attribute(file, "format", std::string("tandem recording"));
  write_attribute(file, "format_version", std::int64_t{1});
  write_attribute(file, "scene", header.scene_text);
  write_attribute(file, "scene_hash", header.scene_hash);
  write_attribute(file, "git_revision", header.git_revision);
  write_attribute(file, "program_version", header.program_version);
  write_attribute(file, "user", header.user);
  write_attribute(file, "units", std::string("SI; the unit of each column is beside its table"));
  write_attribute(file, "clock",
                  std::string("CLOCK_MONOTONIC of this computer [ns]; slot k was due at start_ns + "
                              "round(k 1e9 / local_rate_hz)"));
  write_attribute(file, "local_rate_hz", header.local_rate_hz);
  write_attribute(file, "start_ns", header.start_ns);
  write_attribute(file, "start_wall_ns", read_clock(CLOCK_REALTIME));
  write_attribute(file, "start_monotonic_ns", read_clock(CLOCK_MONOTONIC));
  write_attribute(file, "columns.fingers", std::int64_t{columns.fingers});
  write_attribute(file, "columns.hand_values", std::int64_t{columns.hand_values});
  write_attribute(file, "columns.users", std::int64_t{columns.users});
  write_attribute(file, "columns.objects", std::int64_t{columns.objects});
  write_attribute(file, "columns.object_values", std::int64_t{columns.object_values});
  write_attribute(file, "columns.contacts", std::int64_t{columns.contacts ? 1 : 0});
  write_attribute(file, "columns.packet_values", std::int64_t{columns.packet_values});
}

template <typename Record, typename Ring>
std::vector<Record> take(Ring& ring) {
  std::vector<Record> records;
  Record record;
  while (records.size() < kRowsPerWrite && ring.pop(record)) records.push_back(record);
  return records;
}

}  // namespace

/// The open file, on the writer's own thread only.
///
/// Single-writer-multiple-reader mode orders HDF5's own writes so that the file can be opened at
/// any moment, whenever the process is killed.
class RecordingWriter::File {
 public:
  File(const std::string& path, const RecordingHeader& header, const RecordColumns& columns)
      : path_(path) {
    const Hdf5Id access(H5Pcreate(H5P_FILE_ACCESS), "file access");
    require(H5Pset_libver_bounds(access, H5F_LIBVER_V110, H5F_LIBVER_V110) >= 0, "file version");
    const Hdf5Id creation(H5Pcreate(H5P_FILE_CREATE), "file creation");
    // Attributes beyond 64 kB (long scenes) must be stored outside the object header.
    require(H5Pset_attr_phase_change(creation, 0, 0) >= 0, "file creation");
    file_ = Hdf5Id(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, creation, access), "create");
    write_header(file_, header, columns);
    ticks_.emplace_back(RecordTable<core::TickRecord>::create(file_, "ticks", columns));
    packets_.emplace_back(RecordTable<core::PacketRecord>::create(file_, "packets", columns));
    require(H5Fflush(file_, H5F_SCOPE_LOCAL) >= 0, "flush");
    require(H5Fstart_swmr_write(file_) >= 0, "start");
  }

  void append(const std::vector<core::TickRecord>& rows) { ticks_.front().append(rows); }
  void append(const std::vector<core::PacketRecord>& rows) { packets_.front().append(rows); }
  void flush() { require(H5Fflush(file_, H5F_SCOPE_LOCAL) >= 0, "flush"); }
  [[nodiscard]] std::uint64_t tick_rows() const { return ticks_.front().rows(); }
  [[nodiscard]] std::uint64_t packet_rows() const { return packets_.front().rows(); }

  void finish(std::uint64_t lost) {
    flush();
    const bool closed = ticks_.front().close() && packets_.front().close() && file_.close();
    require(closed, "close");
    // No attribute may be added in the mode above: open again, as an ordinary file.
    Hdf5Id again(H5Fopen(path_.c_str(), H5F_ACC_RDWR, H5P_DEFAULT), "open again");
    write_attribute(again, "records_lost", static_cast<std::int64_t>(lost));
    write_attribute(again, "end_monotonic_ns", read_clock(CLOCK_MONOTONIC));
    write_attribute(again, "complete", std::int64_t{1});
    require(again.close(), "close");
  }

  /// After a failed write: whatever HDF5 still holds back must not go over what is safe, neither
  /// now nor when the program ends. Its descriptor is turned to /dev/null.
  void abandon() {
    void* handle = nullptr;
    if (H5Fget_vfd_handle(file_, H5P_DEFAULT, &handle) < 0 || handle == nullptr) return;
    const int nowhere = ::open("/dev/null", O_RDWR | O_CLOEXEC);
    if (nowhere < 0) return;
    dup2(nowhere, *static_cast<int*>(handle));
    ::close(nowhere);
  }

 private:
  std::string path_;
  Hdf5Id file_;
  std::vector<RecordTable<core::TickRecord>> ticks_;  // one each
  std::vector<RecordTable<core::PacketRecord>> packets_;
};

RecordingWriter::RecordingWriter(const std::string& file, const RecordingHeader& header,
                                 const RecordColumns& columns) {
  check(columns);
  std::promise<std::string> opened;
  std::future<std::string> problem = opened.get_future();
  thread_ = std::thread([this, &opened, file, header, columns] {
    // Signals are for the program's main thread, and SIGXFSZ (a file at the size limit) would end
    // the program: blocked, the write fails instead and is counted.
    sigset_t all;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, nullptr);
    const QuietHdf5 quiet;
    std::unique_ptr<File> open;
    try {
      open = std::make_unique<File>(file, header, columns);
    } catch (const std::exception& error) {
      opened.set_value(error.what());
      return;
    }
    opened.set_value({});
    run(*open, file);
  });
  const std::string failure = problem.get();
  if (!failure.empty()) {
    thread_.join();
    throw RecordingError("recording \"" + file + "\" cannot be made: " + failure +
                         "; choose a folder that exists, is yours and has room");
  }
}

RecordingWriter::~RecordingWriter() { close(); }

void RecordingWriter::close() {
  stop_ = true;
  if (thread_.joinable()) thread_.join();
}

RecordingStatus RecordingWriter::status() const {
  const std::lock_guard lock(status_mutex_);
  RecordingStatus status = status_;
  status.lost += ticks_.dropped() + packets_.dropped();
  return status;
}

void RecordingWriter::run(File& file, const std::string& path) {
  auto next_flush = std::chrono::steady_clock::now() + kFlushEvery;
  bool well = true;
  const auto attempt = [&](auto&& write) {
    if (!well) return;
    try {
      write();
    } catch (const std::exception& error) {
      well = false;
      file.abandon();
      const std::lock_guard lock(status_mutex_);
      status_.failure = "recording \"" + path + "\" stopped: " + error.what() + "; " +
                        std::to_string(status_.ticks_safe) + " ticks and " +
                        std::to_string(status_.packets_safe) +
                        " packets are safe in it, the session goes on without; make room and "
                        "start a new recording";
      // Written since the last flush: nobody knows how much of it arrived.
      status_.lost += written_ - status_.ticks_safe - status_.packets_safe;
    }
  };
  while (true) {
    const bool last_round = stop_;
    for (bool more = true; more;) {
      const auto ticks = take<core::TickRecord>(ticks_);
      const auto packets = take<core::PacketRecord>(packets_);
      const std::uint64_t count = ticks.size() + packets.size();
      more = count > 0;
      if (well) written_ += count;
      if (!well && more) {
        const std::lock_guard lock(status_mutex_);
        status_.lost += count;
      }
      attempt([&] {
        file.append(ticks);
        file.append(packets);
      });
    }
    if (last_round) break;
    if (std::chrono::steady_clock::now() >= next_flush) {
      next_flush += kFlushEvery;
      attempt([&] {
        file.flush();
        const std::lock_guard lock(status_mutex_);
        status_.ticks_safe = file.tick_rows();
        status_.packets_safe = file.packet_rows();
      });
    }
    std::this_thread::sleep_for(kDrainEvery);
  }
  attempt([&] {
    const std::uint64_t ticks = file.tick_rows(), packets = file.packet_rows();
    file.finish(ticks_.dropped() + packets_.dropped());
    const std::lock_guard lock(status_mutex_);
    status_.ticks_safe = ticks;
    status_.packets_safe = packets;
  });
}

}  // namespace tandem::recording
