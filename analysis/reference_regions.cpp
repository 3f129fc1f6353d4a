#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "analysis/reference_kinds.h"
#include "analysis/stability.h"

namespace tandem::analysis::reference {

namespace {

constexpr double kBoundaryLimit = 1e-6;
constexpr double kInfinite = std::numeric_limits<double>::infinity();

std::string text_of(const std::vector<Interval>& intervals) {
  std::string out;
  for (const Interval& i : intervals) {
    char text[80];
    std::snprintf(text, sizeof text, "%s%.10g:%.10g", out.empty() ? "" : " ", i.low, i.high);
    out += text;
  }
  return out.empty() ? "none" : out;
}

double off(double a, double b) { return std::abs(a - b) / std::max(std::abs(b), 1e-300); }

void interval(const std::vector<std::string>& f, Case& c, CheckRow& row) {
  const Knob knob(c.scene, long_field(f.at(5)));
  std::vector<Interval> expected;
  if (f.at(8) != "none")
    for (const std::string& part : split(f.at(8), ' ')) {
      const auto ends = split(part, ':');
      expected.push_back({to_number(ends.at(0)), to_number(ends.at(1))});
    }
  StabilityJudge judge(c.scene, c.network);
  const auto found = stable_intervals(judge, c.scene, knob, to_number(f.at(6)), to_number(f.at(7)));
  row.expected = text_of(expected);
  row.found = text_of(found);
  row.limit = kBoundaryLimit;
  if (found.size() != expected.size()) {
    row.deviation = kInfinite;
    return;
  }
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (found[i].low != expected[i].low)
      row.deviation = std::max(row.deviation, off(found[i].low, expected[i].low));
    row.deviation = std::max(row.deviation, off(found[i].high, expected[i].high));
  }
}

Axis axis_of(const std::vector<std::string>& f, std::size_t at) {
  return {to_number(f.at(at)), to_number(f.at(at + 1)), static_cast<int>(to_number(f.at(at + 2)))};
}

/// Pieces of the cells that are `wanted`, next to each other by edges (or corners); of them those
/// that do not touch the rim.
struct Pieces {
  int all = 0, inside = 0;
};
Pieces pieces_of(const std::vector<std::uint8_t>& cells, int columns, int rows, bool wanted,
                 bool corners) {
  Pieces out;
  std::vector<std::uint8_t> seen(cells.size(), 0);
  std::vector<int> stack;
  for (int start = 0; start < columns * rows; ++start) {
    if (seen[start] != 0 || (cells[start] != 0) != wanted) continue;
    bool rim = false;
    seen[start] = 1;
    stack.push_back(start);
    while (!stack.empty()) {
      const int at = stack.back(), x = at % columns, y = at / columns;
      stack.pop_back();
      rim = rim || x == 0 || y == 0 || x == columns - 1 || y == rows - 1;
      for (int dx = -1; dx <= 1; ++dx)
        for (int dy = -1; dy <= 1; ++dy) {
          const int nx = x + dx, ny = y + dy, next = nx + columns * ny;
          if ((!corners && dx != 0 && dy != 0) || nx < 0 || ny < 0 || nx >= columns || ny >= rows)
            continue;
          if (seen[next] != 0 || (cells[next] != 0) != wanted) continue;
          seen[next] = 1;
          stack.push_back(next);
        }
    }
    ++out.all;
    out.inside += rim ? 0 : 1;
  }
  return out;
}

void count(const std::vector<std::string>& f, Case& c, CheckRow& row) {
  const Knob x(c.scene, long_field(f.at(5))), y(c.scene, long_field(f.at(9)));
  const Axis across = axis_of(f, 6), up = axis_of(f, 10);
  const StabilityJudge judge(c.scene, c.network);
  const StabilityMap map = stability_map(judge, c.scene, x, across, y, up);
  const int pieces = pieces_of(map.stable, across.count, up.count, true, false).all;
  const int holes = pieces_of(map.stable, across.count, up.count, false, true).inside;
  const long found[] = {static_cast<long>(map.count), map.rows_apart, map.columns_apart, pieces,
                        holes};
  for (int i = 0; i < 5; ++i) {
    const std::string& expected = f.at(static_cast<std::size_t>(13 + i));
    row.expected += (i == 0 ? "" : " ") + expected;
    row.found += (i == 0 ? "" : " ") + std::to_string(found[i]);
    row.deviation += std::abs(static_cast<double>(found[i]) - to_number(expected));
  }
}

/// Smallest |rho - 1| over the cells of a map.
void nearest(const std::vector<std::string>& f, Case& c, CheckRow& row) {
  const Knob x(c.scene, long_field(f.at(5))), y(c.scene, long_field(f.at(9)));
  const Axis across = axis_of(f, 6), up = axis_of(f, 10);
  StabilityJudge judge(c.scene, c.network);
  double least = kInfinite;
  for (int i = 0; i < across.count; ++i)
    for (int j = 0; j < up.count; ++j) {
      x.set(c.scene, across.centre(i));
      y.set(c.scene, up.centre(j));
      least = std::min(least, std::abs(judge.radius(c.scene) - 1.0));
    }
  const double expected = to_number(f.at(13));
  compare(least, expected, 0.0, row);
  row.deviation = std::abs(least - expected);  // of rho, absolute
  row.limit = 1e-10;
}

/// Smallest spectral radius over a grid with equal ratios between neighbours.
void least(const std::vector<std::string>& f, Case& c, CheckRow& row) {
  const Knob x(c.scene, long_field(f.at(5))), y(c.scene, long_field(f.at(9)));
  const Axis across = axis_of(f, 6), up = axis_of(f, 10);
  const auto at = [](const Axis& a, int i) {
    return a.from * std::pow(a.to / a.from, i / (a.count - 1.0));
  };
  StabilityJudge judge(c.scene, c.network);
  double best = kInfinite;
  for (int i = 0; i < across.count; ++i)
    for (int j = 0; j < up.count; ++j) {
      x.set(c.scene, at(across, i));
      y.set(c.scene, at(up, j));
      best = std::min(best, judge.radius(c.scene));
    }
  compare(best, to_number(f.at(13)), 1e-10, row);
}

/// Where a row of a map falls apart in two: the smallest upper end of the first stable interval of
/// one knob over the values of the other.
void fold(const std::vector<std::string>& f, Case& c, CheckRow& row) {
  const Knob a(c.scene, long_field(f.at(5))), b(c.scene, long_field(f.at(8)));
  const double from = to_number(f.at(6)), to = to_number(f.at(7));
  StabilityJudge judge(c.scene, c.network);
  const auto end = [&](double value) {
    b.set(c.scene, value);
    const auto found = stable_intervals(judge, c.scene, a, from, to, {60, 1e-13});
    return found.empty() ? from : found[0].high;
  };
  // The end is smooth with one minimum in the range: golden section.
  constexpr double kGolden = 0.6180339887498949;
  double low = to_number(f.at(9)), high = to_number(f.at(10));
  double x1 = high - kGolden * (high - low), x2 = low + kGolden * (high - low);
  double f1 = end(x1), f2 = end(x2);
  while (high - low > 1e-6 * high) {
    if (f1 < f2) {
      high = x2, x2 = x1, f2 = f1;
      x1 = high - kGolden * (high - low), f1 = end(x1);
    } else {
      low = x1, x1 = x2, f1 = f2;
      x2 = low + kGolden * (high - low), f2 = end(x2);
    }
  }
  compare(std::min(f1, f2), to_number(f.at(11)), kBoundaryLimit, row);
  char text[40];
  std::snprintf(text, sizeof text, " at %.6g", 0.5 * (low + high));
  row.found += text;
  std::snprintf(text, sizeof text, " at %.6g", to_number(f.at(12)));
  row.expected += text;
  // A flat minimum is found to the root of what its value is found to.
  if (off(0.5 * (low + high), to_number(f.at(12))) > 1e-4) row.deviation = kInfinite;
}

/// Changes of stability on a grid with equal steps, given as the middles between grid points.
void scan(const std::vector<std::string>& f, Case& c, CheckRow& row) {
  const Knob knob(c.scene, long_field(f.at(5)));
  const double from = to_number(f.at(6)), to = to_number(f.at(7));
  const int points = static_cast<int>(to_number(f.at(8)));
  StabilityJudge judge(c.scene, c.network);
  std::vector<double> expected, changes;
  if (f.at(10) != "none")
    for (const std::string& x : split(f.at(10), ' ')) expected.push_back(to_number(x));
  bool first = false, before = false;
  for (int i = 0; i < points; ++i) {
    knob.set(c.scene, from + i * (to - from) / (points - 1.0));
    const bool stable = judge.margin(c.scene) > 0.0;
    if (i == 0) first = stable;
    if (i > 0 && stable != before)
      changes.push_back(from + (i - 0.5) * (to - from) / (points - 1.0));
    before = stable;
  }
  row.limit = 1e-12;
  row.expected = f.at(9) + " " + f.at(10);
  row.found = first ? "1" : "0";
  char text[40];
  for (const double x : changes) {
    std::snprintf(text, sizeof text, " %.13g", x);
    row.found += text;
  }
  if (changes.empty()) row.found += " none";
  if (first != (f.at(9) == "1") || changes.size() != expected.size()) row.deviation = kInfinite;
  for (std::size_t i = 0; i < std::min(changes.size(), expected.size()); ++i)
    row.deviation = std::max(row.deviation, off(changes[i], expected[i]));
}

/// Common factor of several fields at which stability ends, expected to be one.
void edge(const std::vector<std::string>& f, Case& c, CheckRow& row) {
  std::vector<std::pair<Knob, double>> knobs;
  for (const std::string& word : split(f.at(5), ' ')) {
    const auto sides = split(word, '=');
    knobs.emplace_back(Knob(c.scene, long_field(sides.at(0))), to_number(sides.at(1)));
  }
  StabilityJudge judge(c.scene, c.network);
  const auto stable = [&](double factor) {
    for (const auto& [knob, value] : knobs) knob.set(c.scene, factor * value);
    return judge.radius(c.scene) < 1.0;
  };
  double low = 0.9, high = 1.1;
  if (!stable(low) || stable(high)) {
    compare(kInfinite, to_number(f.at(6)), kBoundaryLimit, row);
    return;
  }
  while (high - low > 1e-12) {
    const double middle = 0.5 * (low + high);
    (stable(middle) ? low : high) = middle;
  }
  const double expected = to_number(f.at(6));
  compare(low * expected, expected, kBoundaryLimit, row);
}

}  // namespace

bool compute_region(const std::vector<std::string>& f, Case& c, CheckRow& row) {
  if (row.kind == "interval") return interval(f, c, row), true;
  if (row.kind == "count") return count(f, c, row), true;
  if (row.kind == "nearest") return nearest(f, c, row), true;
  if (row.kind == "least") return least(f, c, row), true;
  if (row.kind == "fold") return fold(f, c, row), true;
  if (row.kind == "scan") return scan(f, c, row), true;
  if (row.kind == "edge") return edge(f, c, row), true;
  return false;
}

}  // namespace tandem::analysis::reference
