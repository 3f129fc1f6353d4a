#include "bench/error.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <unistd.h>
#include <vector>

#include "bench/error_peers.h"
#include "bench/error_reference.h"
#include "bench/error_table.h"
#include "bench/error_tandem.h"
#include "bench/machine.h"
#include "bench/report.h"

namespace tandem::bench {
namespace {

using Json = nlohmann::ordered_json;

struct Options {
  int rounds = 5;
  std::vector<std::string> cases;
  bool peers = true;
  std::string python = "python3", json, csv, picture;
};

/// Times of the rounds and the error, which every round repeats.
struct Gathered {
  ErrorRow row;
  std::vector<double> ns;
};

class Session {
 public:
  explicit Session(const Options& options) : options_(options) {
    if (options.peers) peers_ = find_peers(options.python);
    for (std::size_t i = 0; i < kErrorPoints.size(); ++i)
      if (options.cases.empty() || std::find(options.cases.begin(), options.cases.end(),
                                             kErrorPoints[i].name) != options.cases.end())
        points_.push_back(static_cast<int>(i));
    for (const int p : points_) {
      truth_[p] = error_reference(kErrorPoints[static_cast<std::size_t>(p)]);
      const std::vector<double> nowhere(truth_[p].ideal.size(), 0.0);
      const ErrorPoint& point = kErrorPoints[static_cast<std::size_t>(p)];
      scale_[p] = point.which == Case::kSpin ? 1.0 : error_of(point, truth_[p].ideal, nowhere);
    }
  }

  void measure_all() {
    for (int round = 0; round < options_.rounds; ++round)
      for (const int p : points_) {
        progress(round, p);
        const ErrorPoint& point = kErrorPoints[static_cast<std::size_t>(p)];
        for (const Scheme& scheme : schemes_of(point))
          for (const int hz : kErrorRates) {
            ErrorRow row{p, "tandem", scheme.name, scheme.is_default, scheme.in_tandem, hz};
            add(row, run_tandem(point, scheme, hz));
          }
        for (const Peer& peer : peers_) {
          if (!peer.missing.empty()) continue;
          for (const PeerRun& r : run_peer(peer, p))
            add({p, peer.name, r.setting, false, true, r.hz}, r.run);
        }
      }
    if (isatty(STDERR_FILENO) != 0) std::fputc('\n', stderr);
    for (auto& [key, g] : gathered_) {
      g.row.ns_per_s = median(g.ns);
      rows_.push_back(g.row);
    }
    std::stable_sort(rows_.begin(), rows_.end(), [](const ErrorRow& a, const ErrorRow& b) {
      return std::tie(a.point, a.hz) < std::tie(b.point, b.hz);
    });
  }

  [[nodiscard]] const std::vector<ErrorRow>& rows() const { return rows_; }
  [[nodiscard]] const std::vector<int>& points() const { return points_; }
  [[nodiscard]] const std::vector<Peer>& peers() const { return peers_; }
  [[nodiscard]] double scale(int point) const { return scale_.at(point); }

 private:
  void add(ErrorRow row, const ErrorRun& run) {
    Gathered& g =
        gathered_[fmt::format("{:03}|{}|{}|{}", row.point, row.engine, row.setting, row.hz)];
    if (g.ns.empty()) {
      const ErrorPoint& point = kErrorPoints[static_cast<std::size_t>(row.point)];
      const ErrorReference& truth = truth_.at(row.point);
      row.error = error_of(point, run.samples, truth.ideal);
      row.law_error = row.engine == "tandem"
                          ? error_of(point, run.samples, law_course(point, truth, row.hz))
                          : row.error;
      row.drift = energy_drift(point, run.samples, truth.ideal);
      g.row = row;
    }
    g.ns.push_back(run.ns_per_s);
  }
  void progress(int round, int point) const {
    if (isatty(STDERR_FILENO) == 0) return;
    const ErrorPoint& p = kErrorPoints[static_cast<std::size_t>(point)];
    std::fprintf(stderr, "\rround %d of %d: %-12s %8.0f N/m ", round + 1, options_.rounds,
                 std::string(p.name).c_str(), p.stiffness);
  }

  Options options_;
  std::vector<Peer> peers_;
  std::vector<int> points_;
  std::map<int, ErrorReference> truth_;
  std::map<int, double> scale_;
  std::map<std::string, Gathered> gathered_;
  std::vector<ErrorRow> rows_;
};

Json finite(double x) { return std::isfinite(x) ? Json(x) : Json(nullptr); }

const ErrorPoint& point_of(int index) { return kErrorPoints[static_cast<std::size_t>(index)]; }

Json to_json(const Comparison& c, bool reached) {
  Json out{{"case", point_of(c.point).name},
           {"stiffness", point_of(c.point).stiffness},
           {"peer", c.peer},
           {"peer_setting", c.setting},
           {"peer_hz", c.hz},
           {"error", c.error},
           {"peer_ns_per_s", c.peer_ns}};
  if (reached) {
    out["tandem_setting"] = c.tandem_setting;
    out["tandem_hz"] = c.tandem_hz;
    out["tandem_ns_per_s"] = c.tandem_ns;
    out["speedup"] = c.speedup();
  }
  return out;
}

/// What one choice of schemes gives over all cases.
struct Verdict {
  Json cases = Json::array(), where_not = Json::array();
  const Comparison* least = nullptr;
  std::vector<CaseResult> results;
};

Verdict judge(const Session& session, bool only_default) {
  Verdict out;
  for (const int p : session.points())
    out.results.push_back(compare_case(session.rows(), p, session.scale(p), only_default));
  for (const CaseResult& r : out.results) {
    Json one{{"case", point_of(r.point).name},
             {"stiffness", point_of(r.point).stiffness},
             {"scale", r.scale},
             {"least_error", r.least_error},
             {"points_of_the_peers_front", r.reached.size() + r.unreached.size()},
             {"reached", r.reached.size()}};
    if (r.least) {
      one["least_speedup_at_equal_error"] = r.least->speedup();
      one["against"] = to_json(*r.least, true);
      if (out.least == nullptr || r.least->speedup() < out.least->speedup()) out.least = &*r.least;
    }
    out.cases.push_back(one);
    for (const Comparison& c : r.reached)
      if (c.speedup() < 5.0) out.where_not.push_back(to_json(c, true));
    for (const Comparison& c : r.unreached) out.where_not.push_back(to_json(c, false));
  }
  return out;
}

std::string case_name(int point) {
  const ErrorPoint& p = point_of(point);
  return p.stiffness > 0.0 ? fmt::format("{} {:.0f}", p.name, p.stiffness) : std::string(p.name);
}

std::string verdict_text(const Verdict& v, const char* title) {
  std::string text =
      fmt::format("{}\n  {:<17} {:>9} {:>10} {:>7}  {:>8}  {}\n", title, "case", "way", "least err",
                  "points", "speedup", "against, at which error");
  for (const CaseResult& r : v.results) {
    text += fmt::format("  {:<17} {:9.2e} {:10.1e} {:3}/{:<3}", case_name(r.point), r.scale,
                        r.least_error, r.reached.size(), r.reached.size() + r.unreached.size());
    if (r.least)
      text += fmt::format("  {:8.1f}  {} ({}) at {} Hz, {:.1e}; Tandem {} at {} Hz\n",
                          r.least->speedup(), r.least->peer, r.least->setting, r.least->hz,
                          r.least->error, r.least->tandem_setting, r.least->tandem_hz);
    else
      text += r.unreached.empty() ? "         -  no peer comes near\n"
                                  : "         -  every peer is nearer than Tandem gets\n";
    if (!r.unreached.empty()) {
      const auto nearest =
          std::min_element(r.unreached.begin(), r.unreached.end(),
                           [](const auto& a, const auto& b) { return a.error < b.error; });
      text += fmt::format("  {:<17} not reached: down to {:.1e} by {} ({}) at {} Hz\n", "",
                          nearest->error, nearest->peer, nearest->setting, nearest->hz);
    }
  }
  return text;
}

/// Errors, cost and order of every scheme of Tandem at 1024 Hz.
std::string schemes_text(const Session& session) {
  std::string text =
      fmt::format("every scheme at 1024 Hz\n  {:<17} {:<28} {:>9} {:>9} {:>9} {:>8} {:>6}\n",
                  "case", "scheme", "error", "of law", "energy", "ns/tick", "order");
  for (const int p : session.points())
    for (const ErrorRow& row : session.rows()) {
      if (row.point != p || row.hz != 1024 || row.engine != "tandem") continue;
      const auto order = observed_order(session.rows(), p, row.setting, session.scale(p), 1e-13);
      text += fmt::format("  {:<17} {:<28} {:9.1e} {:9.1e} {:9.1e} {:8.1f} {:>6}\n", case_name(p),
                          row.setting + (row.is_default ? " *" : ""), row.error, row.law_error,
                          row.drift, row.ns_per_s / row.hz,
                          order ? fmt::format("{:.2f}", *order) : "-");
    }
  return text + "  (* default; order: through all rates from 1024 Hz on)\n";
}

void write_csv(const std::string& file, const Session& session) {
  std::ofstream out(file);
  out << "case,stiffness_n_per_m,engine,setting,default,in_tandem,rate_hz,ns_per_simulated_s,"
         "ns_per_step,error,error_of_law,energy_drift,machine\n";
  for (const ErrorRow& r : session.rows())
    out << fmt::format("{},{},{},\"{}\",{},{},{},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},\"{}\"\n",
                       point_of(r.point).name, point_of(r.point).stiffness, r.engine, r.setting,
                       r.is_default ? 1 : 0, r.in_tandem ? 1 : 0, r.hz, r.ns_per_s,
                       r.ns_per_s / r.hz, r.error, r.law_error, r.drift, machine_name());
  if (!out.flush()) throw std::runtime_error("cannot write " + file);
}

void draw(const std::string& picture, const Session& session) {
  const std::string data = fmt::format("/tmp/tandem-error-{}.csv", getpid());
  write_csv(data, session);
  const std::string command = fmt::format("/usr/bin/python3 {}/bench/error_picture.py '{}' '{}'",
                                          TANDEM_SOURCE_DIR, data, picture);
  const int status = std::system(command.c_str());
  std::remove(data.c_str());
  if (status != 0)
    throw std::runtime_error("no picture " + picture +
                             ": drawing needs python3 with matplotlib (apt install "
                             "python3-matplotlib) and a folder it may write to");
}

void run(const Options& options) {
  if (options.picture.find('\'') != std::string::npos)
    throw std::runtime_error("--picture " + options.picture + ": no quotes in the name, please");
  Session session(options);
  session.measure_all();
  const Verdict by_default = judge(session, true), best = judge(session, false);

  std::string text =
      fmt::format("work against error, {} rounds, {}\n", options.rounds, machine_name());
  for (const Peer& peer : session.peers())
    if (!peer.missing.empty()) text += fmt::format("  {}: {}\n", peer.name, peer.missing);
  text += verdict_text(by_default, "the default scheme beside the best peer at equal error");
  text += verdict_text(best, "the best scheme of Tandem beside the best peer at equal error");
  text += schemes_text(session);

  Json json;
  json["machine"] = machine_name();
  json["rounds"] = options.rounds;
  const auto summary = [](const Verdict& v, const std::string& prefix, Json& out) {
    out[prefix + "least_speedup_at_equal_error"] =
        v.least != nullptr ? Json(v.least->speedup()) : Json(nullptr);
    out[prefix + "case"] = v.least != nullptr ? Json(case_name(v.least->point)) : Json(nullptr);
    out[prefix + "where_not"] = v.where_not;
    out[prefix + "cases"] = v.cases;
  };
  summary(by_default, "", json);
  summary(best, "best_scheme_", json);
  for (const Peer& peer : session.peers())
    json["peers"][peer.name] = peer.missing.empty() ? "measured" : peer.missing;
  for (const ErrorRow& r : session.rows()) {
    json["runs"].push_back({{"case", point_of(r.point).name},
                            {"stiffness", point_of(r.point).stiffness},
                            {"engine", r.engine},
                            {"setting", r.setting},
                            {"default", r.is_default},
                            {"in_tandem", r.in_tandem},
                            {"hz", r.hz},
                            {"ns_per_simulated_s", r.ns_per_s},
                            {"error", finite(r.error)},
                            {"error_of_law", finite(r.law_error)},
                            {"energy_drift", finite(r.drift)}});
  }
  if (!options.csv.empty()) write_csv(options.csv, session);
  report(options.json, text, json);
  if (!options.picture.empty()) draw(options.picture, session);
}

}  // namespace

void add_bench_error(CLI::App& bench) {
  CLI::App* app =
      bench.add_subcommand("error", "time against error of every scheme, beside other engines");
  auto o = std::make_shared<Options>();
  app->add_option("--rounds", o->rounds, "rounds of all, interleaved; medians of their times count")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  app->add_option("--case", o->cases, "only these cases")
      ->check(CLI::IsMember({"masses", "hands", "wall", "stick_slip", "slide", "spin"}));
  app->add_flag("!--no-peers", o->peers, "Tandem alone");
  app->add_option("--python", o->python, "Python with the mujoco wheel")->capture_default_str();
  app->add_option("--json", o->json, "write the result as JSON to this file; - is the output");
  app->add_option("--csv", o->csv, "write every run to this file");
  app->add_option("--picture", o->picture, "draw the diagrams to this file (.png or .svg)");
  app->callback([o] { run(*o); });
}

}  // namespace tandem::bench
