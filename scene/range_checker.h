#pragma once

#include <cmath>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "scene/scene_error.h"
#include "scene/scene_fields.h"

namespace tandem::scene {

/// Visitor of scene_fields.h: every number finite and in its range, every list short enough.
class RangeChecker {
 public:
  RangeChecker(std::string path, std::vector<Problem>& problems)
      : path_(std::move(path)), problems_(problems) {}

  void where(std::string_view) {}

  template <typename T>
  void value(const Field& field, T& value) {
    if constexpr (std::is_same_v<T, double> || std::is_same_v<T, int>) {
      const double x = static_cast<double>(value);
      const bool low_enough = x <= field.high;
      const bool high_enough = field.above_low ? x > field.low : x >= field.low;
      if (std::isfinite(x) && low_enough && high_enough) return;  // NaN fails all three
      const std::string path = path_ + std::string(field.name);
      const std::string unit = field.unit.empty() ? "" : " " + std::string(field.unit);
      problems_.push_back({path,
                           path + " = " + number_text(x) + unit + ": must be " +
                               (field.above_low ? "above " : "at least ") + number_text(field.low) +
                               " and at most " + number_text(field.high) + unit,
                           {}});
    }
  }

  template <typename Fn>
  void group(const Field& field, Fn&& fn) {
    RangeChecker sub(path_ + std::string(field.name) + ".", problems_);
    fn(sub);
  }

  template <typename T, typename Fn>
  void optional_group(const Field& field, std::optional<T>& part, Fn&& fn) {
    if (part) group(field, [&](auto& sub) { fn(*part, sub); });
  }

  template <typename T, typename Fn>
  void list(const Field& field, std::vector<T>& entries, int max, Fn&& fn) {
    const std::string path = path_ + std::string(field.name);
    if (entries.size() > static_cast<std::size_t>(max))
      problems_.push_back({path,
                           path + ": " + std::to_string(entries.size()) + " entries, at most " +
                               std::to_string(max) + " are possible",
                           {}});
    for (std::size_t i = 0; i < entries.size(); ++i) {
      RangeChecker sub(path + "." + entry_key(entries[i], i) + ".", problems_);
      fn(entries[i], sub);
    }
  }

 private:
  std::string path_;
  std::vector<Problem>& problems_;
};

}  // namespace tandem::scene
