#pragma once

#include <string>
#include <vector>

namespace tandem::harness {

namespace wire {
class Sweep;
}

/// Folders in which NAME.sweep is looked up: $TANDEM_SWEEPS, the source tree's examples/sweeps, the
/// installed share/tandem/sweeps, also seen from the running program.
[[nodiscard]] std::vector<std::string> sweep_folders();

/// Whole text of a sweep given by name or file; `file` becomes where it was. Throws SweepError.
[[nodiscard]] std::string read_sweep_file(const std::string& name_or_file, std::string& file);

/// Parses protobuf text. Throws SweepError with FILE:LINE:COLUMN of every problem.
void parse_sweep(const std::string& text, const std::string& origin, wire::Sweep& sweep);

}  // namespace tandem::harness
