#include <cstdio>
#include <stdexcept>

#include <fmt/format.h>

#include "analysis/boundary.h"
#include "cli/analyze.h"
#include "cli/commands.h"
#include "cli/picture.h"
#include "cli/sweep_session.h"

namespace tandem::cli {

namespace {

using nlohmann::ordered_json;

struct StabilityOptions {
  AnalyzeOptions common;
  SweepOptions sweep;
  std::vector<std::string> vary;
  std::string csv, picture;
  int check_every = 100;
  int squares = 16;
};

struct Varied {
  analysis::Knob knob;
  analysis::Axis axis;
};

/// FIELD[,FIELD...]=FROM:TO[:CELLS]
Varied parse(const core::Scene& scene, const std::string& text) {
  const auto bad = [&](const std::string& why) {
    throw CLI::ValidationError("--vary", text + ": " + why);
  };
  const std::size_t equal = text.find('=');
  if (equal == std::string::npos) bad("write FIELD[,FIELD...]=FROM:TO[:CELLS]");
  analysis::Axis axis;
  char rest = 0;
  const std::string range = text.substr(equal + 1);
  long long cells = axis.count;  // wider than int: an absurd number is to be refused, not wrapped
  const int read =
      std::sscanf(range.c_str(), "%lf:%lf:%19lld%c", &axis.from, &axis.to, &cells, &rest);
  if (read != 2 && read != 3) bad("the range is FROM:TO or FROM:TO:CELLS");
  if (!(axis.from < axis.to) || !(axis.from >= 0.0) || !(axis.to < 1e12))
    bad("the range must go up, from 0 or more to less than 10^12");
  if (cells < 1 || cells > 1000000) bad("1 to 1000000 cells");
  axis.count = static_cast<int>(cells);
  const std::string fields = text.substr(0, equal);
  if (axis.from == 0.0 &&
      (fields.find(".mass") != std::string::npos || fields.find(".inertia") != std::string::npos))
    bad("a mass is above 0: start the range above it, for example at " +
        fmt::format("{:g}", 1e-3 * axis.to));
  try {
    return {analysis::Knob(scene, text.substr(0, equal)), axis};
  } catch (const std::invalid_argument& e) {
    throw CLI::ValidationError("--vary", e.what());
  }
}

void intervals(const StabilityOptions& o, const AnalyzedScene& s, const Varied& v) {
  analysis::StabilityJudge judge(s.scene, s.network);
  const auto found = analysis::stable_intervals(judge, s.scene, v.knob, v.axis.from, v.axis.to);
  ordered_json json;
  json["scene"] = s.scene.name;
  json["delay_packets"] = o.common.delay_packets;
  json["vary"] = v.knob.name();
  json["from"] = v.axis.from;
  json["to"] = v.axis.to;
  json["stable"] = ordered_json::array();
  std::string text = fmt::format("{}, round trip {:.6g} packets, {}\n{}", s.scene.name,
                                 o.common.delay_packets, v.knob.name(), s.assumed());
  std::string csv = "low,high\n";
  for (const auto& i : found) {
    json["stable"].push_back({i.low, i.high});
    csv += fmt::format("{},{}\n", i.low, i.high);
    text += fmt::format("  stable from {:.12g}{} to {:.12g}{}\n", i.low,
                        i.low == v.axis.from ? " (start of scan)" : "", i.high,
                        i.high == v.axis.to ? " (end of scan)" : "");
  }
  if (found.empty()) text += "  nowhere stable\n";
  json["road"] = judge.road();
  json["evaluations"] = judge.evaluations();
  o.common.tell(o.csv, csv, text, json);
}

/// As the figures of chapter 5 are drawn.
void draw_map(const StabilityOptions& o, const ordered_json& json, const Varied& x, const Varied& y,
              const analysis::StabilityMap& found) {
  ordered_json results{{"kind", "map"},
                       {"title", json["scene"].get<std::string>() + ": stable region and boundary"},
                       {"x", json["x"]},
                       {"y", json["y"]}};
  results["x"]["label"] = x.knob.name();
  results["y"]["label"] = y.knob.name();
  ordered_json region{{"round_trip_packets", o.common.delay_packets},
                      {"boundary", json["boundary"]}};
  for (int j = 0; j < y.axis.count; ++j) {  // one string a row, y upwards
    std::string row;
    for (int i = 0; i < x.axis.count; ++i)
      row += found.stable[static_cast<std::size_t>(j) * x.axis.count + i] != 0 ? '1' : '0';
    region["cells"].push_back(row);
  }
  results["regions"] = {std::move(region)};
  draw_json(o.picture, "plot_figure.py", results);
}

void map(const StabilityOptions& o, const AnalyzedScene& s, const Varied& x, const Varied& y) {
  refuse_too_large(1.0 * x.axis.count * y.axis.count, 1.5, "the map");
  const analysis::StabilityJudge judge(s.scene, s.network);
  ordered_json settings = scene_settings(s.scene, o.common.delay_packets);
  for (const auto& [name, v] : {std::pair{"x", &x}, std::pair{"y", &y}})
    settings[name] = {{"vary", v->knob.name()},
                      {"from", v->axis.from},
                      {"to", v->axis.to},
                      {"cells", v->axis.count}};
  settings["check_every"] = o.check_every;
  settings["squares"] = o.squares;
  SweepSession session(o.sweep, "stability", settings);
  const auto found = analysis::stability_map(judge, s.scene, x.knob, x.axis, y.knob, y.axis,
                                             session, o.check_every);
  analysis::Axis across = x.axis, up = y.axis;
  across.count = up.count = o.squares;
  analysis::BoundaryOptions fine;
  fine.levels = 2;
  const auto boundary =
      analysis::stability_boundary(judge, s.scene, x.knob, across, y.knob, up, session, fine);
  if (!session.tells()) return;
  const auto& segments = boundary.segments;

  ordered_json json;
  json["scene"] = s.scene.name;
  json["delay_packets"] = o.common.delay_packets;
  for (const auto& [name, v] : {std::pair{"x", &x}, std::pair{"y", &y}})
    json[name] = {{"vary", v->knob.name()},
                  {"from", v->axis.from},
                  {"to", v->axis.to},
                  {"cells", v->axis.count}};
  json["road"] = judge.road();
  json["cells"] = found.stable.size();
  json["stable"] = found.count;
  json["rows_with_several_intervals"] = found.rows_apart;
  json["columns_with_several_intervals"] = found.columns_apart;
  json["checked_on_the_loop"] = {{"points", found.check.points},
                                 {"verdicts_that_differ", found.check.differ},
                                 {"largest_difference", found.check.largest_difference}};
  json["boundary_evaluations"] = boundary.evaluations;
  json["found_between_grid_points"] = boundary.found_between;
  json["boundary"] = ordered_json::array();
  std::string csv = "x0,y0,x1,y1\n";
  for (const auto& g : segments) {
    json["boundary"].push_back({g.x0, g.y0, g.x1, g.y1});
    csv += fmt::format("{},{},{},{}\n", g.x0, g.y0, g.x1, g.y1);
  }
  std::string text = fmt::format(
      "{}, round trip {:.6g} packets\n{}  x: {}\n  y: {}\n  {} of {} cells stable; along y {} rows "
      "have several intervals, along x {}\n  boundary: {} exact segments\n",
      s.scene.name, o.common.delay_packets, s.assumed(), x.knob.name(), y.knob.name(), found.count,
      found.stable.size(), found.rows_apart, found.columns_apart, segments.size());
  text += found.check.points > 0
              ? fmt::format(
                    "  one point in {} judged again on the running loop: {} points, {} "
                    "verdicts differ, spectral radii by {:.1e} at most\n",
                    o.check_every, found.check.points, found.check.differ,
                    found.check.largest_difference)
          : judge.road() == std::string("measured")
              ? std::string("  every point was judged on the running loop\n")
              : std::string("  no point was judged again on the running loop\n");
  // A small picture: 20 lines of 50 characters, y upwards.
  for (int line = 19; line >= 0; --line) {
    text += "  |";
    for (int column = 0; column < 50; ++column) {
      const auto i = static_cast<int>((2LL * column + 1) * x.axis.count / 100),
                 j = static_cast<int>((2LL * line + 1) * y.axis.count / 40);
      text += found.stable[static_cast<std::size_t>(j) * x.axis.count + i] != 0 ? '#' : '.';
    }
    text += '\n';
  }
  o.common.tell(o.csv, csv, text, json);
  if (!o.picture.empty()) draw_map(o, json, x, y, found);
  if (found.check.differ > 0)
    throw Failed(
        fmt::format("{} of {} points are judged otherwise on the running loop: do not use "
                    "this map, report the scene",
                    found.check.differ, found.check.points));
}

void run(const StabilityOptions& o) {
  const AnalyzedScene s = o.common.load();
  const Varied first = parse(s.scene, o.vary.at(0));
  if (o.vary.size() == 1 && !o.picture.empty())
    throw CLI::ValidationError("--picture", "a picture is of a map: give --vary twice");
  if (o.vary.size() == 1) return intervals(o, s, first);
  const Varied second = parse(s.scene, o.vary.at(1));
  const double cells = 1.0 * first.axis.count * second.axis.count;
  constexpr double kMost = 1e8;  // a byte each, and more than a day on one core
  if (cells > kMost)
    throw CLI::ValidationError(
        "--vary", fmt::format("{} times {} cells are {:.3g}, more than {:g}: take fewer; the "
                              "boundary is exact whatever their number",
                              first.axis.count, second.axis.count, cells, kMost));
  if (first.knob.name() == second.knob.name())
    throw CLI::ValidationError("--vary", first.knob.name() + " is varied along both axes");
  map(o, s, first, second);
}

}  // namespace

void add_analyze_stability(CLI::App& analyze) {
  CLI::App* command = analyze.add_subcommand(
      "stability", "exact stable intervals of one number, or a map and boundary over two");
  auto o = std::make_shared<StabilityOptions>();
  o->common.add(*command);
  command
      ->add_option("--vary", o->vary,
                   "FIELD[,FIELD...]=FROM:TO[:CELLS], once or twice; several fields are set alike: "
                   "coupler.k12.stiffness,coupler.k21.stiffness=0:6000:100")
      ->required()
      ->expected(1, 2)
      ->allow_extra_args(false);
  add_csv(*command, o->csv, "write intervals or boundary segments to this file");
  command->add_option("--picture", o->picture, "draw a map of two fields: a .svg or .png file")
      ->check(picture_file, "", "a picture");
  command
      ->add_option("--check-every", o->check_every,
                   "judge one cell in so many again on the running loop; 0: none")
      ->check(CLI::Range(0, 1000000))
      ->capture_default_str();
  command
      ->add_option("--squares", o->squares,
                   "the boundary is looked for on a grid of so many squares each way")
      ->check(CLI::Range(2, 1000))
      ->capture_default_str();
  o->sweep.add(*command);
  on_call(*command, o, run);
}

}  // namespace tandem::cli
