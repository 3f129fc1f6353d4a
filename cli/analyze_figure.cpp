#include <algorithm>
#include <cmath>
#include <csignal>
#include <fstream>
#include <numbers>
#include <thread>
#include <tuple>
#include <unistd.h>

#include <fmt/format.h>

#include "analysis/closed_forms.h"
#include "analysis/drag.h"
#include "analysis/figures.h"
#include "analysis/reference_check.h"
#include "cli/analyze.h"
#include "cli/commands.h"
#include "cli/picture.h"
#include "scene/load_scene.h"

namespace tandem::cli {

namespace {

using nlohmann::ordered_json;

struct FigureOptions {
  std::string figure;
  std::vector<std::string> scenes, sets;
  std::vector<double> delays;
  JsonOption json;
  std::string csv, picture, wall = "30000:20";
  std::string data = TANDEM_SOURCE_DIR "/tests/analysis/data/reference.txt";
  double compensation = 3.0;
  int points = 0, threads = 0;
  bool fast = false;

  /// Whether everything is as in the thesis, so that there is something to compare with.
  [[nodiscard]] bool as_printed() const {
    return scenes.empty() && sets.empty() && compensation == 3.0 && wall == "30000:20" && !fast;
  }
};

volatile std::sig_atomic_t figure_interrupted = 0;

/// What the commands print and write, collected piece by piece.
struct Output {
  std::string text, csv;
  ordered_json json;
};

core::Scene load(const std::string& name, const std::vector<std::string>& sets, Output& out) {
  analysis::LinearScene linear = analysis::linear_scene(scene::load_scene(name, sets));
  for (const std::string& a : linear.assumptions) out.text += "  assumed: " + a + "\n";
  return std::move(linear.scene);
}

/// Our values beside the reference analysis, where it has some for `wanted`.
void side_by_side(const FigureOptions& o, const analysis::CheckFilter& wanted, Output& out) {
  out.json["reference"] = ordered_json::array();
  if (!o.as_printed()) {
    out.text += "No reference values: scene or numbers are not those of the thesis.\n";
    return;
  }
  std::ifstream file(o.data);
  if (!file) {
    out.text += "No reference values: cannot read " + o.data + " (--data FILE)\n";
    return;
  }
  const auto rows = analysis::check_against(
      file,
      [](const std::string& name, const std::vector<std::string>& sets) {
        return scene::load_scene(name, sets);
      },
      wanted);
  int failed = 0;
  out.text +=
      fmt::format("{:44} {:>40} {:>40} {:>9}\n", "", "reference analysis", "here", "off by");
  for (const auto& row : rows) {
    failed += row.passed() ? 0 : 1;
    out.text += fmt::format("{:44} {:>40} {:>40} {:9.1e}{}\n", row.kind + " " + row.name,
                            row.expected, row.found, row.deviation, row.passed() ? "" : "  FAILED");
    out.json["reference"].push_back({{"kind", row.kind},
                                     {"name", row.name},
                                     {"reference", row.expected},
                                     {"here", row.found},
                                     {"deviation", number(row.deviation)},
                                     {"passed", row.passed()}});
  }
  out.text += fmt::format("{} values of the reference analysis, {} differ by more than allowed.\n",
                          rows.size(), failed);
}

void note(Output& out, const std::string& text) {
  out.json["notes"].push_back(text);
  out.text += "note: " + text + "\n";
}

void finish(const FigureOptions& o, Output& out) {
  if (!o.csv.empty()) write_text(o.csv, out.csv);
  if (!o.picture.empty()) draw_json(o.picture, "plot_figure.py", out.json);
  if (!o.json.to_stdout()) fmt::print("{}", out.text);
  o.json.write(out.json);
}

ordered_json axis_json(const std::string& field, const std::string& label,
                       const analysis::Axis& axis) {
  return {{"field", field},
          {"label", label},
          {"from", axis.from},
          {"to", axis.to},
          {"cells", axis.count}};
}

void refuse_varied(const FigureOptions& o, const analysis::MapPlan& plan) {
  const std::string varied = "," + plan.x_field + "," + plan.y_field + ",";
  for (const std::string& set : o.sets) {
    const std::string field = set.substr(0, set.find('='));
    if (varied.find("," + field + ",") != std::string::npos)
      throw CLI::ValidationError("--set", set + ": figure " + o.figure + " varies " + field +
                                              " itself; `tandem analyze stability` takes a range");
  }
}

void map_figure(const FigureOptions& o) {
  analysis::MapPlan plan = analysis::map_plan(o.figure);
  refuse_varied(o, plan);
  if (o.scenes.size() > 1) throw CLI::ValidationError("--scene", "a map takes one scene");
  Output out;
  std::vector<std::string> sets = plan.sets;
  sets.insert(sets.end(), o.sets.begin(), o.sets.end());
  const core::Scene scene = load(o.scenes.empty() ? plan.scene : o.scenes[0], sets, out);
  if (o.points > 0) plan.across.count = plan.up.count = o.points;
  const std::vector<double> delays =
      o.delays.empty() ? std::vector<double>{0.0, 1.0, 2.0, 3.0} : o.delays;
  out.json["figure"] = o.figure;
  out.json["kind"] = "map";
  out.json["scene"] = scene.name;
  out.json["sets"] = sets;
  out.json["x"] = axis_json(plan.x_field, plan.x_label, plan.across);
  out.json["y"] = axis_json(plan.y_field, plan.y_label, plan.up);
  out.text = fmt::format("Figure {}: {}; {} over {}\n  {}\n{}", o.figure, scene.name, plan.y_label,
                         plan.x_label, fmt::join(sets, " "), out.text);
  out.csv = "round_trip_packets,x0,y0,x1,y1\n";
  const int threads = o.threads > 0
                          ? o.threads
                          : static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  const bool progress = isatty(STDERR_FILENO) != 0;
  const auto before = std::signal(SIGINT, [](int) { figure_interrupted = 1; });
  for (const double d : delays) {
    const analysis::Region r = analysis::region(plan, scene, d, threads, [&](int done, int all) {
      if (progress)
        fmt::print(stderr, "\rround trip {:g}: {} of {} rows{}", d, done, all,
                   done == all ? "\n" : "");
      return figure_interrupted == 0;
    });
    ordered_json region;
    region["round_trip_packets"] = d;
    region["road"] = r.road;
    region["stable"] = r.map.count;
    region["rows_with_several_intervals"] = r.map.rows_apart;
    region["columns_with_several_intervals"] = r.map.columns_apart;
    region["cells"] = ordered_json::array();  // one string a row, y upwards
    for (int j = 0; j < plan.up.count; ++j) {
      std::string row;
      for (int i = 0; i < plan.across.count; ++i)
        row += r.map.stable[static_cast<std::size_t>(j) * plan.across.count + i] != 0 ? '1' : '0';
      region["cells"].push_back(row);
    }
    region["boundary"] = ordered_json::array();
    for (const auto& g : r.boundary) {
      region["boundary"].push_back({g.x0, g.y0, g.x1, g.y1});
      out.csv += fmt::format("{},{},{},{},{}\n", d, g.x0, g.y0, g.x1, g.y1);
    }
    out.text += fmt::format(
        "  round trip {:g} packets: {} of {} points stable, boundary of {} "
        "segments\n",
        d, r.map.count, r.map.stable.size(), r.boundary.size());
    out.json["regions"].push_back(std::move(region));
  }
  std::signal(SIGINT, before);
  side_by_side(
      o,
      [&](const std::string& kind, const std::string& name, double d) {
        return kind != "nearest" && kind != "scan" && name.rfind("fig" + o.figure + " ", 0) == 0 &&
               std::find(delays.begin(), delays.end(), d) != delays.end();
      },
      out);
  note(out,
       "the thesis' figures exist as images only, and their axes are not legible in the text "
       "we have: the ranges are those of the reference analysis, and only what the text says "
       "can be compared");
  if (o.figure == "5.1") {
    const int remote = analysis::drag_user(scene);
    std::string limits;
    for (int d = 0; d < 4; ++d)
      limits += fmt::format(
          "{}{:.4g}", d == 0 ? "" : ", ",
          analysis::held_damping_limit(scene.users[static_cast<std::size_t>(remote)].mass,
                                       scene.ticks_per_packet() * scene.tick(), d));
    note(out,
         "not reproduced: the text has four shrinking regions for n = 0..3, but with its own "
         "b = 10 N s/m those for n = 2, 3 are empty. A damper held over a packet and n "
         "packets late needs b2 < 2 (m2 / T_t) sin(pi / (2 (2 n + 1))) = " +
             limits +
             " N s/m for n = 0..3 even at k2 = 0. Nested regions come out with b2 = 3 "
             "(--set coupler.k2.damping=3) or with n counted in ticks (--delays "
             "0,0.125,0.25,0.375)");
  }
  finish(o, out);
}

core::Gain wall_of(const std::string& text) {
  core::Gain wall;
  char rest = 0;
  if (std::sscanf(text.c_str(), "%lf:%lf%c", &wall.stiffness, &wall.damping, &rest) != 2 ||
      !(wall.stiffness > 0.0) || !(wall.damping >= 0.0) || !(wall.stiffness < 1e12) ||
      !(wall.damping < 1e12))
    throw CLI::ValidationError("--wall",
                               text + " is not STIFFNESS:DAMPING [N/m]:[N s/m], the first above 0");
  return wall;
}

/// The scenes of chapter 6: the shipped ones unless replaced by one of the same architecture. Each
/// edit goes to the scenes that have its field; one that none has is refused.
std::pair<core::Scene, core::Scene> chapter_6(const FigureOptions& o, Output& out) {
  std::string central = "axis_central", distributed = "axis_distributed";
  for (const std::string& name : o.scenes) {
    const core::Architecture a = scene::load_scene(name, {}).architecture;
    if (a != core::Architecture::kCentral && a != core::Architecture::kDistributed)
      throw CLI::ValidationError("--scene", name +
                                                ": chapter 6 compares a CENTRAL scene with a "
                                                "DISTRIBUTED one");
    (a == core::Architecture::kCentral ? central : distributed) = name;
  }
  std::vector<std::string> for_central, for_distributed;
  for (const std::string& set : o.sets) {
    std::string refused;
    int taken = 0;
    for (auto* list : {&for_central, &for_distributed}) {
      try {
        (void)scene::load_scene(list == &for_central ? central : distributed,
                                std::vector<std::string>{set});
        list->push_back(set);
        ++taken;
      } catch (const scene::SceneError& e) {
        refused = e.what();
      }
    }
    if (taken == 0) throw CLI::ValidationError(refused);
  }
  core::Scene one = load(central, for_central, out);
  return {std::move(one), load(distributed, for_distributed, out)};
}

void admittance_figure(const FigureOptions& o) {
  Output out;
  analysis::ResponseSettings s;
  std::tie(s.central, s.distributed) = chapter_6(o, out);
  if (!o.delays.empty()) s.round_trips = o.delays;
  if (o.points > 0) s.points = o.points;
  s.compensation = o.compensation;
  s.wall = wall_of(o.wall);
  s.fast = o.fast;
  const analysis::ResponseFigure figure = analysis::response_figure(o.figure, s);
  constexpr double kDegree = std::numbers::pi / 180.0;
  out.json["figure"] = o.figure;
  out.json["kind"] = "response";
  out.json["scenes"] = {s.central.name, s.distributed.name};
  out.json["sets"] = o.sets;
  out.json["response"] = figure.response;
  out.json["omega_rad_s"] = figure.omega;
  out.csv = "omega_rad_s";
  out.text = fmt::format("Figure {}: {}, {}\n{}{:>12}", o.figure, figure.response,
                         o.fast ? "force held over a tick, fundamental component"
                                : "force held and motion sampled once a packet",
                         out.text, "rad/s");
  for (const analysis::Curve& c : figure.curves) {
    const std::string label =
        c.has_round_trip ? fmt::format("{}, n = {:g}", c.name, c.round_trip) : c.name;
    ordered_json curve;
    curve["name"] = label;
    for (const auto& g : c.values) {
      curve["magnitude"].push_back(number(std::abs(g)));
      curve["phase_deg"].push_back(number(std::arg(g) / kDegree));
    }
    out.json["curves"].push_back(std::move(curve));
    std::string column = label;
    for (char& letter : column)
      if (std::isalnum(static_cast<unsigned char>(letter)) == 0 && letter != '.') letter = '_';
    out.csv += fmt::format(",{0}_magnitude,{0}_phase_deg", column);
    out.text += fmt::format("  {:>30}", label);
  }
  out.csv += "\n";
  out.text += "\n";
  const std::size_t step = std::max<std::size_t>(1, figure.omega.size() / 12);
  for (std::size_t i = 0; i < figure.omega.size(); ++i) {
    out.csv += fmt::format("{}", figure.omega[i]);
    std::string line = fmt::format("{:12.5g}", figure.omega[i]);
    for (const analysis::Curve& c : figure.curves) {
      const double size = std::abs(c.values[i]), phase = std::arg(c.values[i]) / kDegree;
      out.csv += fmt::format(",{},{}", size, phase);
      line += fmt::format("  {:>30}", fmt::format("{:.5g} ({:.1f} deg)", size, phase));
    }
    out.csv += "\n";
    if (i % step == 0) out.text += line + "\n";
  }
  const char* contact = o.figure == "6.5" ? "contact_XF_" : "";
  side_by_side(
      o,
      [&](const std::string& kind, const std::string& name, double) {
        if (kind != "response" || name.find("fast") != std::string::npos) return false;
        for (const char* curve :
             {"ideal ", "ideal_mass_mo ", "cent_local_Tc ", "cent_remote_d1_slow ",
              "dist_T61_d1_bc0_slow ", "dist_T61_d1_bc-3_slow "}) {
          const std::string all = contact + std::string(curve);
          if (o.figure == "6.4" && all.rfind("cent", 0) == 0) continue;
          if (o.figure == "6.2" && all.find("bc-3") != std::string::npos) continue;
          if (name.rfind(all, 0) == 0) return true;
        }
        return false;
      },
      out);
  note(out, "the thesis' figure exists as an image only: not compared point by point");
  if (o.figure == "6.4")
    for (const double d : s.round_trips) {
      core::Scene given_back = s.distributed;
      given_back.objects[0].compensation = s.compensation;
      note(out, fmt::format("n = {:g}: drag {:.6g} N s/m, with {:g} N s/m given back on each copy "
                            "{:.6g}; the thesis says -3, obtained with n = 1",
                            d, analysis::drag_alone(s.distributed, 0, d), s.compensation,
                            analysis::drag_alone(given_back, 0, d)));
    }
  if (o.figure == "6.5") {
    const analysis::CopiesNumbers n = analysis::copies_numbers(s.distributed);
    note(out, fmt::format("stiffness at rest, distributed: {:.10g} N/m; (6.4) as printed gives "
                          "{:.10g}, which has 2 k_o^2 too much above and below (an error of sign)",
                          analysis::stiffness_6_4_corrected(n, s.wall.stiffness),
                          analysis::stiffness_6_4(n, s.wall.stiffness)));
  }
  finish(o, out);
}

void table_figure(const FigureOptions& o) {
  Output out;
  const auto [central, distributed] = chapter_6(o, out);
  const double d = o.delays.empty() ? 0.0 : o.delays[0];
  const auto rows =
      analysis::table_6_2(central, distributed, scene::load_scene("box_distributed", {}), d);
  out.json["table"] = o.figure;
  out.json["kind"] = "table";
  out.json["round_trip_packets"] = d;
  out.text = fmt::format(
      "Table {}: drag in free motion [N s/m], n = {:g}, N = {}\n{}{:26} {:>8} "
      "{:>12} {:>12}  {}\n",
      o.figure, d, distributed.ticks_per_packet(), out.text, "", "printed", "as caption", "nearest",
      "nearest with");
  out.csv = "model,printed,as_caption,nearest,nearest_with\n";
  for (const auto& r : rows) {
    out.text += fmt::format("{:26} {:8g} {:12.6f} {:12.6f}  {}\n", r.model, r.printed, r.caption,
                            r.nearest, r.nearest_numbers);
    out.csv += fmt::format("\"{}\",{},{},{},\"{}\"\n", r.model, r.printed, r.caption, r.nearest,
                           r.nearest_numbers);
    out.json["rows"].push_back({{"model", r.model},
                                {"printed", r.printed},
                                {"as_caption", number(r.caption)},
                                {"nearest", number(r.nearest)},
                                {"nearest_with", r.nearest_numbers}});
  }
  side_by_side(
      o,
      [&](const std::string& kind, const std::string& name, double round_trip) {
        return kind == "damping" && round_trip == d && name.rfind("table 6.2 T", 0) == 0 &&
               name.find("N=8") != std::string::npos;
      },
      out);
  note(out,
       fmt::format("not reproduced: with the gains of its caption the distributed row is {:.3g} / "
                   "{:.3g}, not 2.1 / 1.4; the normal gains of Table 8.2 give {:.4g} / {:.4g}, "
                   "which is the printed row cut off, not rounded (N = 4 and n = 1 with these "
                   "gains would round to it: not unique)",
                   rows[2].caption, rows[3].caption, rows[2].nearest, rows[3].nearest));
  note(out,
       fmt::format("the centralized 0.04 is (B.10), which is for N = 2; here N is {} and it is "
                   "{:.3g}",
                   central.ticks_per_packet(), rows[0].caption));
  finish(o, out);
}

CLI::App* add_command(CLI::App& analyze, const char* name, const char* about,
                      std::vector<std::string> known, const std::shared_ptr<FigureOptions>& o) {
  CLI::App* command = analyze.add_subcommand(name, about);
  command->add_option("which", o->figure, "which one")
      ->required()
      ->check(CLI::IsMember(std::move(known)));
  command->add_option("--scene", o->scenes, "another scene, a name or a file; chapter 6 takes two")
      ->allow_extra_args(false);
  command->add_option("--set", o->sets, "change one field, PATH=VALUE, after what the figure fixes")
      ->allow_extra_args(false);
  command->add_option("--delays", o->delays, "round trips in packet periods, for example 0,1,2,3")
      ->delimiter(',')
      ->check(between(0.0, 60.0));
  add_csv(*command, o->csv, "write the values to this file");
  command->add_option("--data", o->data, "file of the reference analysis' values")
      ->capture_default_str();
  o->json.add(*command);
  return command;
}

void guarded(const std::shared_ptr<FigureOptions>& o, void (*run)(const FigureOptions&)) {
  try {
    run(*o);
  } catch (const std::domain_error& e) {
    throw Failed(e.what());
  } catch (const std::invalid_argument& e) {  // a scene without the couplers of the figure
    throw CLI::ValidationError("--scene", e.what());
  }
}

}  // namespace

void add_analyze_figure(CLI::App& analyze) {
  auto o = std::make_shared<FigureOptions>();
  CLI::App* figure = add_command(
      analyze, "figure", "a figure of the thesis' chapters 5 and 6, beside the reference analysis",
      {"5.1", "5.2", "5.3", "5.4", "6.2", "6.4", "6.5"}, o);
  figure->add_option("--picture", o->picture, "draw it: a .svg or .png file")
      ->check(picture_file, "", "a picture");
  figure
      ->add_option("--points", o->points,
                   "5.x: cells a side (100); 6.x: frequencies (200); at most 3000")
      ->check(CLI::Range(2, 3000));
  figure->add_option("--threads", o->threads, "threads of a map; 0: one a core")
      ->check(CLI::Range(0, 1024));
  figure
      ->add_option("--compensation", o->compensation, "6.4: negative damping of each copy [N s/m]")
      ->check(not_negative, "", "a number of at least 0")
      ->capture_default_str();
  figure->add_option("--wall", o->wall, "6.5: STIFFNESS:DAMPING of the wall [N/m]:[N s/m]")
      ->capture_default_str();
  figure->add_flag("--fast", o->fast,
                   "6.x: force held over a tick and the fundamental of the motion, instead of "
                   "force held over a packet");
  figure->callback([o] { guarded(o, o->figure[0] == '5' ? map_figure : admittance_figure); });

  auto t = std::make_shared<FigureOptions>();
  CLI::App* command = add_command(
      analyze, "table", "a table of the thesis' chapter 6, beside ours and the reference analysis",
      {"6.2"}, t);
  command->callback([t] { guarded(t, table_figure); });
}

}  // namespace tandem::cli
