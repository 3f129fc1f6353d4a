#include <cmath>

#include <fmt/format.h>

#include "analysis/compensate.h"
#include "analysis/drag.h"
#include "analysis/grasp_response.h"
#include "cli/analyze.h"
#include "cli/commands.h"

namespace tandem::cli {

namespace {

using nlohmann::ordered_json;

struct CompensateOptions {
  AnalyzeOptions common;
  std::string csv;
  double leave = 0.1;
};

const char* axis_name(std::size_t axis) { return axis == 0 ? "x" : axis == 1 ? "y" : "rotation"; }

/// Drag of a user alone along every axis, on the map measured from the running loop.
std::vector<double> measured_drag(const core::Scene& scene, const core::NetworkModel& network,
                                  std::size_t user) {
  const core::Scene alone = analysis::with_one_hand(scene, scene.users[user].name);
  const auto system = analysis::measured_system(alone, network);
  const auto m =
      analysis::felt_motion(system, analysis::grasp_axes(system, alone, static_cast<int>(user), 0));
  std::vector<double> out;
  for (int i = 0; i < m.mean_damping.rows; ++i) out.push_back(m.mean_damping(i, i));
  return out;
}

struct Variant {
  std::string name;
  core::Scene scene;
  analysis::LoopReport report;
};

ordered_json json_of(const Variant& v, const core::Scene& scene) {
  const analysis::LoopReport& r = v.report;
  ordered_json out;
  out["variant"] = v.name;
  out["growth_per_packet"] = number(r.radius);
  out["growth_per_packet_alone"] = number(r.radius_alone);
  out["stable"] = r.stable();
  for (std::size_t u = 0; u < r.drag.size(); ++u)
    for (std::size_t a = 0; a < r.drag[u].size(); ++a)
      out["drag_alone"][scene.users[u].name][axis_name(a)] = number(r.drag[u][a]);
  out["stiffness_factor"] = r.stiffness_open ? ordered_json(nullptr) : number(r.stiffness_factor);
  out["damping_factor"] = r.damping_open ? ordered_json(nullptr) : number(r.damping_factor);
  out["delay_left_ticks"] = r.delay_ticks ? ordered_json(*r.delay_ticks) : ordered_json(nullptr);
  return out;
}

std::string row_of(const Variant& v) {
  const analysis::LoopReport& r = v.report;
  std::string text = fmt::format(
      "    {:12} {:11.7f} {:11.7f}  {:>9} {:>9} {:>9}", v.name, r.radius, r.radius_alone,
      r.stiffness_open ? "over 20" : fmt::format("{:.4f}", r.stiffness_factor),
      r.damping_open ? "over 20" : fmt::format("{:.4f}", r.damping_factor),
      r.delay_ticks ? fmt::format("{}", *r.delay_ticks) : "over 10 N");
  for (const auto& user : r.drag)
    for (const double d : user) text += fmt::format(" {:11.6g}", d);
  return text + (r.stable() ? "\n" : "  NOT stable\n");
}

void compensate_object(const CompensateOptions& o, const AnalyzedScene& s, int object,
                       ordered_json& json, std::string& csv, std::string& text) {
  const std::string& name = s.scene.objects[object].name;
  const auto found = analysis::compensators(s.scene, s.network, object, o.leave);
  ordered_json out;
  text += fmt::format("  object {}\n", name);
  std::string sets;
  for (const analysis::Compensator& c : found) {
    const char* unit = &c == &found.front() ? "N s/m" : "N m s/rad";
    text += fmt::format(
        "    {}: net damping is zero, or the loop unstable otherwise, at\n"
        "      {:.8g} {} of each copy without delay, {:.8g} at this delay; in the simplified "
        "model\n"
        "      without delay at {:.8g}. The rule gives {:.8g}: {:g} of what {} bears\n",
        c.field, c.cancels_undelayed, unit, c.cancels_now, c.simplified_undelayed, c.value,
        1.0 - o.leave, c.bound_by);
    out["compensators"].push_back({{"field", c.field},
                                   {"value", number(c.value)},
                                   {"cancels_no_delay", number(c.cancels_undelayed)},
                                   {"cancels_at_this_delay", number(c.cancels_now)},
                                   {"simplified_no_delay", number(c.simplified_undelayed)},
                                   {"bound_by", c.bound_by}});
    sets += fmt::format("{}--set {}={:.6g}", sets.empty() ? "" : " ", c.field, c.value);
  }
  const core::Scene plain = [&] {
    core::Scene scene = analysis::with_one_object(s.scene, object);
    scene.objects[0].compensation = scene.objects[0].compensation_rotation = 0.0;
    return scene;
  }();
  Variant variants[] = {{"hold", plain, {}},
                        {"compensated", analysis::compensated(plain, 0, found), {}},
                        {"extrapolated", plain, {}}};
  variants[2].scene.reconstruction.kind = core::ReconstructionKind::kExtrapolate;
  text += fmt::format("    {:12} {:>11} {:>11}  {:>9} {:>9} {:>9}", "", "growth", "worst alone",
                      "stiffness", "damping", "delay");
  for (const auto& user : plain.users)
    for (std::size_t a = 0; a < (plain.space == core::Space::kAxis ? 1u : 3u); ++a)
      text += fmt::format(" {:>11}", fmt::format("{}: {}", user.name, axis_name(a)));
  text += "\n";
  for (Variant& v : variants) {
    v.report = analysis::report_loop(v.scene, s.network, 0);
    text += row_of(v);
    out["variants"].push_back(json_of(v, plain));
    csv += fmt::format("{},{},{},{},{},{},{}", name, v.name, v.report.radius, v.report.radius_alone,
                       v.report.stiffness_factor, v.report.damping_factor,
                       v.report.delay_ticks.value_or(-1));
    for (const auto& user : v.report.drag)
      for (const double d : user) csv += fmt::format(",{}", d);
    csv += "\n";
  }
  // Once more on the map of the running loop itself.
  text += "    compensated, drag measured on the running loop:";
  for (std::size_t u = 0; u < plain.users.size(); ++u) {
    const auto drag = measured_drag(variants[1].scene, s.network, u);
    for (std::size_t a = 0; a < drag.size(); ++a) {
      text += fmt::format(" {} {} {:.8g}", plain.users[u].name, axis_name(a), drag[a]);
      out["measured_drag_compensated"][plain.users[u].name][axis_name(a)] = number(drag[a]);
    }
  }
  text += "\n";
  const bool nothing =
      std::all_of(found.begin(), found.end(), [](const auto& c) { return c.value == 0.0; });
  if (nothing)
    text +=
        "    nothing to compensate: somebody feels no drag, and any compensation would drive "
        "the object\n";
  else
    text += "    in the scene file, or: " + sets + "\n";
  out["set"] = nothing ? "" : sets;
  json["objects"][name] = std::move(out);
}

void run(const CompensateOptions& o) {
  const AnalyzedScene s = o.common.load_with_object("compensation");
  ordered_json json;
  json["scene"] = s.scene.name;
  json["delay_packets"] = o.common.delay_packets;
  json["assumptions"] = s.assumptions;
  json["left_of_the_least"] = o.leave;
  std::string text = fmt::format(
      "{}, round trip {:.6g} packets: negative damping that gives back the drag (thesis 6.1)\n{}{}"
      "  growth a packet period, all users and the worst alone; factors that all stiffnesses and\n"
      "  all dampings may grow by; ticks of delay left; drag felt by each user alone [N s/m, N m "
      "s/rad]\n",
      s.scene.name, o.common.delay_packets, s.assumed(), s.grasp());
  std::string csv =
      "object,variant,growth,growth_alone,stiffness_factor,damping_factor,delay_left_ticks";
  for (const auto& user : s.scene.users)
    for (std::size_t a = 0; a < (s.scene.space == core::Space::kAxis ? 1u : 3u); ++a)
      csv += fmt::format(",drag_{}_{}", user.name, axis_name(a));
  csv += "\n";
  for (int i = 0; i < static_cast<int>(s.scene.objects.size()); ++i)
    compensate_object(o, s, i, json, csv, text);
  o.common.tell(o.csv, csv, text, json);
}

}  // namespace

void add_analyze_compensate(CLI::App& analyze) {
  CLI::App* command = analyze.add_subcommand(
      "compensate",
      "negative damping for every object and axis by the safety rule of 6.1, what it costs, and "
      "extrapolation beside it");
  auto o = std::make_shared<CompensateOptions>();
  o->common.add(*command);
  command
      ->add_option("--leave", o->leave,
                   "part of the smallest net damping that is left; 0 is its very edge")
      ->check(between(0.0, 1.0))
      ->capture_default_str();
  add_csv(*command, o->csv, "write the variants to this file");
  on_call(*command, o, run);
}

}  // namespace tandem::cli
