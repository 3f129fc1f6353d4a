#include "devices/load_recorded_path.h"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <limits>
#include <stdexcept>
#include <utility>
#include <vector>

#include "devices/csv_table.h"
#include "recording/recording_reader.h"

namespace tandem::devices {
namespace {

std::vector<PathSample> samples_of_csv(const std::string& file, const ColumnMapping& mapping) {
  std::vector<std::string> wanted;
  std::vector<std::pair<int, MappedColumn>> meaning;  // coordinate, or -1 for time
  if (!mapping.time.column.empty()) meaning.emplace_back(-1, mapping.time);
  for (int i = 0; i < 3; ++i) {
    const MappedColumn& column = mapping.position[static_cast<std::size_t>(i)];
    if (!column.column.empty()) meaning.emplace_back(i, column);
  }
  const bool timed = !mapping.time.column.empty();
  // A file that cannot be read is said before what is missing of its columns.
  if (!std::ifstream(file))
    throw std::runtime_error("\"" + file + "\" cannot be read: " + std::strerror(errno));
  if (timed == (mapping.rate_hz > 0.0)) {
    throw std::runtime_error(
        "\"" + file + "\": the columns (--hand-columns) say " +
        (timed ? "both time=COLUMN and rate_hz=RATE; give one of them"
               : "neither time=COLUMN nor rate_hz=RATE; give one, for example time=t_s,y=y_m"));
  }
  if (meaning.size() == (timed ? 1u : 0u)) {
    throw std::runtime_error("\"" + file +
                             "\": the columns (--hand-columns) do not say which is the position: "
                             "x=COLUMN, y=COLUMN or z=COLUMN");
  }
  for (const auto& [what, column] : meaning) wanted.push_back(column.column);
  const auto columns = read_csv_columns(file, wanted);
  std::vector<PathSample> samples(columns.front().size());
  for (std::size_t row = 0; row < samples.size(); ++row) {
    if (!timed) samples[row].time = static_cast<double>(row) / mapping.rate_hz;
    for (std::size_t c = 0; c < meaning.size(); ++c) {
      const MappedColumn& column = meaning[c].second;
      const double value = columns[c][row] * column.scale + column.offset;
      if (meaning[c].first < 0) {
        samples[row].time = value;
      } else {
        samples[row].position[meaning[c].first] = value;
      }
    }
  }
  return samples;
}

std::vector<PathSample> samples_of_recording(const std::string& file, int finger) {
  recording::RecordingReader reader(file);
  if (finger >= reader.columns().fingers) {
    throw std::runtime_error("\"" + file + "\": finger is " + std::to_string(finger) +
                             ", the recording has " + std::to_string(reader.columns().fingers) +
                             ", counted from 0");
  }
  const double rate_hz = reader.header().local_rate_hz;
  if (!(rate_hz > 0.0)) throw std::runtime_error("\"" + file + "\" does not say its local rate");
  std::vector<PathSample> samples;
  std::int64_t first_slot = 0;
  constexpr std::uint64_t kAtOnce = 4096;
  for (std::uint64_t first = 0; first < reader.tick_count(); first += kAtOnce) {
    for (const core::TickRecord& tick : reader.ticks(first, kAtOnce)) {
      if (samples.empty()) first_slot = tick.slot;
      samples.push_back({static_cast<double>(tick.slot - first_slot) / rate_hz,
                         tick.hands[static_cast<std::size_t>(finger)].position});
    }
  }
  return samples;
}

}  // namespace

RecordedPath load_recorded_path(const std::string& file, const ColumnMapping& mapping) {
  const bool is_recording = file.ends_with(".h5") || file.ends_with(".hdf5");
  std::vector<PathSample> all =
      is_recording ? samples_of_recording(file, mapping.finger) : samples_of_csv(file, mapping);
  std::vector<PathSample> kept;
  for (const PathSample& sample : all) {
    const double since = sample.time - all.front().time;
    // Not-a-number is kept, so that it is refused below and not silently left out.
    if (since < mapping.start || since > mapping.stop) continue;
    kept.push_back(sample);
  }
  if (mapping.from_first && !kept.empty()) {
    const Vec3 origin = kept.front().position;
    for (PathSample& sample : kept) sample.position -= origin;
  }
  try {
    return RecordedPath(std::move(kept), mapping.interpolation, mapping.end, mapping.seam);
  } catch (const std::invalid_argument& error) {
    throw std::runtime_error("\"" + file + "\": " + error.what());
  }
}

RecordedSource parse_recorded_source(const std::string& text) {
  const std::size_t mark = text.find('?');
  RecordedSource source;
  source.file = text.substr(0, mark);
  if (mark != std::string::npos) source.mapping = parse_column_mapping(text.substr(mark + 1));
  return source;
}

}  // namespace tandem::devices
