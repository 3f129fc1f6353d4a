#include <cmath>
#include <limits>
#include <stdexcept>

#include <fmt/format.h>

#include "analysis/resampled.h"
#include "analysis/response.h"
#include "analysis/roots.h"
#include "analysis/stability.h"
#include "cli/analyze.h"
#include "cli/commands.h"
#include "cli/sweep_axis.h"
#include "cli/sweep_session.h"

namespace tandem::cli {

namespace {

using analysis::SweepRow;
using analysis::SweepWork;
using nlohmann::ordered_json;

struct SweepArguments {
  AnalyzeOptions common;
  SweepOptions sweep;
  std::vector<std::string> axes;
  std::vector<std::string> report{"growth", "felt", "margins"};
  std::string user, csv;
  int check_every = 100;
};

constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();

/// What is found out at every point.
struct Wanted {
  bool felt = false, margins = false;
  std::string port;  ///< USER.FINGER

  [[nodiscard]] std::vector<std::string> columns() const {
    std::vector<std::string> out{"growth", "stable"};
    if (felt) out.insert(out.end(), {"damping", "inertia", "stiffness"});
    if (margins) out.insert(out.end(), {"delay_left_ticks", "stiffness_factor_left"});
    return out;
  }
};

/// Ticks of round trip that may be added, one by one; -1: not stable as it is. Looks 20 packet
/// periods far and no further.
double delay_left(AnalyzedScene s, double packets) {
  const double N = s.scene.ticks_per_packet();
  const int now = static_cast<int>(std::ceil(packets * N - 1e-9));
  const int last = static_cast<int>(20.0 * N);
  for (int more = 0; more <= last; ++more) {
    s.network.set_round_trip((now + more) / N, N);
    if (!analysis::judge(s.lift()).stable()) return more - 1;
  }
  return last;
}

/// The factor all stiffnesses of couplers (walls, where there are no couplers) may be multiplied
/// with, from one up to the first boundary on a scan of 60 ratios to 100; 0: not stable as it is.
double stiffness_left(const AnalyzedScene& s) {
  analysis::StabilityJudge judge(s.scene, s.network);
  core::Scene edited = s.scene;
  const auto margin = [&](double factor) {
    for (std::size_t i = 0; i < edited.couplers.size(); ++i)
      edited.couplers[i].gain.stiffness = factor * s.scene.couplers[i].gain.stiffness;
    for (std::size_t i = 0; s.scene.couplers.empty() && i < edited.walls.size(); ++i)
      edited.walls[i].gain.stiffness = factor * s.scene.walls[i].gain.stiffness;
    return judge.margin(edited);
  };
  double before = 1.0, at_before = margin(before);
  if (!(at_before > 0.0)) return 0.0;
  constexpr int kRatios = 60;
  for (int i = 1; i <= kRatios; ++i) {
    const double factor = std::pow(100.0, static_cast<double>(i) / kRatios), m = margin(factor);
    if (!(m > 0.0)) return analysis::zero_between(margin, before, at_before, factor, m, 1e-9);
    before = factor, at_before = m;
  }
  return 100.0;
}

void find_out(const AnalyzedScene& s, double packets, const Wanted& wanted, SweepRow& row,
              double& growth) {
  const analysis::LiftedSystem system = s.lift();
  growth = analysis::judge(system).radius;
  row.push_back(growth);
  row.push_back(growth < 1.0 ? 1.0 : 0.0);
  if (wanted.felt) {
    const analysis::ForcePort& port = analysis::port_named(system, wanted.port);
    if (system.grounded) {
      row.insert(row.end(), {kNothing, kNothing, analysis::equivalent_stiffness(system, port)});
    } else {
      const analysis::FreeMotion m = analysis::free_motion(system, port);
      row.insert(row.end(), {m.mean_damping, m.inertia, 0.0});
    }
  }
  if (!wanted.margins) return;
  const bool network = s.scene.architecture != core::Architecture::kSingle;
  row.push_back(!network ? kNothing : growth < 1.0 ? delay_left(s, packets) : -1.0);
  row.push_back(growth < 1.0 ? stiffness_left(s) : 0.0);
}

Wanted wanted_of(const SweepArguments& a, const core::Scene& scene) {
  Wanted wanted;
  for (const std::string& what : a.report) {
    wanted.felt = wanted.felt || what == "felt";
    wanted.margins = wanted.margins || what == "margins";
  }
  wanted.felt = wanted.felt && scene.space == core::Space::kAxis;  // in a plane it has a direction
  const int u = a.user.empty() ? 0 : core::index_of(scene.users, a.user);
  if (u < 0 || scene.users.empty() || scene.users[u].fingers.empty())
    throw CLI::ValidationError("--user",
                               a.user + " is no user of " + scene.name + " with a finger");
  wanted.port = scene.users[u].name + "." + scene.users[u].fingers[0].name;
  return wanted;
}

void tell(const SweepArguments& a, const SweepGrid& grid, const AnalyzedScene& first,
          const Wanted& wanted, const std::vector<SweepRow>& rows, std::int64_t block) {
  const std::vector<std::string> columns = wanted.columns();
  const auto points = static_cast<std::int64_t>(grid.count());
  analysis::LoopCheck check;
  for (const SweepRow& row : rows) {
    check.points += static_cast<std::int64_t>(row[0]);
    check.differ += static_cast<std::int64_t>(row[1]);
    check.largest_difference = std::max(check.largest_difference, row[2]);
  }
  std::string head, csv, text;
  for (const SweepAxis& axis : grid.axes()) {
    std::string name = axis.name;  // several fields in one cell
    for (char& c : name) c = c == ',' ? '+' : c;
    head += name + ",";
  }
  head += fmt::format("{}\n", fmt::join(columns, ","));
  ordered_json json;
  json["scene"] = first.scene.name;
  json["delay_packets"] = a.common.delay_packets;
  json["assumptions"] = first.assumptions;
  for (const SweepAxis& axis : grid.axes())
    json["axes"].push_back({{"name", axis.name}, {"values", axis.values}});
  json["columns"] = columns;
  json["checked_on_the_loop"] = {{"points", check.points},
                                 {"verdicts_that_differ", check.differ},
                                 {"largest_difference", check.largest_difference}};
  json["points"] = ordered_json::array();
  std::int64_t stable = 0;
  constexpr std::int64_t kShown = 20;
  for (std::int64_t p = 0; p < points; ++p) {
    const SweepRow& row = rows[static_cast<std::size_t>(p / block)];
    const double* found = row.data() + 3 + static_cast<std::size_t>(p % block) * columns.size();
    stable += found[1] != 0.0 ? 1 : 0;
    const bool shown = p < kShown && a.csv.empty();
    std::string line;
    if (!a.csv.empty() || shown) {
      for (const double value : grid.values(p)) line += fmt::format("{},", value);
      for (std::size_t c = 0; c < columns.size(); ++c)
        line += fmt::format("{}{}", c > 0 ? "," : "", found[c]);
      line += '\n';
    }
    if (!a.csv.empty()) csv += line;
    if (shown) text += "  " + line;
    if (!a.common.json.wanted()) continue;
    ordered_json values = ordered_json::array();
    for (std::size_t c = 0; c < columns.size(); ++c) values.push_back(number(found[c]));
    json["points"].push_back(std::move(values));
  }
  json["stable"] = stable;
  if (!a.csv.empty() && a.csv != "-") write_text(a.csv, head + csv);
  if (a.csv == "-") {
    fmt::print("{}{}", head, csv);
  } else if (!a.common.json.to_stdout()) {
    if (!text.empty()) text = "  " + head + text;
    if (points > kShown && a.csv.empty())
      text += fmt::format("  ... and {} more: --csv FILE has all\n", points - kShown);
    fmt::print(
        "{}: {} of {} points stable\n{}{}  one point in {} judged again on the running loop: {} "
        "points, {} verdicts differ, spectral radii by {:.1e} at most\n",
        first.scene.name, stable, points, first.assumed(), text, a.check_every, check.points,
        check.differ, check.largest_difference);
  }
  a.common.json.write(json);
  if (check.differ > 0)
    throw Failed(
        fmt::format("{} of {} points are judged otherwise on the running loop: do not use "
                    "this sweep, report the scene",
                    check.differ, check.points));
}

void run(const SweepArguments& a) {
  const AnalyzedScene base = a.common.load();
  const core::Scene scene = a.common.scene.load();
  std::vector<SweepAxis> axes;
  for (const std::string& text : a.axes) axes.push_back(parse_axis(scene, text));
  for (std::size_t i = 0; i < axes.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (axes[i].name == axes[j].name)
        throw CLI::ValidationError("--axis", axes[i].name + " is given twice");
  const SweepGrid grid(scene, std::move(axes), a.common.delay_packets);
  const Wanted wanted = wanted_of(a, base.scene);
  const std::size_t columns = wanted.columns().size();
  const double numbers = static_cast<double>(columns + grid.axes().size());
  refuse_too_large(grid.count(),
                   16.0 * numbers + (a.csv.empty() ? 0.0 : 20.0 * numbers) +
                       (a.common.json.wanted() ? 60.0 * numbers : 0.0),
                   "the sweep");

  ordered_json settings = scene_settings(scene, a.common.delay_packets);
  for (const SweepAxis& axis : grid.axes())
    settings["axes"].push_back({{"name", axis.name}, {"values", axis.values}});
  settings["columns"] = wanted.columns();
  settings["felt_by"] = wanted.port;
  settings["check_every"] = a.check_every;
  SweepSession session(a.sweep, "sweep", settings);

  const bool by_map = analysis::why_not_resampled(base.scene, base.network).empty();
  const auto points = static_cast<std::int64_t>(grid.count());
  const std::int64_t block = !by_map ? 1 : wanted.margins ? 5 : 100;
  const auto make_work = [&]() -> SweepWork {
    return [&, s = AnalyzedScene{}](std::int64_t item) mutable {
      analysis::LoopCheck check;
      SweepRow row(3, 0.0);
      const std::int64_t last = std::min(points, (item + 1) * block);
      for (std::int64_t p = item * block; p < last; ++p) {
        double packets = 0.0, growth = 0.0;
        try {
          grid.place(p, s, packets);
          find_out(s, packets, wanted, row, growth);
          if (by_map && a.check_every > 0 && p % a.check_every == 0)
            check.add(growth, analysis::judge(analysis::measured_system(s.scene, s.network)).radius,
                      growth < 1.0);
        } catch (const std::exception& e) {
          std::string where;
          const std::vector<double> at = grid.values(p);
          for (std::size_t i = 0; i < at.size(); ++i)
            where += fmt::format(" {}={}", grid.axes()[i].name, at[i]);
          throw Failed("at" + where + ": " + e.what());
        }
      }
      row[0] = static_cast<double>(check.points);
      row[1] = static_cast<double>(check.differ);
      row[2] = check.largest_difference;
      return row;
    };
  };
  const auto rows = session.run("points", (points + block - 1) / block, make_work);
  if (!session.tells()) return;
  tell(a, grid, base, wanted, rows, block);
}

}  // namespace

void add_analyze_sweep(CLI::App& analyze) {
  CLI::App* command = analyze.add_subcommand(
      "sweep", "growth, what is felt and margins at every point of a grid of any dimension");
  auto a = std::make_shared<SweepArguments>();
  a->common.add(*command);
  command
      ->add_option("--axis", a->axes,
                   "FIELD[,FIELD...]=FROM:TO:COUNT[log] or =VALUE,VALUE,...; any number of times. "
                   "FIELD: any of the scene (coupler.ko1.stiffness), or delay_packets")
      ->required()
      ->take_all()
      ->allow_extra_args(false);
  command
      ->add_option("--report", a->report,
                   "what to find out: growth (always), felt, margins (slower); commas between")
      ->delimiter(',')
      ->check(CLI::IsMember({"growth", "felt", "margins"}))
      ->capture_default_str();
  command->add_option("--user", a->user, "whose first finger feels it (default: the first user)");
  add_csv(*command, a->csv, "write all points to this file; - is stdout");
  command
      ->add_option("--check-every", a->check_every,
                   "judge one point in so many again on the running loop; 0: none")
      ->check(CLI::Range(0, 1000000))
      ->capture_default_str();
  a->sweep.add(*command);
  on_call(*command, a, run);
}

}  // namespace tandem::cli
