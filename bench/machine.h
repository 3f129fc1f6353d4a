#pragma once

#include <algorithm>
#include <fstream>
#include <string>
#include <thread>

namespace tandem::bench {

/// Processor and number of cores, for tables that are read elsewhere.
[[nodiscard]] inline std::string machine_name() {
  std::ifstream file("/proc/cpuinfo");
  std::string name = "unknown processor";
  for (std::string line; std::getline(file, line);)
    if (line.rfind("model name", 0) == 0) {
      name = line.substr(line.find(':') + 2);
      break;
    }
  std::replace(name.begin(), name.end(), '"', ' ');
  return name + ", " + std::to_string(std::thread::hardware_concurrency()) + " cores";
}

}  // namespace tandem::bench
