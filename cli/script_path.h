#pragma once

#include <string>
#include <vector>

namespace tandem::cli {

/// Runs one of the project's Python scripts (in scripts/ of the tree, or share/tandem/scripts once
/// installed) with the system's python3; returns its exit status, -1 if it could not be started.
int run_script(const std::string& script, const std::vector<std::string>& arguments);

}  // namespace tandem::cli
