#include "cli/netem_report.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>
#include <sys/utsname.h>
#include <thread>
#include <unistd.h>

#include <fmt/format.h>

#include "cli/commands.h"
#include "cli/contest_json.h"
#include "cli/options.h"
#include "cli/script_path.h"
#include "harness/statement.h"
#include "scene/shared_hash.h"

namespace tandem::cli {

namespace {

using harness::PointResult;
using nlohmann::ordered_json;

ordered_json stability_json(const harness::Stability& s) {
  ordered_json out;
  out["judged"] = s.judged;
  out["stable"] = s.stable;
  if (!s.reason.empty()) out["reason"] = s.reason;
  out["growth_per_s"] = number_or_word(s.growth_per_s);
  out["growth_per_packet"] = number_or_word(s.growth_per_packet);
  return out;
}

ordered_json twin_json(const harness::VirtualTwin& t) {
  ordered_json out{{"judged", t.judged}, {"stable", t.stable}, {"near_boundary", t.near_boundary}};
  if (std::isfinite(t.drag)) out["drag_n_s_per_m"] = t.drag;
  return out;
}

ordered_json try_json(const harness::BoundaryTry& t) {
  ordered_json out = stability_json(t.stability);
  out["coupling_over_that_of_its_own_delays"] = number_or_word(t.ratio);
  out["virtual_time"] = twin_json(t.twin);
  return out;
}

ordered_json seen_json(const harness::SeenLink& l) {
  ordered_json out{{"from", l.from},
                   {"to", l.to},
                   {"set", l.set},
                   {"delay_p50_s", number(l.delay_p50)},
                   {"delay_p50_expected_s", l.expected.delay_p50},
                   {"delay_sd_s", number(l.delay_sd)},
                   {"delay_rms_of_all_s", number(l.delay_rms)},
                   {"delay_sd_expected_s", l.expected.delay_sd},
                   {"loss", number(l.loss)},
                   {"loss_expected", l.expected.loss},
                   {"loss_interval", 3.3 * l.expected.loss_sd},
                   {"sent", l.sent},
                   {"lost", l.lost},
                   {"duplicates", l.duplicates},
                   {"duplicates_expected", l.expected.duplicates},
                   {"reordered", l.reordered},
                   {"reordered_expected", l.expected.reordered},
                   {"out_of_bounds", harness::out_of_bounds(l)},
                   {"delay_ticks", number(l.delay_ticks)},
                   {"phase_ticks", number(l.phase_ticks)},
                   {"age_error_ticks", number(l.age_error_ticks)},
                   {"used_share", number(l.used_share)}};
  if (l.rate_set > 0.0) out["rate_bit_per_s"] = {{"set", l.rate_set}, {"seen", l.rate_seen}};
  return out;
}

/// Conditions whose probe was out of its bounds, each once.
std::vector<std::string> not_as_set(const std::vector<PointResult>& results, int& probed) {
  std::vector<std::string> out;
  std::set<std::string> known;
  for (const PointResult& r : results)
    for (const harness::SeenLink& l : r.seen) {
      if (l.sent <= 0 || !known.insert(l.set).second) continue;
      for (const std::string& what : harness::out_of_bounds(l)) out.push_back(l.set + ": " + what);
    }
  probed = static_cast<int>(known.size());
  return out;
}

ordered_json prediction_json(const harness::Prediction& p) {
  ordered_json out;
  out["judged"] = p.judged;
  out["exact"] = p.exact;
  if (!p.note.empty()) out["note"] = p.note;
  if (!p.judged) return out;
  out["stable"] = p.stable;
  out["growth_per_packet"] = number(p.growth_per_packet);
  out["near_boundary"] = p.near_boundary;
  out["drag_n_s_per_m"] = number(p.drag);
  out["rendered_stiffness_n_per_m"] = number(p.stiffness);
  out["largest_coupling_n_per_m"] = number_or_word(p.largest_coupling);
  return out;
}

ordered_json measures_json(const PointResult& r) {
  const harness::Measures& m = r.measures;
  ordered_json out;
  out["stability"] = stability_json(m.stability);
  out["largest_coupling_n_per_m"] = number_or_word(r.largest_coupling);
  if (r.below.done) out["at_0.9_of_predicted"] = try_json(r.below);
  if (r.above.done) out["at_1.1_of_predicted"] = try_json(r.above);
  out["drag_n_s_per_m"] = number(m.drag);
  out["drag_settled"] = m.drag_settled;
  out["rendered_stiffness_n_per_m"] = number(m.rendered_stiffness);
  out["gap_rms_m"] = number(m.gap_rms);
  out["gap_99.9_percent_m"] = number(m.gap_999);
  out["motion_to_force_s"] = number(m.motion_to_force);
  out["sites"] = ordered_json::array();
  for (std::size_t i = 0; i < m.sites.size(); ++i) {
    const harness::SiteMeasures& s = m.sites[i];
    ordered_json site;
    if (i < r.point.scene.users.size()) site["user"] = r.point.scene.users[i].name;
    site["packets_per_s"] = number(s.packets_per_s);
    site["bytes_per_s"] = number(s.bytes_per_s);
    site["force_rms_n"] = number(s.force_rms);
    site["force_error_rms_n"] = number(s.force_error);
    site["force_error_rms_weber"] = number(s.force_error_weber);
    site["network_gave_most_j"] = number(s.network_energy);
    site["network_gave_at_end_j"] = number(s.network_energy_end);
    out["sites"].push_back(std::move(site));
  }
  return out;
}

std::string processor() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);)
    if (line.rfind("model name", 0) == 0) return line.substr(line.find(':') + 2);
  return "unknown";
}

std::string now_utc() {
  char text[32];
  const std::time_t now = std::time(nullptr);
  std::tm parts{};
  gmtime_r(&now, &parts);
  std::strftime(text, sizeof text, "%Y-%m-%d %H:%M UTC", &parts);
  return text;
}

ordered_json machine_json() {
  utsname u{};
  uname(&u);
  return {{"processor", processor()},
          {"processors", std::thread::hardware_concurrency()},
          {"kernel", fmt::format("{} {} {}", u.sysname, u.release, u.machine)}};
}

/// Mean over sites of one of their numbers; not a number where none has it.
double mean_of(const PointResult& r, double harness::SiteMeasures::*what) {
  double sum = 0.0;
  int n = 0;
  for (const auto& s : r.measures.sites)
    if (std::isfinite(s.*what)) sum += s.*what, ++n;
  return n > 0 ? sum / n : std::nan("");
}

double most_of(const PointResult& r, double harness::SiteMeasures::*what) {
  double most = std::nan("");
  for (const auto& s : r.measures.sites)
    if (!(most >= s.*what)) most = s.*what;
  return most;
}

std::string cell(double x, int digits = 3);

/// Every condition once: what was set and what probe saw.
std::string seen_text(const std::vector<PointResult>& results) {
  std::string text = fmt::format("  {:44} {:>15} {:>15} {:>15} {:>13}\n", "network as set",
                                 "delay p50 [ms]", "sd [ms]", "loss [%]", "rate [kbit/s]");
  text += fmt::format("  {:44} {:>7} {:>7} {:>7} {:>7} {:>7} {:>7} {:>6} {:>6}\n", "", "set",
                      "seen", "set", "seen", "set", "seen", "set", "seen");
  std::set<std::string> known;
  for (const PointResult& r : results)
    for (const harness::SeenLink& l : r.seen) {
      if (l.sent <= 0 || !known.insert(l.set).second) continue;
      const auto& e = l.expected;
      text += fmt::format("  {:44} {:>7} {:>7} {:>7} {:>7} {:>7} {:>7} {:>6} {:>6}", l.set,
                          cell(1e3 * e.delay_p50, 4), cell(1e3 * l.delay_p50, 4),
                          cell(1e3 * e.delay_sd), cell(1e3 * l.delay_sd), cell(100.0 * e.loss),
                          cell(100.0 * l.loss), l.rate_set > 0.0 ? cell(1e-3 * l.rate_set, 4) : "-",
                          l.rate_set > 0.0 ? cell(1e-3 * l.rate_seen, 4) : "-");
      if (e.duplicates > 0.0)
        text +=
            fmt::format("  duplicates {:.3g} %, seen {:.3g} %", 100.0 * e.duplicates,
                        100.0 * static_cast<double>(l.duplicates) / static_cast<double>(l.sent));
      if (e.reordered > 0.0)
        text += fmt::format("  overtaken {:.3g} %, seen {:.3g} %", 100.0 * e.reordered,
                            100.0 * static_cast<double>(l.reordered) / static_cast<double>(l.sent));
      for (const std::string& what : harness::out_of_bounds(l))
        text += "\n      OUT OF BOUNDS: " + what;
      text += "\n";
    }
  return text;
}

/// A paragraph for a terminal, as an item of a list.
std::string item(const std::string& sentence) {
  constexpr std::size_t kColumns = 100;
  std::string text = "  -";
  std::size_t used = text.size();
  constexpr char kGlue = '\x1f';  // a number and its unit stay in one line
  std::string glued = sentence;
  for (const char* unit : {" ms", " %", " = ", "= "})
    for (std::size_t at = 0; (at = glued.find(unit, at)) != std::string::npos; ++at)
      glued[glued.find(' ', at)] = kGlue;
  std::istringstream words(glued);
  for (std::string word; words >> word;) {
    std::replace(word.begin(), word.end(), kGlue, ' ');
    if (used + 1 + word.size() > kColumns) text += "\n   ", used = 3;
    text += " " + word;
    used += 1 + word.size();
  }
  return text + "\n";
}

/// Which reconstruction wins where: how to read it, the table, and what it says.
std::string statement_text(const std::vector<harness::Contests>& contests) {
  const std::vector<std::string> sentences = harness::statement(contests);
  if (sentences.empty()) return {};
  std::string text = "\n  Which reconstruction wins where\n" + item(sentences.front()) +
                     "  *: best or within 2 % of it; ~: within 10 % of the boundary\n" +
                     harness::contest_table(contests);
  for (std::size_t i = 1; i < sentences.size(); ++i) text += item(sentences[i]);
  return text + "\n";
}

std::string cell(double x, int digits) {
  if (std::abs(x) < 1e-9) x = 0.0;  // rounding has a sign
  return std::isnan(x) ? "-" : std::isinf(x) ? "inf" : fmt::format("{:.{}g}", x, digits);
}

}  // namespace

std::vector<harness::Disagreement> disagreements_of(const SweepRun& run) {
  std::vector<harness::Disagreement> found = harness::disagreements(run.results);
  const auto more = harness::disagreements(run.boundaries);
  found.insert(found.end(), more.begin(), more.end());
  return found;
}

ordered_json to_json(const SweepRun& run) {
  const auto found = disagreements_of(run);
  ordered_json json;
  json["sweep"] = run.sweep.name;
  json["title"] = run.sweep.title;
  json["knob"] = run.sweep.knob;
  json["unit"] = run.sweep.unit;
  json["on"] = run.real ? "real sockets" : "virtual time";
  json["points"] = run.results.size();
  int failed = 0, near = 0;
  double session_seconds = 0.0;
  for (const PointResult& r : run.results) {
    failed += r.failed ? 1 : 0;
    near += r.prediction.judged && r.prediction.near_boundary ? 1 : 0;
    session_seconds += r.session_seconds;
  }
  json["failed"] = failed;
  json["near_boundary"] = near;
  const auto exact = std::count_if(found.begin(), found.end(), [](auto& d) { return d.exact; });
  json["disagreements"] = exact;
  json["approximate_disagreements"] = static_cast<std::ptrdiff_t>(found.size()) - exact;
  json["disagreement_list"] = ordered_json::array();
  for (const auto& d : found)
    json["disagreement_list"].push_back({{"point", d.point}, {"what", d.what}, {"exact", d.exact}});
  const harness::Comparisons compared = harness::comparisons(run.results);
  json["verdicts_compared"] = {{"with_analysis", compared.with_analysis},
                               {"with_virtual_time", compared.with_virtual_time},
                               {"near_boundary", compared.near_boundary},
                               {"missed_ticks", compared.missed_ticks},
                               {"drags", compared.drags}};
  int probed = 0;
  const std::vector<std::string> not_set = not_as_set(run.results, probed);
  json["conditions_probed"] = probed;
  json["conditions_not_as_set"] = not_set;
  json["left_out"] = run.left_out;
  const std::vector<harness::Contests> contests = harness::contests(run.results);
  json["statement"] = harness::statement(contests);
  json["contests"] = to_json(contests);
  json["seed"] = run.seed;
  json["wall_s"] = run.wall_seconds;
  json["session_s"] = session_seconds;
  json["times_real_time"] = run.wall_seconds > 0.0 ? session_seconds / run.wall_seconds : 0.0;
  json["revision"] = revision_text();
  json["date"] = now_utc();
  json["machine"] = machine_json();
  json["granted"] = run.setting;
  json["delay_boundaries"] = ordered_json::array();
  for (const auto& b : run.boundaries)
    json["delay_boundaries"].push_back({{"scene", b.scene},
                                        {"predicted_s", number_or_word(b.predicted)},
                                        {"virtual_s", number_or_word(b.in_virtual_time)},
                                        {"real_stable_s", number_or_word(b.real_stable)},
                                        {"real_not_stable_s", number_or_word(b.real_not_stable)},
                                        {"failed", b.failure}});
  json["results"] = ordered_json::array();
  for (const PointResult& r : run.results) {
    ordered_json p;
    p["name"] = r.point.name;
    p["architecture"] = r.point.architecture;
    p["style"] = r.point.style;
    p["value"] = number(r.point.value);
    p["label"] = r.point.label;
    p["scene"] = r.point.scene_name;
    p["hash"] = fmt::format("{:016x}", scene::shared_hash(r.point.scene));
    p["edits"] = r.point.edits;
    p["network"] = {{"there", harness::to_text(r.point.network.there)},
                    {"back", harness::to_text(r.point.network.back)}};
    p["mean_age_s"] = number(r.mean_age);
    p["coupling_name"] = harness::coupling_name(r.point.scene);
    p["coupling_n_per_m"] = number(r.prediction.coupling);
    if (r.failed) p["failed"] = r.log;
    if (!r.failed && !r.log.empty()) p["log"] = r.log;
    p["predicted"] = prediction_json(r.prediction);
    p["measured"] = measures_json(r);
    p["seen"] = ordered_json::array();
    for (const auto& l : r.seen) p["seen"].push_back(seen_json(l));
    if (r.real) {
      p["virtual_time_over_recorded_packets"] = twin_json(r.twin);
      p["missed_ticks_share"] = number(r.missed_share);
    }
    if (!r.real) p["wall_s"] = r.wall_seconds;
    p["session_s"] = r.session_seconds;
    json["results"].push_back(std::move(p));
  }
  json["scenes"] = ordered_json::object();
  for (const PointResult& r : run.results) {
    const std::string hash = fmt::format("{:016x}", scene::shared_hash(r.point.scene));
    if (!json["scenes"].contains(hash)) json["scenes"][hash] = harness::scene_text(r.point);
  }
  return json;
}

std::string to_csv(const SweepRun& run) {
  std::string text =
      "name,architecture,style,label,value,mean_age_s,failed,predicted_stable,"
      "predicted_growth_per_packet,near_boundary,stable,growth_per_packet,predicted_coupling,"
      "largest_coupling,predicted_drag,drag,predicted_stiffness,stiffness,gap_rms_m,gap_999_m,"
      "motion_to_force_s,force_error_n,force_error_weber,network_gave_j,packets_per_s,bytes_per_"
      "s\n";
  for (const PointResult& r : run.results) {
    const auto& p = r.prediction;
    const auto& m = r.measures;
    text += fmt::format(
        "\"{}\",{},{},\"{}\",{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{}\n",
        r.point.name, r.point.architecture, r.point.style, r.point.label, r.point.value, r.mean_age,
        int{r.failed}, int{p.stable}, p.growth_per_packet, int{p.near_boundary},
        int{m.stability.stable}, m.stability.growth_per_packet, p.largest_coupling,
        r.largest_coupling, p.drag, m.drag, p.stiffness, m.rendered_stiffness, m.gap_rms, m.gap_999,
        m.motion_to_force, mean_of(r, &harness::SiteMeasures::force_error),
        mean_of(r, &harness::SiteMeasures::force_error_weber),
        most_of(r, &harness::SiteMeasures::network_energy),
        mean_of(r, &harness::SiteMeasures::packets_per_s),
        mean_of(r, &harness::SiteMeasures::bytes_per_s));
  }
  return text;
}

std::string to_text(const SweepRun& run) {
  std::string text =
      fmt::format("{}: {}, {}\n  {:44} {:>12} {:>12} {:>15} {:>13} {:>8} {:>8}\n", run.sweep.name,
                  run.sweep.title, run.real ? "on real sockets" : "in virtual time", "point",
                  "predicted", "measured", "coupling [N/m]", "drag [N s/m]", "error", "gap rms");
  text += fmt::format("  {:44} {:>12} {:>12} {:>7} {:>7} {:>6} {:>6} {:>8} {:>8}\n", "", "", "",
                      "pred", "meas", "pred", "meas", "[weber]", "[mm]");
  double session_seconds = 0.0;
  int failed = 0;
  for (const PointResult& r : run.results) {
    session_seconds += r.session_seconds;
    if (r.failed) {
      ++failed;
      text += fmt::format("  {:44} FAILED: {}\n", r.point.name, r.log);
      continue;
    }
    const auto& p = r.prediction;
    text += fmt::format(
        "  {:44} {:>12} {:>12} {:>7} {:>7} {:>6} {:>6} {:>8} {:>8}\n", r.point.name,
        !p.judged ? "-"
                  : std::string(p.stable ? "stable" : "not stable") + (p.near_boundary ? "~" : ""),
        !r.measures.stability.judged  ? "-"
        : r.measures.stability.stable ? "stable"
                                      : "not stable",
        cell(p.largest_coupling), cell(r.largest_coupling), cell(p.drag), cell(r.measures.drag),
        cell(mean_of(r, &harness::SiteMeasures::force_error_weber)),
        cell(1e3 * r.measures.gap_rms));
  }
  text += "  ~: within 10 % of the boundary in coupling or delay\n";
  for (const auto& b : run.boundaries) {
    text += fmt::format(
        "  {}: stable below a one-way delay of {} ms by analysis, {} ms in virtual time", b.scene,
        cell(1e3 * b.predicted, 4), cell(1e3 * b.in_virtual_time, 4));
    if (run.real)
      text += fmt::format("; on sockets stable up to {} ms, not at {} ms",
                          cell(1e3 * b.real_stable, 4), cell(1e3 * b.real_not_stable, 4));
    text += b.failure.empty() ? "\n" : "; failed: " + b.failure;
  }
  text += statement_text(harness::contests(run.results));
  if (run.real) text += seen_text(run.results);
  const auto found = disagreements_of(run);
  const auto exact = std::count_if(found.begin(), found.end(), [](auto& d) { return d.exact; });
  for (const std::string& name : run.left_out) text += "  left out: " + name + "\n";
  if (run.real) {
    const harness::Comparisons c = harness::comparisons(run.results);
    text += fmt::format(
        "  verdicts compared: {} with the analysis, {} with virtual time; {} too near the "
        "boundary; {} not compared: the machine missed over 1 % of the ticks, twice; drags "
        "compared: {}\n",
        c.with_analysis, c.with_virtual_time, c.near_boundary, c.missed_ticks, c.drags);
  }
  text += fmt::format("  {} points, ", run.results.size());
  if (failed > 0) text += fmt::format("{} FAILED, ", failed);
  text += fmt::format("{} disagreements", exact);
  if (exact != static_cast<std::ptrdiff_t>(found.size()))
    text += fmt::format(
        " (and {} without an exact prediction: a steady network stands for jitter or loss)",
        static_cast<std::ptrdiff_t>(found.size()) - exact);
  if (run.wall_seconds > 0.0)
    text += fmt::format("; {:.0f} s of sessions in {:.1f} s: {:.0f} times real time",
                        session_seconds, run.wall_seconds, session_seconds / run.wall_seconds);
  text += "\n";
  for (const auto& d : found)
    text += fmt::format("    {}{}: {}\n", d.exact ? "" : "(approximate) ", d.point, d.what);
  return text;
}

void write_report(const std::string& file, const ordered_json& json) {
  const std::string data =
      (std::filesystem::temp_directory_path() / fmt::format("tandem-{}.json", getpid())).string();
  write_text(data, json.dump());
  const int status = run_script("netem_report.py", {data, file});
  std::filesystem::remove(data);
  if (status < 0) throw Failed("no report " + file + ": its script was stopped before its end");
  if (status == 2) throw Failed("no report " + file);  // the script has said why
  if (status > 0)
    throw Failed("no report " + file +
                 ": making it needs python3 with matplotlib (apt install python3-matplotlib)");
}

}  // namespace tandem::cli
