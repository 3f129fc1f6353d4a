#pragma once

#include <string>
#include <vector>

namespace tandem::cli {

/// Delays of packets as they were recorded, one way [s], in order; a lost one is negative.
struct NetworkTrace {
  std::vector<double> delays;
  std::string about;  ///< what was read and how, for people

  [[nodiscard]] std::vector<double> in_ticks(double local_hz) const;
};

/// One delay a line, in milliseconds; not a number (nan): lost. `round_trip`: half of each counts.
/// Throws std::runtime_error with file, line and text.
[[nodiscard]] NetworkTrace read_delays(const std::string& file, bool round_trip);

/// Two captures, "time [ns], number of the packet" a line; a packet that the second does not have
/// was lost. Numbers may come again when they run over: the next unused one counts.
[[nodiscard]] NetworkTrace read_captures(const std::string& sent, const std::string& received);

}  // namespace tandem::cli
