#include "harness/part_results.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <iterator>
#include <type_traits>

#include <boost/pfr.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "harness/harness_error.h"

namespace tandem::harness {
namespace {

using nlohmann::json;

template <typename T>
inline constexpr bool kIsList = false;
template <typename T>
inline constexpr bool kIsList<std::vector<T>> = true;
template <typename T>
inline constexpr bool kIsPlain = std::is_arithmetic_v<T> || std::is_same_v<T, std::string>;

/// A structure is the list of its fields.
template <typename T>
[[nodiscard]] json encode(const T& value) {
  if constexpr (kIsPlain<T>) {
    return value;
  } else if constexpr (std::is_same_v<T, SweepPoint>) {
    return value.name;
  } else {
    json list = json::array();
    if constexpr (kIsList<T>)
      for (const auto& entry : value) list.push_back(encode(entry));
    else
      boost::pfr::for_each_field(value, [&](const auto& field) { list.push_back(encode(field)); });
    return list;
  }
}

template <typename T>
void decode(const json& from, T& value) {
  if constexpr (kIsPlain<T>) {
    from.get_to(value);
  } else if constexpr (std::is_same_v<T, SweepPoint>) {
    from.get_to(value.name);
  } else if constexpr (kIsList<T>) {
    if (!from.is_array()) throw HarnessError("no list where there should be one");
    for (const json& entry : from) decode(entry, value.emplace_back());
  } else {
    if (!from.is_array() || from.size() != boost::pfr::tuple_size_v<T>)
      throw HarnessError(fmt::format("{} fields where there should be {}", from.size(),
                                     boost::pfr::tuple_size_v<T>));
    boost::pfr::for_each_field(value, [&](auto& field, std::size_t i) { decode(from[i], field); });
  }
}

}  // namespace

std::string SweepPart::text() const { return fmt::format("{}/{}", index + 1, count); }

std::optional<SweepPart> SweepPart::parse(const std::string& text) {
  SweepPart part;
  std::size_t number = 0;
  const char* end = text.data() + text.size();
  const auto first = std::from_chars(text.data(), end, number);
  if (first.ec != std::errc() || first.ptr == end || *first.ptr != '/') return std::nullopt;
  const auto second = std::from_chars(first.ptr + 1, end, part.count);
  if (second.ec != std::errc() || second.ptr != end) return std::nullopt;
  if (number < 1 || number > part.count) return std::nullopt;
  part.index = number - 1;
  return part;
}

std::vector<std::uint8_t> pack(const PartResults& part) { return json::to_cbor(encode(part)); }

PartResults unpack(const std::vector<std::uint8_t>& bytes) {
  PartResults part;
  try {
    decode(json::from_cbor(bytes), part);
  } catch (const json::exception& e) {
    throw HarnessError(e.what());
  }
  return part;
}

void write_part(const std::string& file, const PartResults& part) {
  const std::vector<std::uint8_t> bytes = pack(part);
  std::ofstream out(file, std::ios::binary);
  out.write(reinterpret_cast<const char*>(bytes.data()), std::ssize(bytes));
  out.close();
  if (!out) throw HarnessError("cannot write " + file + ": disk full or no such folder");
}

PartResults read_part(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  try {
    if (!in) throw HarnessError("there is no such file");
    return unpack({std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()});
  } catch (const HarnessError& e) {
    throw HarnessError(fmt::format("results of a part of the sweep, {}: {}", file, e.what()));
  }
}

std::vector<PointResult> join_points(const Sweep& sweep, const std::vector<PartResults>& parts) {
  std::vector<PointResult> joined(sweep.points.size());
  std::vector<int> times(sweep.points.size(), 0);
  for (const PartResults& part : parts)
    for (const PartResults::Point& found : part.points) {
      const std::string& name = found.result.point.name;
      if (found.index >= joined.size() || sweep.points[found.index].name != name)
        throw HarnessError(
            fmt::format("a part of the sweep has a point {} as number {}, the sweep "
                        "has not",
                        name, found.index + 1));
      joined[found.index] = found.result;
      joined[found.index].point = sweep.points[found.index];
      ++times[found.index];
    }
  for (std::size_t i = 0; i < times.size(); ++i)
    if (times[i] != 1)
      throw HarnessError(fmt::format("{} parts of the sweep have its point {}, which one should",
                                     times[i], sweep.points[i].name));
  return joined;
}

void join_boundaries(std::vector<DelayBoundary>& boundaries,
                     const std::vector<PartResults>& parts) {
  for (const PartResults& part : parts) {
    if (part.boundaries.size() != boundaries.size())
      throw HarnessError("a part of the sweep has other boundaries in delay");
    for (std::size_t i = 0; i < boundaries.size(); ++i) {
      const DelayBoundary& found = part.boundaries[i];
      DelayBoundary& all = boundaries[i];
      if (found.scene != all.scene)
        throw HarnessError("a part of the sweep has other boundaries in delay: " + found.scene);
      all.tick = found.tick;
      // What is no number gives way.
      all.real_stable = std::fmax(all.real_stable, found.real_stable);
      all.real_not_stable = std::fmin(all.real_not_stable, found.real_not_stable);
      all.failure += found.failure;
    }
  }
}

}  // namespace tandem::harness
