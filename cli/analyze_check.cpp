#include <cmath>
#include <fstream>

#include <fmt/format.h>

#include "analysis/reference_check.h"
#include "cli/analyze.h"
#include "cli/commands.h"
#include "scene/load_scene.h"

namespace tandem::cli {

namespace {

struct CheckOptions {
  JsonOption json;
  std::string data = TANDEM_SOURCE_DIR "/tests/analysis/data/reference.txt";
  std::string filter;
};

void check(const CheckOptions& o) {
  std::ifstream file(o.data);
  if (!file) throw Failed("cannot read " + o.data + ": give the expected values with --data");
  const analysis::SceneSource shipped = [](const std::string& name,
                                           const std::vector<std::string>& sets) {
    return scene::load_scene(name, sets);
  };
  const auto rows = analysis::check_against(file, shipped, o.filter);
  nlohmann::ordered_json json;
  json["rows"] = nlohmann::ordered_json::array();
  std::string text = fmt::format("{:48} {:>24} {:>24} {:>9}\n", "", "reference", "here", "off by");
  int failed = 0;
  for (const auto& row : rows) {
    failed += row.passed() ? 0 : 1;
    text += fmt::format("{:48} {:>24} {:>24} {:9.1e}{}\n", row.kind + " " + row.name, row.expected,
                        row.found, row.deviation, row.passed() ? "" : "  FAILED");
    json["rows"].push_back({{"kind", row.kind},
                            {"name", row.name},
                            {"reference", row.expected},
                            {"here", row.found},
                            {"deviation", number(row.deviation)},
                            {"limit", row.limit},
                            {"passed", row.passed()}});
  }
  json["checked"] = rows.size();
  json["failed"] = failed;
  text += fmt::format(
      "{} values, {} differ by more than allowed (intervals 1e-6 relative, counts exact, damping "
      "1e-9,\nradii 1e-10). Not reproduced from the thesis itself: Fig 5.1 for n = 2, 3 is empty "
      "with its own\nb = 10; Table 6.2 says 2.1 / 1.4 where Table 6.1 gives 2.04 / 1.07.\n",
      rows.size(), failed);
  if (!o.json.to_stdout()) fmt::print("{}", text);
  o.json.write(json);
  if (rows.empty()) throw Failed("no expected value matches '" + o.filter + "'");
  if (failed > 0) throw Failed("");
}

}  // namespace

void add_analyze_check(CLI::App& analyze) {
  CLI::App* command = analyze.add_subcommand(
      "check", "every table of the reference analysis beside ours, with the deviation");
  auto o = std::make_shared<CheckOptions>();
  o->json.add(*command);
  command->add_option("--data", o->data, "file of expected values")->capture_default_str();
  command->add_option("--filter", o->filter, "only lines that contain this, e.g. \"fig5.2 d=1\"");
  command->callback([o] { check(*o); });
}

}  // namespace tandem::cli
