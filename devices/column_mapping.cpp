#include "devices/column_mapping.h"

#include <charconv>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace tandem::devices {
namespace {

[[noreturn]] void refuse(std::string_view key, std::string_view value, std::string_view allowed) {
  throw std::invalid_argument("recorded hand: " + std::string(key) + "=" + std::string(value) +
                              " is not understood; allowed is " + std::string(allowed));
}

double number(std::string_view key, std::string_view whole, std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || !std::isfinite(value)) {
    refuse(key, whole, "a number where \"" + std::string(text) + "\" stands");
  }
  return value;
}

double not_negative(std::string_view key, std::string_view text) {
  const double value = number(key, text, text);
  if (value < 0.0) refuse(key, text, "a number that is not negative");
  return value;
}

/// Cuts `text` at the first of `marks`; the rest keeps its mark.
std::string_view take_until(std::string_view& text, std::string_view marks) {
  const std::size_t end = std::min(text.find_first_of(marks), text.size());
  const std::string_view taken = text.substr(0, end);
  text.remove_prefix(end);
  return taken;
}

double unit_of_time(std::string_view key, std::string_view whole, std::string_view unit) {
  if (unit == "s") return 1.0;
  if (unit == "ms") return 1e-3;
  if (unit == "us") return 1e-6;
  if (unit == "ns") return 1e-9;
  refuse(key, whole, "the unit s, ms, us or ns");
}

double unit_of_length(std::string_view key, std::string_view whole, std::string_view unit) {
  if (unit == "m") return 1.0;
  if (unit == "mm") return 1e-3;
  if (unit == "cm") return 1e-2;
  const std::string_view name = take_until(unit, "@");
  if ((name == "rad" || name == "deg") && !unit.empty()) {
    const double arm = number(key, whole, unit.substr(1));
    return name == "rad" ? arm : arm * std::numbers::pi / 180.0;
  }
  refuse(key, whole, "the unit m, mm, cm, rad@ARM or deg@ARM, ARM the lever in metres");
}

MappedColumn column(std::string_view key, std::string_view whole, bool is_time) {
  constexpr std::string_view kMarks = ":*+";
  std::string_view rest = whole;
  MappedColumn mapped;
  mapped.column = take_until(rest, kMarks);
  if (mapped.column.empty()) refuse(key, whole, "a column's name or #number");
  while (!rest.empty()) {
    const char mark = rest.front();
    rest.remove_prefix(1);
    const bool signed_exponent = mark != ':';
    std::string_view part = take_until(rest, kMarks);
    // "1e+3": the plus belongs to the number.
    std::string joined(part);
    if (signed_exponent && (joined.ends_with('e') || joined.ends_with('E')) &&
        rest.starts_with('+')) {
      rest.remove_prefix(1);
      joined += take_until(rest, kMarks);
    }
    if (mark == ':') {
      mapped.scale *= is_time ? unit_of_time(key, whole, part) : unit_of_length(key, whole, part);
    } else if (mark == '*') {
      mapped.scale *= number(key, whole, joined);
    } else {
      mapped.offset += number(key, whole, joined);
    }
  }
  return mapped;
}

void set(ColumnMapping& mapping, std::string_view key, std::string_view value) {
  if (key == "time") {
    mapping.time = column(key, value, true);
  } else if (key == "x" || key == "y" || key == "z") {
    mapping.position[static_cast<std::size_t>(key[0] - 'x')] = column(key, value, false);
  } else if (key == "rate_hz") {
    mapping.rate_hz = number(key, value, value);
    if (!(mapping.rate_hz > 0.0)) refuse(key, value, "a rate above 0 Hz");
  } else if (key == "finger") {
    mapping.finger = static_cast<int>(not_negative(key, value));
  } else if (key == "start") {
    mapping.start = not_negative(key, value);
  } else if (key == "stop") {
    mapping.stop = not_negative(key, value);
  } else if (key == "seam") {
    mapping.seam = not_negative(key, value);
  } else if (key == "origin") {
    if (value != "zero" && value != "first") refuse(key, value, "zero or first");
    mapping.from_first = value == "first";
  } else if (key == "interpolation") {
    if (value != "cubic" && value != "linear") refuse(key, value, "cubic or linear");
    mapping.interpolation = value == "cubic" ? Interpolation::kCubic : Interpolation::kLinear;
  } else if (key == "end") {
    if (value != "hold" && value != "loop") refuse(key, value, "hold or loop");
    mapping.end = value == "loop" ? PathEnd::kLoop : PathEnd::kHold;
  } else if (key == "mode") {
    if (value != "kinematic" && value != "driving") refuse(key, value, "kinematic or driving");
    mapping.mode = value == "driving" ? RecordedMode::kDriving : RecordedMode::kKinematic;
  } else {
    refuse(key, value,
           "time, rate_hz, x, y, z, finger, start, stop, seam, origin, interpolation, end, mode");
  }
}

}  // namespace

ColumnMapping parse_column_mapping(std::string_view text) {
  ColumnMapping mapping;
  while (!text.empty()) {
    std::string_view value = take_until(text, ",");
    if (!text.empty()) text.remove_prefix(1);
    const std::string_view key = take_until(value, "=");
    if (value.size() < 2) refuse(key, "", "KEY=VALUE");
    set(mapping, key, value.substr(1));
  }
  if (mapping.start >= mapping.stop) {
    refuse("start", std::to_string(mapping.start),
           "less than stop, which is " + std::to_string(mapping.stop) + " s");
  }
  return mapping;
}

}  // namespace tandem::devices
