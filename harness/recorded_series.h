#pragma once

#include <string>

#include "harness/condition.h"

/// Recorded networks, from files. Each throws SweepError: no such file, a line that is no number,
/// times that do not rise, nothing in it; with file and line.
namespace tandem::harness {

/// Columns time_s, delay_s with a header line; an empty delay or nan is a lost packet.
[[nodiscard]] RecordedSeries read_one_way(const std::string& file);

/// One round trip a line [ms], of a ping whose next request starts when the reply is there: times
/// are sums of round trips, and half of each is taken for one way.
[[nodiscard]] RecordedSeries read_round_trips(const std::string& file);

/// Two files of lines "stamp,packet": stamps of one clock [ns] where packets left and where they
/// came in, matched by the packet's name in the order of leaving. A packet that never came is lost.
[[nodiscard]] RecordedSeries read_stamps(const std::string& sent, const std::string& received);

}  // namespace tandem::harness
