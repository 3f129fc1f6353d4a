#include "analysis/reference_check.h"

#include <stdexcept>

#include "analysis/reference_case.h"
#include "analysis/reference_kinds.h"

namespace tandem::analysis {

std::vector<CheckRow> check_against(std::istream& expected, const SceneSource& scenes,
                                    const CheckFilter& wanted) {
  using reference::split;
  reference::Cases cases(scenes);
  std::vector<CheckRow> out;
  int number = 0;
  for (std::string line; std::getline(expected, line);) {
    ++number;
    if (line.empty() || line.front() == '#') continue;
    const auto f = split(line, '|');
    try {
      if (f.at(0) == "set") {
        cases.name_set(f.at(1), f.at(2));
        continue;
      }
      const double round_trip = reference::to_number(f.at(3));
      if (!wanted(f.at(0), f.at(1), round_trip)) continue;
      CheckRow row{f[0], f[1], round_trip, "", "", 0.0, 0.0};
      reference::compute(f, cases.build(f.at(2), round_trip, f.at(4)), row);
      out.push_back(std::move(row));
    } catch (const std::logic_error& e) {
      throw std::runtime_error("expected values, line " + std::to_string(number) + ": " + e.what());
    }
  }
  return out;
}

std::vector<CheckRow> check_against(std::istream& expected, const SceneSource& scenes,
                                    const std::string& filter) {
  return check_against(expected, scenes,
                       [&](const std::string& kind, const std::string& name, double) {
                         return (kind + " " + name).find(filter) != std::string::npos;
                       });
}

}  // namespace tandem::analysis
