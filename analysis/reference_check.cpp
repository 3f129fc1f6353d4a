#include "analysis/reference_check.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <sstream>
#include <stdexcept>

#include "analysis/drag.h"
#include "analysis/resampled.h"
#include "analysis/response.h"
#include "analysis/stability.h"

namespace tandem::analysis {

namespace {

constexpr double kBoundaryLimit = 1e-6, kDampingLimit = 1e-9, kRadiusLimit = 1e-10;

std::vector<std::string> split(const std::string& text, char by) {
  std::vector<std::string> out;
  std::stringstream stream(text);
  for (std::string part; std::getline(stream, part, by);) out.push_back(part);
  return out;
}

/// "k11,k22:k" as the fields it stands for; others unchanged.
std::string long_field(const std::string& field) {
  const std::size_t colon = field.find(':');
  if (colon == std::string::npos) return field;
  const char* number = field.substr(colon + 1) == "k" ? ".stiffness" : ".damping";
  std::string out;
  for (const std::string& name : split(field.substr(0, colon), ','))
    out += (out.empty() ? "coupler." : ",coupler.") + name + number;
  return out;
}

struct Case {
  core::Scene scene;
  core::NetworkModel network;
};

void apply_model(core::Scene& scene, const std::string& model) {
  if (model == "alone") scene = with_one_hand(scene, scene.users[0].name);
  if (model == "remote") scene = with_one_hand(scene, scene.users[drag_user(scene)].name);
  if (model == "both" || model == "one")
    std::erase_if(scene.couplers, [](const auto& c) { return !c.user.empty(); });
}

class Checker {
 public:
  explicit Checker(const SceneSource& scenes) : scenes_(scenes) {}

  void name_set(const std::string& name, const std::string& edits) { sets_[name] = edits; }

  CheckRow run(const std::vector<std::string>& f) {
    CheckRow row{f.at(0), f.at(1), "", "", 0.0, 0.0};
    Case c = build(f.at(2), std::stod(f.at(3)), f.at(4));
    if (row.kind == "interval") interval(f, c, row);
    if (row.kind == "count") count(f, c, row);
    if (row.kind == "damping") damping(f, c, row);
    if (row.kind == "response") response(f, c, row);
    if (row.kind == "stiffness") {
      const LiftedSystem system = of_model(c, f.at(5));
      compare(equivalent_stiffness(system, port_of(system, c, f.at(5))), std::stod(f.at(6)),
              kDampingLimit, row);
    }
    if (row.kind == "radius") {
      apply_model(c.scene, f.at(5));
      compare(judge(resampled_system(c.scene, c.network)).radius, std::stod(f.at(6)), kRadiusLimit,
              row);
    }
    return row;
  }

 private:
  Case build(const std::string& name, double packets, const std::string& edits) {
    std::vector<std::string> all;
    std::string model, wall;
    std::stringstream words(edits);
    for (std::string word; words >> word;) {
      if (word.front() == '@') {
        for (const std::string& w : split(sets_.at(word), ' ')) add(w, all, model, wall);
        continue;
      }
      add(word, all, model, wall);
    }
    Case out{scenes_("axis_" + name, all), {}};
    apply_model(out.scene, model);
    if (!wall.empty()) {
      core::WallParameters w;
      w.name = "wall";
      w.normal = core::Vec3(-1.0, 0.0, 0.0);
      w.gain = {std::stod(split(wall, ':').at(0)), std::stod(split(wall, ':').at(1))};
      w.attached = true;
      out.scene.walls.push_back(w);
    }
    out.network.set_round_trip(packets, out.scene.ticks_per_packet());
    return out;
  }

  static void add(const std::string& word, std::vector<std::string>& all, std::string& model,
                  std::string& wall) {
    const std::size_t equal = word.find('=');
    const std::string value = word.substr(equal + 1);
    if (word.substr(0, equal) == "analysis") {
      model = value;
      return;
    }
    if (word.substr(0, equal) == "wall") {
      wall = value;
      return;
    }
    for (const std::string& field : split(long_field(word.substr(0, equal)), ','))
      all.push_back(field + "=" + value);
  }

  static void compare(double found, double expected, double limit, CheckRow& row) {
    char text[64];
    std::snprintf(text, sizeof text, "%.13g", expected);
    row.expected = text;
    std::snprintf(text, sizeof text, "%.13g", found);
    row.found = text;
    row.limit = limit;
    row.deviation = std::isfinite(found) ? std::abs(found - expected) / std::abs(expected)
                                         : std::numeric_limits<double>::infinity();
  }

  static std::string text_of(const std::vector<Interval>& intervals) {
    std::string out;
    for (const Interval& i : intervals) {
      char text[80];
      std::snprintf(text, sizeof text, "%s%.10g:%.10g", out.empty() ? "" : " ", i.low, i.high);
      out += text;
    }
    return out.empty() ? "none" : out;
  }

  static void interval(const std::vector<std::string>& f, Case& c, CheckRow& row) {
    const Knob knob(c.scene, long_field(f.at(5)));
    std::vector<Interval> expected;
    if (f.at(8) != "none")
      for (const std::string& part : split(f.at(8), ' ')) {
        const auto ends = split(part, ':');
        expected.push_back({std::stod(ends.at(0)), std::stod(ends.at(1))});
      }
    StabilityJudge judge(c.scene, c.network);
    const auto found =
        stable_intervals(judge, c.scene, knob, std::stod(f.at(6)), std::stod(f.at(7)));
    row.expected = text_of(expected);
    row.found = text_of(found);
    row.limit = kBoundaryLimit;
    if (found.size() != expected.size()) {
      row.deviation = std::numeric_limits<double>::infinity();
      return;
    }
    const auto off = [](double a, double b) {
      return std::abs(a - b) / std::max(std::abs(b), 1e-300);
    };
    for (std::size_t i = 0; i < found.size(); ++i) {
      if (found[i].low != expected[i].low)
        row.deviation = std::max(row.deviation, off(found[i].low, expected[i].low));
      row.deviation = std::max(row.deviation, off(found[i].high, expected[i].high));
    }
  }

  static void count(const std::vector<std::string>& f, Case& c, CheckRow& row) {
    const Knob x(c.scene, long_field(f.at(5))), y(c.scene, long_field(f.at(9)));
    const Axis across{std::stod(f.at(6)), std::stod(f.at(7)), std::stoi(f.at(8))};
    const Axis up{std::stod(f.at(10)), std::stod(f.at(11)), std::stoi(f.at(12))};
    const StabilityJudge judge(c.scene, c.network);
    const StabilityMap map = stability_map(judge, c.scene, x, across, y, up);
    const int stable = std::stoi(f.at(13)), rows = std::stoi(f.at(14)),
              columns = std::stoi(f.at(15));
    row.expected = f[13] + " " + f[14] + " " + f[15];
    row.found = std::to_string(map.count) + " " + std::to_string(map.rows_apart) + " " +
                std::to_string(map.columns_apart);
    row.deviation = std::abs(static_cast<double>(map.count - stable)) +
                    std::abs(map.rows_apart - rows) + std::abs(map.columns_apart - columns);
  }

  static LiftedSystem of_model(Case& c, const std::string& model) {
    apply_model(c.scene, model);
    return resampled_system(c.scene, c.network);
  }

  static ForcePort port_of(const LiftedSystem& system, const Case& c, const std::string& model) {
    if (model == "remote") return system.ports.at(static_cast<std::size_t>(drag_user(c.scene)));
    if (model == "one") return port_named(system, "box@1");
    if (model == "both") return joined(port_named(system, "box@1"), port_named(system, "box@2"));
    return system.ports.at(0);
  }

  static void damping(const std::vector<std::string>& f, Case& c, CheckRow& row) {
    const auto words = split(f.at(5), ' ');
    const LiftedSystem system = of_model(c, words.at(0));
    const FreeMotion motion = free_motion(system, port_of(system, c, words.at(0)));
    const std::string& output = words.at(1);
    compare(output == "mean"      ? motion.mean_damping
            : output == "sampled" ? motion.sampled_damping
                                  : motion.inertia,
            std::stod(f.at(6)), kDampingLimit, row);
  }

  /// Magnitude and phase together: distance of the complex numbers, relative.
  static void response(const std::vector<std::string>& f, Case& c, CheckRow& row) {
    const auto words = split(f.at(5), ' ');
    const LiftedSystem system = of_model(c, words.at(0));
    const auto found =
        admittance(system, port_of(system, c, words.at(0)), std::stod(f.at(6)), words.at(1) == "X");
    constexpr double kDegree = 3.14159265358979323846 / 180.0;
    const double size = std::stod(f.at(7)), phase = std::stod(f.at(8));
    compare(std::abs(found), size, kDampingLimit, row);
    row.deviation = std::abs(found - std::polar(size, phase * kDegree)) / size;
  }

  const SceneSource& scenes_;
  std::map<std::string, std::string> sets_;
};

}  // namespace

std::vector<CheckRow> check_against(std::istream& expected, const SceneSource& scenes,
                                    const std::string& filter) {
  Checker checker(scenes);
  std::vector<CheckRow> out;
  int number = 0;
  for (std::string line; std::getline(expected, line);) {
    ++number;
    if (line.empty() || line.front() == '#') continue;
    const auto fields = split(line, '|');
    try {
      if (fields.at(0) == "set") {
        checker.name_set(fields.at(1), fields.at(2));
        continue;
      }
      if ((fields.at(0) + " " + fields.at(1)).find(filter) == std::string::npos) continue;
      out.push_back(checker.run(fields));
    } catch (const std::logic_error& e) {
      throw std::runtime_error("expected values, line " + std::to_string(number) + ": " + e.what());
    }
  }
  return out;
}

}  // namespace tandem::analysis
