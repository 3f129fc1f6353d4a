#include "harness/recorded_series.h"

#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <map>

#include <fmt/format.h>

#include "harness/sweep.h"

namespace tandem::harness {

namespace {

constexpr double kLost = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t kMostEntries = 4'000'000;

[[noreturn]] void fail(const std::string& file, std::size_t line, const std::string& why) {
  throw SweepError(line > 0 ? fmt::format("{}:{}: {}", file, line, why)
                            : fmt::format("{}: {}", file, why));
}

/// Calls `take(line, number)` for every line that is not empty.
template <typename Take>
void each_line(const std::string& file, Take&& take) {
  std::error_code ignored;
  if (std::filesystem::is_directory(file, ignored)) fail(file, 0, "is a folder; give a file in it");
  errno = 0;
  std::ifstream in(file);
  if (!in) fail(file, 0, std::string("cannot be read: ") + std::strerror(errno));
  std::size_t number = 0;
  for (std::string line; std::getline(in, line);) {
    ++number;
    if (!line.empty() && line.back() == '\r') line.pop_back();
    if (!line.empty()) take(line, number);
    if (number > kMostEntries) fail(file, number, "longer than 4 million lines; give a part of it");
  }
}

/// Whole text as a number; NaN also for "nan", and `ok` false for anything else.
double number_in(const std::string& text, bool& ok) {
  char* end = nullptr;
  const double x = std::strtod(text.c_str(), &end);
  ok = !text.empty() && *end == '\0';
  return x;
}

RecordedSeries finished(RecordedSeries series, const std::string& file) {
  if (series.time.empty()) fail(file, 0, "has no entry");
  const double start = series.time.front();
  for (double& t : series.time) t -= start;
  series.source = std::filesystem::path(file).filename().string();
  return series;
}

}  // namespace

RecordedSeries read_one_way(const std::string& file) {
  RecordedSeries series;
  each_line(file, [&](const std::string& line, std::size_t at) {
    if (at == 1) {
      if (line != "time_s,delay_s")
        fail(file, at, "the first line must be time_s,delay_s; it is '" + line.substr(0, 40) + "'");
      return;
    }
    const std::size_t comma = line.find(',');
    if (comma == std::string::npos) fail(file, at, "two columns are needed: time_s,delay_s");
    bool ok = false;
    const double time = number_in(line.substr(0, comma), ok);
    if (!ok || !std::isfinite(time)) fail(file, at, "time_s is no number");
    const std::string text = line.substr(comma + 1);
    const double delay = text.empty() ? (ok = true, kLost) : number_in(text, ok);
    if (!ok || std::isinf(delay) || delay < 0.0)
      fail(file, at, "delay_s '" + text + "' must be a number of at least 0, or empty for lost");
    if (!series.time.empty() && !(time > series.time.back()))
      fail(file, at,
           fmt::format("time {:g} s does not come after {:g} s", time, series.time.back()));
    series.time.push_back(time);
    series.delay.push_back(delay);
  });
  return finished(std::move(series), file);
}

RecordedSeries read_round_trips(const std::string& file) {
  RecordedSeries series;
  double time = 0.0;
  each_line(file, [&](const std::string& line, std::size_t at) {
    bool ok = false;
    const double trip = 1e-3 * number_in(line, ok);
    if (!ok || !(trip > 0.0 && trip < 1e3))
      fail(file, at,
           "'" + line.substr(0, 40) +
               "' is no round trip; one number in milliseconds a line, more than 0");
    series.time.push_back(time);
    series.delay.push_back(0.5 * trip);
    time += trip;
  });
  return finished(std::move(series), file);
}

RecordedSeries read_stamps(const std::string& sent, const std::string& received) {
  const auto read = [](const std::string& file) {
    std::vector<std::pair<long long, std::string>> stamps;
    each_line(file, [&](const std::string& line, std::size_t at) {
      char* end = nullptr;
      const long long stamp = std::strtoll(line.c_str(), &end, 10);
      if (end == line.c_str() || *end != ',')
        fail(file, at, "'" + line.substr(0, 40) + "' is not STAMP_NS,PACKET");
      stamps.emplace_back(stamp, end + 1);
    });
    return stamps;
  };
  std::multimap<std::string, long long> arrivals;
  for (const auto& [stamp, name] : read(received)) arrivals.emplace(name, stamp);
  RecordedSeries series;
  long long first = 0;
  for (const auto& [stamp, name] : read(sent)) {
    if (series.time.empty()) first = stamp;
    const double time = 1e-9 * static_cast<double>(stamp - first);
    if (!series.time.empty() && !(time > series.time.back())) continue;  // the same stamp twice
    // The earliest arrival of this name that is not before it left: names may come again.
    auto [from, to] = arrivals.equal_range(name);
    auto best = arrivals.end();
    for (auto i = from; i != to; ++i)
      if (i->second >= stamp && (best == arrivals.end() || i->second < best->second)) best = i;
    const double delay =
        best == arrivals.end() ? kLost : 1e-9 * static_cast<double>(best->second - stamp);
    series.time.push_back(time);
    series.delay.push_back(delay > 60.0 ? kLost : delay);
    if (best != arrivals.end()) arrivals.erase(best);
  }
  return finished(std::move(series), sent);
}

}  // namespace tandem::harness
