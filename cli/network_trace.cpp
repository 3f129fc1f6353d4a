#include "cli/network_trace.h"

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <deque>
#include <fstream>
#include <stdexcept>
#include <unordered_map>

#include <fmt/format.h>

namespace tandem::cli {

namespace {

constexpr double kLongest = 60.0;  // [s] what takes longer is another unit

/// Calls `use(line, number of the line)` for every line that is neither empty nor a comment.
template <typename Use>
void for_each_line(const std::string& file, Use&& use) {
  std::ifstream in(file);
  if (!in) throw std::runtime_error(file + ": cannot be read");
  std::string line;
  for (std::int64_t number = 1; std::getline(in, line); ++number) {
    if (!line.empty() && line.back() == '\r') line.pop_back();
    if (line.find_first_not_of(" \t") == std::string::npos || line.front() == '#') continue;
    use(line, number);
  }
  if (in.bad()) throw std::runtime_error(file + ": reading failed");
}

[[noreturn]] void wrong(const std::string& file, std::int64_t number, const std::string& line,
                        const std::string& wanted) {
  throw std::runtime_error(
      fmt::format("{}, line {}: '{}': {}", file, number, line.substr(0, 60), wanted));
}

struct Seen {
  std::int64_t ns = 0;
  std::string id;
};

std::vector<Seen> read_capture(const std::string& file) {
  std::vector<Seen> all;
  for_each_line(file, [&](const std::string& line, std::int64_t number) {
    char* end = nullptr;
    const long long ns = std::strtoll(line.c_str(), &end, 10);
    if (end == line.c_str() || *end != ',' || end[1] == '\0')
      wrong(file, number, line, "a line is TIME_IN_NS,PACKET");
    all.push_back({ns, end + 1});
  });
  if (all.empty()) throw std::runtime_error(file + ": no packets in it");
  return all;
}

}  // namespace

std::vector<double> NetworkTrace::in_ticks(double local_hz) const {
  std::vector<double> ticks;
  ticks.reserve(delays.size());
  for (const double s : delays) ticks.push_back(s < 0.0 ? -1.0 : s * local_hz);
  return ticks;
}

NetworkTrace read_delays(const std::string& file, bool round_trip) {
  NetworkTrace trace;
  for_each_line(file, [&](const std::string& line, std::int64_t number) {
    char* end = nullptr;
    const double ms = std::strtod(line.c_str(), &end);
    const std::string rest(end);
    if (end == line.c_str() || rest.find_first_not_of(" \t,;") != std::string::npos)
      wrong(file, number, line, "a line is one delay in milliseconds, or nan for a lost packet");
    const double s = 1e-3 * ms * (round_trip ? 0.5 : 1.0);
    if (ms < 0.0 || s > kLongest)
      wrong(file, number, line, "delays are 0 to 60 s, in milliseconds");
    trace.delays.push_back(std::isnan(ms) ? -1.0 : s);
  });
  if (trace.delays.empty()) throw std::runtime_error(file + ": no delays in it");
  trace.about = fmt::format("{}: {} {}", file, trace.delays.size(),
                            round_trip ? "round trips, half of each one way" : "one-way delays");
  return trace;
}

NetworkTrace read_captures(const std::string& sent, const std::string& received) {
  std::unordered_map<std::string, std::deque<std::int64_t>> arrivals;
  for (const Seen& packet : read_capture(received)) arrivals[packet.id].push_back(packet.ns);
  NetworkTrace trace;
  std::int64_t lost = 0;
  for (const Seen& packet : read_capture(sent)) {
    std::deque<std::int64_t>& times = arrivals[packet.id];
    while (!times.empty() && times.front() < packet.ns) times.pop_front();
    const double delay =
        times.empty() ? kLongest + 1.0 : 1e-9 * static_cast<double>(times.front() - packet.ns);
    if (delay > kLongest) {
      trace.delays.push_back(-1.0);
      ++lost;
      continue;
    }
    times.pop_front();
    trace.delays.push_back(delay);
  }
  if (lost == static_cast<std::int64_t>(trace.delays.size()))
    throw std::runtime_error(
        fmt::format("{} and {}: no packet is in both, later in the second", sent, received));
  trace.about =
      fmt::format("{} to {}: {} packets, {} lost", sent, received, trace.delays.size(), lost);
  return trace;
}

}  // namespace tandem::cli
