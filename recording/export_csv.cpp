#include "recording/export_csv.h"

#include <ostream>
#include <string>
#include <utility>

#include <fmt/format.h>

namespace tandem::recording {
namespace {

struct Heading {
  std::string line{};
  template <typename Value>
  void one(const char* name, const char*, const Value&) {
    add(name);
  }
  template <typename Element>
  void many(const char* name, const char*, std::pair<int, int> shape, Element&&) {
    for (int r = 0; r < shape.first; ++r) {
      for (int c = 0; c < shape.second; ++c) {
        add(shape.first == 1 ? fmt::format("{}[{}]", name, c)
                             : fmt::format("{}[{}][{}]", name, r, c));
      }
    }
  }
  void add(const std::string& name) { line += (line.empty() ? "" : ",") + name; }
};

struct Line {
  std::string line{};
  template <typename Value>
  void one(const char*, const char*, const Value& value) {
    line += fmt::format("{}{}", line.empty() ? "" : ",", value);
  }
  template <typename Element>
  void many(const char* name, const char* unit, std::pair<int, int> shape, Element&& element) {
    for (int r = 0; r < shape.first; ++r)
      for (int c = 0; c < shape.second; ++c) one(name, unit, element(r, c));
  }
};

template <typename Record, typename Read>
void export_rows(const RecordColumns& columns, std::uint64_t count, Read&& read, std::ostream& to) {
  Heading heading;
  visit_columns(Record{}, columns, heading);
  to << heading.line << '\n';
  constexpr std::uint64_t kAtOnce = 4096;
  for (std::uint64_t first = 0; first < count; first += kAtOnce) {
    for (const Record& record : read(first, kAtOnce)) {
      Line line;
      visit_columns(record, columns, line);
      to << line.line << '\n';
    }
  }
}

}  // namespace

void export_ticks_csv(RecordingReader& recording, std::ostream& to) {
  export_rows<core::TickRecord>(
      recording.columns(), recording.tick_count(),
      [&](std::uint64_t first, std::uint64_t count) { return recording.ticks(first, count); }, to);
}

void export_packets_csv(RecordingReader& recording, std::ostream& to) {
  export_rows<core::PacketRecord>(
      recording.columns(), recording.packet_count(),
      [&](std::uint64_t first, std::uint64_t count) { return recording.packets(first, count); },
      to);
}

}  // namespace tandem::recording
