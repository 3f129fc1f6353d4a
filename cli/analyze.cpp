#include "cli/analyze.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <thread>

#include <fmt/format.h>

#include "analysis/closed_form_rows.h"
#include "analysis/closed_forms.h"
#include "analysis/drag.h"
#include "analysis/grasp_response.h"
#include "analysis/resampled.h"
#include "analysis/response.h"
#include "analysis/stability.h"
#include "cli/commands.h"

namespace tandem::cli {

using nlohmann::ordered_json;

void AnalyzeOptions::add(CLI::App& command) {
  scene.add(command);
  json.add(command);
  command
      .add_option("--delay-packets", delay_packets,
                  "round trip in packet periods, all of it one way; fractions are ticks")
      ->check(between(0.0, 60.0));
  command.add_flag("--own-packet-timer", own_packet_timer,
                   "packets leave exactly at k / packet_hz with the state of the tick before, as "
                   "from a thread with its own timer; matters where the rates are not multiples");
}

void AnalyzeOptions::tell(const std::string& csv_file, const std::string& csv,
                          const std::string& text, const ordered_json& object) const {
  if (!csv_file.empty()) write_text(csv_file, csv);
  if (!json.to_stdout()) fmt::print("{}", text);
  json.write(object);
}

void add_csv(CLI::App& command, std::string& file, const std::string& help) {
  command.add_option("--csv", file, help)->check(writable_file, "", "writable");
}

AnalyzedScene AnalyzeOptions::load() const {
  const core::Scene given = scene.load();
  if (given.objects.empty() && given.space != core::Space::kAxis)
    throw CLI::ValidationError(
        "--scene", given.name + " has no object, and walls alone are analysed in space: AXIS only");
  analysis::LinearScene linear = analysis::linear_scene(given);
  AnalyzedScene out{std::move(linear.scene), {}, std::move(linear.assumptions)};
  out.network.set_round_trip(delay_packets, out.scene.ticks_per_packet());
  if (own_packet_timer) out.network.packet_timer = core::PacketTimer::kOwn;
  return out;
}

AnalyzedScene AnalyzeOptions::load_with_object(const std::string& what) const {
  AnalyzedScene out = load();
  if (out.scene.objects.empty())
    throw CLI::ValidationError("--scene", out.scene.name + " has no object, which " + what +
                                              " is about; point, stability, admittance, bounds "
                                              "and sweep know walls");
  return out;
}

analysis::LiftedSystem AnalyzedScene::lift() const {
  return analysis::lifted_system(scene, network);
}

std::string AnalyzedScene::grasp() const {
  if (scene.space != core::Space::kPlane) return {};
  std::string text;
  for (const auto& user : scene.users)
    for (const auto& finger : user.fingers)
      text += fmt::format("  finger {}.{} holds {} at ({:.4g}, {:.4g}) mm from its centre\n",
                          user.name, finger.name, scene.objects[0].name,
                          1e3 * (finger.position.x - scene.objects[0].position.x),
                          1e3 * (finger.position.y - scene.objects[0].position.y));
  return text;
}

std::string AnalyzedScene::assumed() const {
  std::string text;
  for (const std::string& a : assumptions) text += "  assumed: " + a + "\n";
  return text;
}

namespace {

ordered_json modes_of(const analysis::LiftedSystem& system, const analysis::Judgement& judged,
                      std::string& text) {
  const double period = system.period / system.packets;
  ordered_json modes = ordered_json::array();
  text += "  modes, slowest first (modulus a packet period, frequency, time constant)\n";
  int shown = 0;
  for (const auto& z : analysis::packet_modes(system, judged)) {
    if (z.imag() < 0.0 || std::abs(z) < 0.02) continue;
    const double frequency = std::arg(z) / (2.0 * std::numbers::pi * period);
    const double constant = -period / std::log(std::abs(z));
    modes.push_back({{"modulus", number(std::abs(z))},
                     {"frequency_hz", number(frequency)},
                     {"time_constant_s", number(constant)}});
    if (shown++ < 8)
      text += fmt::format("    {:.10f}  {:8.3f} Hz  {:9.4f} s{}\n", std::abs(z), frequency,
                          constant, std::abs(z) < 1.0 ? "" : "  grows");
  }
  return modes;
}

ordered_json gain_margin(analysis::StabilityJudge& judge, const core::Scene& scene,
                         const std::string& field, double now,
                         const analysis::IntervalOptions& options, std::string& text) {
  const analysis::Knob knob(scene, field);
  const double top = 100.0 * now;
  const auto stable = analysis::stable_intervals(judge, scene, knob, 1e-3 * now, top, options);
  ordered_json intervals = ordered_json::array();
  std::string listed;
  for (const auto& i : stable) {
    intervals.push_back({number(i.low), number(i.high)});
    listed += fmt::format(
        "{}{} .. {}", listed.empty() ? "" : "; ",
        i.low <= 1e-3 * now ? "0" : fmt::format("{:.6g}", i.low),
        i.high >= top ? "over " + fmt::format("{:.4g}", top) : fmt::format("{:.6g}", i.high));
  }
  text +=
      fmt::format("    {:33} now {:8.6g}: {}\n", field, now, listed.empty() ? "nowhere" : listed);
  return {{"now", now}, {"stable", intervals}, {"scanned_to", top}};
}

/// How far each gain may move with all others as they are.
ordered_json gain_margins(const AnalyzedScene& s, std::string& text) {
  ordered_json out;
  analysis::StabilityJudge judge(s.scene, s.network);
  analysis::IntervalOptions options;
  options.samples = std::string(judge.road()) == "routh" ? 300 : 80;
  options.tolerance = 1e-9;
  text += "  each gain by itself, stable between\n";
  const bool plane = s.scene.space == core::Space::kPlane;
  for (const core::CouplerParameters& c : s.scene.couplers)
    for (const auto& [gain, kind] : {std::pair{&c.gain, plane ? "normal." : ""},
                                     {&c.tangential, "tangential."},
                                     {&c.rotation, "rotation."}})
      for (const char* what : {"stiffness", "damping"}) {
        const double now = what[0] == 's' ? gain->stiffness : gain->damping;
        if (now <= 0.0 || (!plane && gain != &c.gain)) continue;
        const std::string field = "coupler." + c.name + "." + kind + what;
        out[field] = gain_margin(judge, s.scene, field, now, options, text);
      }
  for (const core::WallParameters& w : s.scene.walls)
    for (const auto& [what, now] :
         {std::pair{"stiffness", w.gain.stiffness}, {"damping", w.gain.damping}}) {
      if (plane || now <= 0.0) continue;
      const std::string field = "wall." + w.name + "." + what;
      out[field] = gain_margin(judge, s.scene, field, now, options, text);
    }
  return out;
}

/// Ticks of round trip, one by one from what is there, until it is no longer stable.
ordered_json delay_margin(const AnalyzedScene& s, double packets, std::string& text) {
  const double N = s.scene.ticks_per_packet();
  const int now = static_cast<int>(std::ceil(packets * N - 1e-9));
  const int last = now + static_cast<int>(20.0 * N);
  for (int ticks = now; ticks <= last; ++ticks) {
    AnalyzedScene later = s;
    later.network.set_round_trip(ticks / N, N);
    if (analysis::judge(later.lift()).stable()) continue;
    text += ticks == now
                ? "  delay: not stable as it is\n"
                : fmt::format("  delay: {} more ticks of round trip are borne, {} are not\n",
                              ticks - now - 1, ticks - now);
    return ticks - now - 1;
  }
  text += fmt::format("  delay: {} more ticks of round trip are borne\n", last - now);
  return nullptr;
}

ordered_json rows_of(const analysis::Matrix& m) {
  ordered_json rows = ordered_json::array();
  for (int i = 0; i < m.rows; ++i) {
    rows.push_back(ordered_json::array());
    for (int j = 0; j < m.cols; ++j) rows.back().push_back(number(m(i, j)));
  }
  return rows;
}

/// A grasp in the plane: along x and y and in rotation about the object's centre.
ordered_json felt_axes(const analysis::FeltMotion& m, const std::vector<analysis::GraspAxis>& axes,
                       const std::string& who, std::string& text) {
  ordered_json out;
  text += "  " + who + " feels in slow free motion\n";
  double coupled = 0.0;
  for (int i = 0; i < static_cast<int>(axes.size()); ++i) {
    const bool turns = axes[i].turns();
    out[axes[i].name] = {
        {turns ? "damping_n_m_s_per_rad" : "damping_n_s_per_m", number(m.mean_damping(i, i))},
        {turns ? "damping_sampled_n_m_s_per_rad" : "damping_sampled_n_s_per_m",
         number(m.sampled_damping(i, i))},
        {turns ? "inertia_kg_m2" : "inertia_kg", number(m.inertia(i, i))}};
    text += fmt::format("    {:9} {:.10g} {} and {:.6g} {}\n", axes[i].name, m.mean_damping(i, i),
                        turns ? "N m s/rad" : "N s/m", m.inertia(i, i), turns ? "kg m^2" : "kg");
    for (int j = 0; j < i; ++j)
      coupled = std::max(
          coupled, std::abs(m.mean_damping(i, j)) /
                       std::sqrt(std::abs(m.mean_damping(i, i) * m.mean_damping(j, j)) + 1e-300));
  }
  if (coupled > 1e-6 && coupled < 1e6)
    text += fmt::format("    axes are coupled, by up to {:.3g} of their mean: see the matrix\n",
                        coupled);
  out["order"] = {"x", "y", "rotation"};
  out["damping_matrix"] = rows_of(m.mean_damping);
  out["inertia_matrix"] = rows_of(m.inertia);
  return out;
}

/// (6.4) beside the direct solve, where its assumptions hold: free hands, one wall at the object,
/// for distributed scenes user 1.
ordered_json stiffness_formulas(const core::Scene& scene, const std::string& user,
                                std::string& text) {
  ordered_json out = ordered_json::object();
  if (scene.walls.size() != 1 || scene.walls[0].touches_fingers || scene.users.size() != 2)
    return out;
  for (const core::UserParameters& u : scene.users)
    for (const core::FingerParameters& finger : u.fingers)
      if (u.fingers.size() != 1 || finger.hand.stiffness > 0.0) return out;
  const double wall = scene.walls[0].gain.stiffness;
  if (scene.architecture == core::Architecture::kCentral) {
    for (const core::CouplerParameters& c : scene.couplers)
      if (c.user == user) {
        const double k = analysis::stiffness_in_series(c.gain.stiffness, wall);
        out["formula_n_per_m"] = k;
        text += fmt::format("      by (6.4) {:.10g} N/m\n", k);
      }
    return out;
  }
  if (scene.architecture != core::Architecture::kDistributed || user != scene.users[0].name)
    return out;
  try {
    const analysis::CopiesNumbers n = analysis::copies_numbers(scene);
    const double k = analysis::stiffness_6_4_corrected(n, wall);
    out["formula_n_per_m"] = k;
    out["formula_as_printed_n_per_m"] = analysis::stiffness_6_4(n, wall);
    text += fmt::format("      by (6.4) corrected {:.10g} N/m; as printed {:.10g}\n", k,
                        analysis::stiffness_6_4(n, wall));
  } catch (const std::domain_error&) {  // no formula for unequal couplers between the copies
  }
  return out;
}

ordered_json felt(const AnalyzedScene& s, std::string& text) {
  ordered_json out;
  for (std::size_t u = 0; u < s.scene.users.size(); ++u) {
    const std::string& user = s.scene.users[u].name;
    AnalyzedScene alone = s;
    alone.scene = analysis::with_one_hand(s.scene, user);
    const std::pair<const char*, const AnalyzedScene*> hands[] = {{"together", &s},
                                                                  {"alone", &alone}};
    for (const auto& [what, which] : hands) {
      const analysis::LiftedSystem system = which->lift();
      if (s.scene.space == core::Space::kPlane) {
        const auto axes = analysis::grasp_axes(system, which->scene, static_cast<int>(u), 0);
        out[user][what] =
            felt_axes(analysis::felt_motion(system, axes), axes, "user " + user + " " + what, text);
        continue;
      }
      const analysis::ForcePort& port =
          analysis::port_named(system, user + "." + s.scene.users[u].fingers[0].name);
      if (system.grounded) {
        const double k = analysis::equivalent_stiffness(system, port);
        out[user][what] = {{"stiffness_n_per_m", number(k)}};
        text += fmt::format("  user {} {:9} feels {:.10g} N/m at rest\n", user, what, k);
        if (which == &alone) out[user][what].update(stiffness_formulas(s.scene, user, text));
        continue;
      }
      const analysis::FreeMotion m = analysis::free_motion(system, port);
      out[user][what] = {{"damping_n_s_per_m", number(m.mean_damping)},
                         {"damping_sampled_n_s_per_m", number(m.sampled_damping)},
                         {"inertia_kg", number(m.inertia)}};
      text += fmt::format("  user {} {:9} feels {:.10g} N s/m and {:.6g} kg in slow free motion\n",
                          user, what, m.mean_damping, m.inertia);
    }
  }
  return out;
}

void point(const AnalyzeOptions& o) {
  const AnalyzedScene s = o.load();
  const analysis::LiftedSystem system = s.lift();
  const analysis::Judgement judged = analysis::judge(system);
  const analysis::Judgement loop = analysis::judge(analysis::measured_system(s.scene, s.network));
  ordered_json json;
  json["scene"] = s.scene.name;
  json["delay_packets"] = o.delay_packets;
  json["assumptions"] = s.assumptions;
  json["states"] = system.states();
  json["removed"] = judged.removed;
  json["spectral_radius"] = number(judged.radius);
  json["log2_spectral_radius"] = number(judged.log2_radius);
  json["measured_spectral_radius"] = number(loop.radius);
  json["stable"] = judged.stable();
  std::string text = fmt::format(
      "{}, round trip {:.6g} packets: {}\n"
      "  spectral radius {:.12f} a packet period (measured on the running loop {:.12f})\n"
      "  {} states; taken out: {}\n",
      s.scene.name, o.delay_packets, judged.stable() ? "stable" : "NOT stable", judged.radius,
      loop.radius, system.states(),
      judged.removed.empty() ? "nothing" : fmt::format("{}", fmt::join(judged.removed, ", ")));
  if (judged.removed.size() > loop.removed.size())
    text += "  (its finite differences do not tell free drift from an eigenvalue of one)\n";
  text += s.assumed();
  json["modes"] = modes_of(system, judged, text);
  text += s.grasp();
  json["felt"] = felt(s, text);
  json["gains"] = gain_margins(s, text);
  if (s.scene.architecture != core::Architecture::kSingle)
    json["delay_left_ticks"] = delay_margin(s, o.delay_packets, text);
  if (!o.json.to_stdout()) fmt::print("{}", text);
  o.json.write(json);
}

ordered_json closed_forms(const core::Scene& scene, double round_trip, std::string& text) {
  const analysis::ClosedForms forms = analysis::closed_form_rows(scene, round_trip);
  ordered_json out = ordered_json::array();
  if (!forms.why_none.empty()) {
    text += "  no closed form: " + forms.why_none + "\n";
    return out;
  }
  text += fmt::format(
      "  closed forms [N s/m], beside the direct solve of what each assumes\n"
      "    {:18} {:>16} {:>16} {:>9}\n",
      "", "formula", "direct solve", "off by");
  for (const analysis::ClosedFormRow& r : forms.rows) {
    const double off = std::abs(r.formula / r.direct - 1.0);
    text += fmt::format("    {:18} {:16.12g} {:16.12g} {:9.1e}  {}\n", r.name, r.formula, r.direct,
                        off, r.assumes);
    text += r.outside.empty() ? "      holds for this scene\n"
                              : fmt::format("      not for this scene, which has {:.10g}: {}\n",
                                            r.here, fmt::join(r.outside, ", "));
    out.push_back({{"name", r.name},
                   {"assumes", r.assumes},
                   {"formula_n_s_per_m", number(r.formula)},
                   {"direct_n_s_per_m", number(r.direct)},
                   {"relative_difference", number(off)},
                   {"holds_here", r.outside.empty()},
                   {"outside", r.outside},
                   {"here_n_s_per_m", number(r.here)}});
  }
  return out;
}

void damping(const AnalyzeOptions& o) {
  const AnalyzedScene s = o.load_with_object("drag in free motion");
  std::string text = fmt::format("{}, round trip {:.6g} packets\n{}{}", s.scene.name,
                                 o.delay_packets, s.assumed(), s.grasp());
  ordered_json json;
  json["scene"] = s.scene.name;
  json["delay_packets"] = o.delay_packets;
  json["original"] = felt(s, text);
  // Fig 6.3: no hand couplers, the force goes to the copies themselves.
  AnalyzedScene simple = s;
  std::erase_if(simple.scene.couplers, [](const auto& c) { return !c.user.empty(); });
  if (analysis::why_not_resampled(simple.scene, simple.network).empty() &&
      simple.scene.walls.empty()) {
    const analysis::LiftedSystem system = simple.lift();
    if (s.scene.space == core::Space::kPlane) {
      const auto axes = analysis::object_axes(system, simple.scene, 0);
      json["simplified"] = {
          {"on every copy", felt_axes(analysis::felt_motion(system, axes), axes,
                                      "the simplified model, force on every copy,", text)}};
      if (!o.json.to_stdout()) fmt::print("{}", text);
      o.json.write(json);
      return;
    }
    std::size_t hands = 0;
    for (const auto& user : s.scene.users) hands += user.fingers.size();
    const analysis::ForcePort first = system.ports.at(hands);
    analysis::ForcePort all = first;
    for (std::size_t i = hands + s.scene.objects.size(); i < system.ports.size();
         i += s.scene.objects.size())
      all = analysis::joined(all, system.ports[i]);
    const std::pair<const char*, const analysis::ForcePort*> pushes[] = {{"on every copy", &all},
                                                                         {"on one copy", &first}};
    for (const auto& [what, port] : pushes) {
      const analysis::FreeMotion m = analysis::free_motion(system, *port);
      json["simplified"][what] = {{"damping_n_s_per_m", number(m.mean_damping)},
                                  {"damping_sampled_n_s_per_m", number(m.sampled_damping)}};
      text += fmt::format("  simplified model, force {:13}: {:.10g} N s/m (sampled {:.10g})\n",
                          what, m.mean_damping, m.sampled_damping);
    }
  }
  json["closed_forms"] = closed_forms(s.scene, o.delay_packets, text);
  if (!o.json.to_stdout()) fmt::print("{}", text);
  o.json.write(json);
}

}  // namespace

void add_analyze(CLI::App& app) {
  CLI::App* analyze = app.add_subcommand(
      "analyze", "what is stable and what the hand feels, exactly, from the same scene");
  analyze->require_subcommand(1);
  const auto with_scene = [&](const char* name, const char* about,
                              void (*run)(const AnalyzeOptions&)) {
    CLI::App* command = analyze->add_subcommand(name, about);
    auto o = std::make_shared<AnalyzeOptions>();
    o->add(*command);
    command->callback([o, run] {
      try {
        run(*o);
      } catch (const std::domain_error& e) {
        throw Failed(e.what());
      }
    });
  };
  with_scene("point", "spectral radius, modes, what is felt, and margins of one scene", point);
  with_scene("damping", "drag in free motion (6.2) by a direct solve, both models", damping);
  add_analyze_admittance(*analyze);
  add_analyze_bounds(*analyze);
  add_analyze_compensate(*analyze);
  add_analyze_stability(*analyze);
  add_analyze_sweep(*analyze);
  add_analyze_network(*analyze);
  add_analyze_check(*analyze);
  add_analyze_figure(*analyze);
}

}  // namespace tandem::cli
