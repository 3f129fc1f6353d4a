#include "recording/recording_reader.h"

#include <unistd.h>

#include <hdf5.h>

#include "recording/hdf5_id.h"
#include "recording/record_table.h"

namespace tandem::recording {
namespace {

Hdf5Id open_file(const std::string& path) {
  if (access(path.c_str(), R_OK) != 0) {
    throw RecordingError("recording \"" + path + "\" cannot be read: no such file, or not yours");
  }
  if (H5Fis_hdf5(path.c_str()) <= 0) {
    throw RecordingError("\"" + path + "\" is not a recording: it is no HDF5 file");
  }
  const hid_t whole = H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  if (whole >= 0) return {whole, "open"};
  // A file whose writer was killed, or still writes, is marked so and opens only like this.
  return {H5Fopen(path.c_str(), H5F_ACC_RDONLY | H5F_ACC_SWMR_READ, H5P_DEFAULT), "open"};
}

RecordingHeader read_header(hid_t file) {
  RecordingHeader header;
  header.scene_text = read_text(file, "scene");
  header.scene_hash = read_text(file, "scene_hash");
  header.git_revision = read_text(file, "git_revision");
  header.program_version = read_text(file, "program_version");
  header.user = read_text(file, "user");
  header.local_rate_hz = read_number(file, "local_rate_hz");
  header.start_ns = read_integer(file, "start_ns");
  header.start_wall_ns = read_integer(file, "start_wall_ns");
  header.start_monotonic_ns = read_integer(file, "start_monotonic_ns");
  return header;
}

RecordColumns read_columns(hid_t file) {
  const auto count = [file](const char* name) {
    return static_cast<int>(read_integer(file, name));
  };
  RecordColumns columns;
  columns.fingers = count("columns.fingers");
  columns.hand_values = count("columns.hand_values");
  columns.users = count("columns.users");
  columns.objects = count("columns.objects");
  columns.object_values = count("columns.object_values");
  columns.contacts = count("columns.contacts") != 0;
  columns.packet_values = count("columns.packet_values");
  check(columns);
  return columns;
}

}  // namespace

struct RecordingReader::File {
  QuietHdf5 quiet;  // first: nothing is printed, every error is thrown
  Hdf5Id file;
  RecordingHeader header;
  RecordColumns columns;
  RecordTable<core::TickRecord> ticks;
  RecordTable<core::PacketRecord> packets;
  bool complete = false;
  std::int64_t lost = 0;

  explicit File(const std::string& path)
      : file(open_file(path)),
        header(read_header(file)),
        columns(read_columns(file)),
        ticks(RecordTable<core::TickRecord>::open(file, "ticks", columns)),
        packets(RecordTable<core::PacketRecord>::open(file, "packets", columns)) {
    complete = H5Aexists(file, "complete") > 0;
    if (complete) {
      lost = read_integer(file, "records_lost");
    } else {
      ticks.trim();
      packets.trim();
    }
  }
};

RecordingReader::RecordingReader(const std::string& file) {
  try {
    file_ = std::make_unique<File>(file);
  } catch (const std::exception& error) {
    const std::string what = error.what();
    if (what.find(file) != std::string::npos) throw;
    throw RecordingError("recording \"" + file + "\" cannot be read: " + what);
  }
}
RecordingReader::~RecordingReader() = default;

const RecordingHeader& RecordingReader::header() const { return file_->header; }
const RecordColumns& RecordingReader::columns() const { return file_->columns; }
bool RecordingReader::complete() const { return file_->complete; }
std::int64_t RecordingReader::records_lost() const { return file_->lost; }
std::uint64_t RecordingReader::tick_count() const { return file_->ticks.rows(); }
std::uint64_t RecordingReader::packet_count() const { return file_->packets.rows(); }

std::vector<core::TickRecord> RecordingReader::ticks(std::uint64_t first, std::uint64_t count) {
  return file_->ticks.read(first, count);
}
std::vector<core::PacketRecord> RecordingReader::packets(std::uint64_t first, std::uint64_t count) {
  return file_->packets.read(first, count);
}

}  // namespace tandem::recording
