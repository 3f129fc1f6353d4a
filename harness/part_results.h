#pragma once

#include <optional>
#include <string>
#include <vector>

#include "harness/point_result.h"
#include "harness/sweep.h"

namespace tandem::harness {

/// Where several run one sweep: worker `index` of `count` has every count-th point. Architectures
/// and styles alternate so, and with an even number of steps no condition is probed twice.
struct SweepPart {
  std::size_t index = 0, count = 1;
  [[nodiscard]] bool has(std::size_t point) const { return point % count == index; }
  /// "1/2" for the first of two.
  [[nodiscard]] std::string text() const;
  /// Nothing where it is no such text.
  [[nodiscard]] static std::optional<SweepPart> parse(const std::string& text);
};

/// What one worker has found. Of the points themselves, which who reads it has as well, only names
/// are kept.
struct PartResults {
  struct Point {
    std::size_t index = 0;  ///< in the whole sweep
    PointResult result;
  };
  std::string setting;  ///< its kernel and what that granted
  std::vector<Point> points;
  std::vector<DelayBoundary> boundaries;  ///< all, with what its own sessions say
};

/// As CBOR, which has infinity and what is no number; every field, by reflection.
[[nodiscard]] std::vector<std::uint8_t> pack(const PartResults& part);
/// Throws HarnessError for what is no whole part.
[[nodiscard]] PartResults unpack(const std::vector<std::uint8_t>& bytes);

void write_part(const std::string& file, const PartResults& part);
[[nodiscard]] PartResults read_part(const std::string& file);

/// All results in the order of the sweep, with its points in them. Throws HarnessError when one is
/// missing, there twice, or of another name.
[[nodiscard]] std::vector<PointResult> join_points(const Sweep& sweep,
                                                   const std::vector<PartResults>& parts);
/// What the sockets of all parts say of boundaries. Throws HarnessError when a part has others.
void join_boundaries(std::vector<DelayBoundary>& boundaries, const std::vector<PartResults>& parts);

}  // namespace tandem::harness
