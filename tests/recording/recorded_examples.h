#pragma once

#include <bit>
#include <cstdint>
#include <string>

#include "core/records.h"
#include "recording/record_columns.h"

namespace tandem::test {

/// splitmix64 (Steele, Lea, Flood 2014).
inline std::uint64_t scrambled(std::uint64_t z) {
  z += 0x9e3779b97f4a7c15u;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return z ^ (z >> 31);
}

/// Sets every stored value of a record to bits that follow from `number` and its place: any double
/// may come up, NaN and denormal too.
struct FillColumns {
  std::uint64_t number;
  std::uint64_t place = 0;
  template <typename Value>
  void one(const char*, const char*, Value& value) {
    const std::uint64_t bits = scrambled(number * 1024 + ++place);
    if constexpr (std::is_same_v<Value, double>) {
      value = std::bit_cast<double>(bits);
    } else {
      value = static_cast<Value>(bits);
    }
  }
  template <typename Element>
  void many(const char* name, const char* unit, std::pair<int, int> shape, Element&& element) {
    for (int r = 0; r < shape.first; ++r)
      for (int c = 0; c < shape.second; ++c) one(name, unit, element(r, c));
  }
};

/// Whether every stored value has exactly the bits that FillColumns gave it.
struct CheckColumns {
  std::uint64_t number;
  std::uint64_t place = 0;
  int wrong = 0;
  template <typename Value>
  void one(const char*, const char*, const Value& value) {
    const std::uint64_t bits = scrambled(number * 1024 + ++place);
    if constexpr (std::is_same_v<Value, double>) {
      if (std::bit_cast<std::uint64_t>(value) != bits) ++wrong;
    } else {
      if (value != static_cast<Value>(bits)) ++wrong;
    }
  }
  template <typename Element>
  void many(const char* name, const char* unit, std::pair<int, int> shape, Element&& element) {
    for (int r = 0; r < shape.first; ++r)
      for (int c = 0; c < shape.second; ++c) one(name, unit, element(r, c));
  }
};

template <typename Record>
Record example(std::uint64_t number, const recording::RecordColumns& columns) {
  Record record;
  FillColumns fill{number};
  recording::visit_columns(record, columns, fill);
  return record;
}

template <typename Record>
bool is_example(const Record& record, std::uint64_t number,
                const recording::RecordColumns& columns) {
  CheckColumns check{number};
  recording::visit_columns(record, columns, check);
  return check.wrong == 0;
}

inline recording::RecordColumns planar_columns() {
  return {.fingers = 2,
          .hand_values = 2,
          .users = 2,
          .objects = 1,
          .object_values = 6,
          .contacts = true,
          .packet_values = 14};
}

inline recording::RecordingHeader some_header() {
  recording::RecordingHeader header;
  header.scene_text = "name: \"box\"  # mass \xC2\xB5, two lines\nversion: 1\n";
  header.scene_hash = "0123456789abcdef";
  header.git_revision = "abc";
  header.program_version = "0.1.0";
  header.user = "1";
  header.local_rate_hz = 1024.0;
  header.start_ns = 123'456'789'012'345;
  return header;
}

}  // namespace tandem::test
