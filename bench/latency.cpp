#include "bench/latency.h"

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <sstream>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "bench/latency_path.h"
#include "bench/machine.h"
#include "bench/percentile.h"
#include "bench/report.h"
#include "core/realtime.h"
#include "scene/load_scene.h"

namespace tandem::bench {
namespace {

using nlohmann::ordered_json;
using std::string;

struct Options {
  double seconds = 5.0;
  int rounds = 2, priority = 80, motions = 20000;
  std::vector<double> rates{128.0, 1024.0};
  string scene = "box_distributed", json, csv;
};

/// Runs a line of shell, gives what it printed on standard output.
string said_by(const string& command) {
  const std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen(command.c_str(), "r"), pclose);
  string text;
  std::array<char, 4096> part{};
  for (std::size_t n; pipe && (n = fread(part.data(), 1, part.size(), pipe.get())) > 0;)
    text.append(part.data(), n);
  return text;
}

/// One way of carrying a state: from being handed over to being there for its reader.
struct Carrier {
  string name, how;
  std::vector<double> us{};    ///< of each message
  SockperfSummary sockperf{};  ///< instead: of the last round
  Percentiles result{};
  string why_not{};
};

struct PeerProgram {
  const char* name;
  const char* how;
  const char* package;
};
constexpr std::array<PeerProgram, 3> kPeers{{
    {"asio", "plain Boost.Asio, blocking receive", "libboost1.81-dev"},
    {"enet", "ENet 1.3, unreliable, enet_host_service that blocks", "libenet-dev"},
    {"dds", "Cyclone DDS, best effort, wait set", "cyclonedds-dev cyclonedds-tools"},
}};

string beside_us(const string& name) {
  std::error_code error;
  const auto self = std::filesystem::read_symlink("/proc/self/exe", error);
  const auto file = self.parent_path() / name;
  return !error && access(file.c_str(), X_OK) == 0 ? file.string() : "";
}

/// `chrt` before a command, where it may.
string at_priority(int priority) {
  if (priority <= 0) return "";
  const string words = fmt::format("chrt -f {} ", priority);
  return said_by(words + "echo yes 2>/dev/null").empty() ? "" : words;
}

/// All at one packet rate.
struct AtRate {
  double hz = 0.0;
  Stages stages;
  std::int64_t packets = 0, used = 0;
  std::size_t bytes = 0;
  std::vector<double> processor, processor_sleeping;  ///< of a core, of one replica
  /// Tandem's stack, the peers in their order, Tandem's that sleeps from look to look, sockperf.
  std::vector<Carrier> carriers;
};

class Bench {
 public:
  explicit Bench(const Options& options) : options_(options) {
    // Each peer gets what the link thread gets.
    chrt_ = at_priority(options.priority - 1);
    for (const double hz : options.rates) {
      AtRate r;
      r.hz = hz;
      r.carriers.push_back({"tandem", "handed to the link thread .. in the peer's inbox"});
      for (const PeerProgram& peer : kPeers) r.carriers.push_back({peer.name, peer.how});
      r.carriers.push_back({"sleeping", "tandem without watching: the link thread sleeps, looks"});
      r.carriers.push_back({"sockperf", "ping-pong, half of the round trip"});
      rates_.push_back(std::move(r));
    }
  }

  void run() {
    // Processors stay out of deep sleep for all alike.
    const core::RealtimeGrant awake =
        core::request_realtime({.priority = 0,
                                .lock_memory = false,
                                .cpu = {},
                                .timer_slack_ns = 0,
                                .hold_cpu_dma_latency = options_.priority > 0});
    for (int round = 0; round < options_.rounds; ++round)
      for (AtRate& r : rates_) {
        tandem(r, round);
        sleeping(r, round);
        for (std::size_t i = 0; i < kPeers.size(); ++i) peer(r, kPeers[i], r.carriers[i + 1]);
        sockperf(r, r.carriers.back());
      }
    for (AtRate& r : rates_) finish(r);
  }

  [[nodiscard]] string text() const;
  [[nodiscard]] ordered_json json() const;
  [[nodiscard]] string csv() const;

 private:
  void say(const AtRate& r, const string& what) const {
    if (isatty(STDERR_FILENO) == 1) fmt::print(stderr, "\r\033[K{:.0f} Hz: {}\r", r.hz, what);
  }

  void tandem(AtRate& r, int round) {
    say(r, "two replicas");
    const string set = fmt::format("rates.packet_hz={}", r.hz);
    const core::Scene scene = scene::load_scene(options_.scene, {{set}});
    const double phase = (round + 0.5) / options_.rounds;
    const PathResult path = run_path(scene, {options_.seconds, phase, options_.priority});
    r.processor.push_back(path.processor);
    r.bytes = path.bytes;
    for (std::size_t d = 0; d < 2; ++d) {
      add_run(path.runs[d], options_.motions, 2 * static_cast<std::uint64_t>(round) + d + 1,
              r.stages);
      r.packets += path.runs[d].published;
      r.used += static_cast<std::int64_t>(path.runs[d].packets.size());
    }
  }

  /// What watching for the force loop's packet buys, and what it costs.
  void sleeping(AtRate& r, int round) {
    say(r, "two replicas, link threads that sleep");
    const string set = fmt::format("rates.packet_hz={}", r.hz);
    const double phase = (round + 0.5) / options_.rounds;
    const PathResult path = run_path(scene::load_scene(options_.scene, {{set}}),
                                     {options_.seconds, phase, options_.priority, false});
    r.processor_sleeping.push_back(path.processor);
    Stages stages;
    for (const PathRun& direction : path.runs) add_run(direction, 1, 1, stages);
    std::vector<double>& us = r.carriers[kPeers.size() + 1].us;
    us.insert(us.end(), stages.handed_over.begin(), stages.handed_over.end());
  }

  void peer(AtRate& r, const PeerProgram& program, Carrier& carrier) {
    say(r, carrier.name);
    const string file = beside_us(string("bench_latency_") + program.name);
    if (file.empty()) {
      carrier.why_not = fmt::format(
          "not built: apt install {}, configure, build the target bench_peers", program.package);
      return;
    }
    const string said =
        said_by(fmt::format("{}'{}' {} {} {}", chrt_, file, r.hz, options_.seconds, r.bytes));
    const ordered_json json = ordered_json::parse(said, nullptr, false);
    if (json.is_discarded() || json.value("one_way_ns", ordered_json::array()).empty()) {
      carrier.why_not = "it measured nothing: " + file;
      return;
    }
    for (const ordered_json& ns : json["one_way_ns"]) carrier.us.push_back(1e-3 * ns.get<double>());
  }

  void sockperf(AtRate& r, Carrier& carrier) {
    say(r, "sockperf");
    if (said_by("command -v sockperf").empty()) {
      carrier.why_not = "not there: apt install sockperf";
      return;
    }
    // A second server cannot have the port of a first: a number of our own.
    const int port = 20000 + getpid() % 20000;
    carrier.sockperf = read_sockperf(said_by(fmt::format(
        "{0}sockperf server -i 127.0.0.1 -p {1} >/dev/null 2>&1 & s=$!; sleep 0.3; "
        "{0}sockperf ping-pong -i 127.0.0.1 -p {1} -m {2} --mps {3:.0f} -t {4:.0f} 2>&1; kill $s; "
        "wait $s 2>/dev/null",
        chrt_, port, r.bytes, r.hz, std::max(1.0, options_.seconds))));
    if (carrier.sockperf.percentiles.empty()) carrier.why_not = "sockperf said nothing";
  }

  static void finish(AtRate& r) {
    r.carriers[0].us = r.stages.handed_over;
    for (Carrier& c : r.carriers) {
      if (!c.us.empty()) {
        c.result = percentiles_of(c.us);
      } else if (!c.sockperf.percentiles.empty()) {
        c.result = {c.sockperf.mean_us,   c.sockperf.at(0.5), c.sockperf.at(0.99),
                    c.sockperf.at(0.999), c.sockperf.at(1.0), 0};
        c.result.count = static_cast<std::size_t>(c.sockperf.count);
      }
    }
  }

  /// Parts of the mean way by whom they belong to [us]; the kernel's is what plain Asio takes.
  struct Shares {
    double rates = 0.0, tandem = 0.0, kernel = 0.0, total = 0.0;
  };
  [[nodiscard]] static Shares shares_of(const AtRate& r) {
    const auto mean = [&](Stage s) { return r.stages.mean_us[static_cast<std::size_t>(s)]; };
    Shares s;
    s.rates = mean(Stage::kSample) + mean(Stage::kSlot) + mean(Stage::kApply);
    s.total = r.stages.mean_total_us;
    const double wire = mean(Stage::kWire), asio = r.carriers[1].result.p50;
    s.kernel = asio > 0.0 ? std::min(asio, wire) : wire;
    s.tandem = s.total - s.rates - s.kernel;
    return s;
  }

  Options options_;
  string chrt_;
  std::vector<AtRate> rates_;
};

string row(const string& name, const Percentiles& p, const string& tail) {
  return fmt::format("  {:<10}{:>9.1f}{:>9.1f}{:>9.1f}{:>9.1f}{:>9.1f}{:>9}  {}\n", name, p.mean,
                     p.p50, p.p99, p.p999, p.max, p.count, tail);
}

string Bench::text() const {
  string text;
  for (const AtRate& r : rates_) {
    text += fmt::format(
        "{:.0f} packets a second, {} bytes, loopback UDP ({})\n"
        "from a motion to the force at the other user [us]: {} of {} packets were used\n"
        "  {:<10}{:>9}{:>9}{:>9}{:>9}{:>9}{:>9}\n",
        r.hz, r.bytes, machine_name(), r.used, r.packets, "", "mean", "p50", "p99", "p99.9", "max",
        "of");
    for (std::size_t s = 0; s < kStages; ++s) {
      Percentiles p = percentiles_of(r.stages.us[s]);
      p.mean = r.stages.mean_us[s];
      text += row(kStageNames[s].key, p,
                  fmt::format("{:4.1f} %  {:<30} {}", 100 * p.mean / r.stages.mean_total_us,
                              kStageNames[s].from_to, kStageNames[s].whose));
    }
    const Shares s = shares_of(r);
    text += row("all", percentiles_of(r.stages.total), "");
    text += fmt::format(
        "  of the mean: {:.1f} % waits for ticks and packets, {:.1f} % Tandem's threads, law and "
        "codec, {:.1f} % kernel{}\n"
        "carrying the state [us]\n",
        100 * s.rates / s.total, 100 * s.tandem / s.total, 100 * s.kernel / s.total,
        r.carriers[1].us.empty() ? " and codec" : " (as plain Asio, p50)");
    for (const Carrier& c : r.carriers)
      text += c.why_not.empty() ? row(c.name, c.result, c.how)
                                : fmt::format("  {:<10}{}\n", c.name, c.why_not);
    text += fmt::format(
        "  a replica's share of a core, force loop with its spin and link: {:.1f} %, sleeping "
        "{:.1f} "
        "%\n",
        100 * median(r.processor), 100 * median(r.processor_sleeping));
  }
  return text + fmt::format(
                    "Priority: {}. A percentile beyond the number of its samples is their "
                    "maximum; {}\n",
                    options_.priority > 0
                        ? chrt_.empty() ? "asked for, not granted" : "SCHED_FIFO for all"
                        : "ordinary for all",
                    "sockperf's sender spins between messages, nobody else's does.");
}

ordered_json to_json(const Percentiles& p) {
  return {{"mean_us", p.mean}, {"p50_us", p.p50}, {"p99_us", p.p99},
          {"p999_us", p.p999}, {"max_us", p.max}, {"count", p.count}};
}

ordered_json Bench::json() const {
  ordered_json json{{"machine", machine_name()},
                    {"scene", options_.scene},
                    {"priority", options_.priority},
                    {"seconds", options_.seconds},
                    {"rounds", options_.rounds}};
  for (const AtRate& r : rates_) {
    ordered_json one{
        {"packet_hz", r.hz}, {"bytes", r.bytes}, {"packets", r.packets}, {"packets_used", r.used}};
    for (std::size_t s = 0; s < kStages; ++s) {
      Percentiles p = percentiles_of(r.stages.us[s]);
      p.mean = r.stages.mean_us[s];
      ordered_json stage{{"stage", kStageNames[s].key}, {"whose", kStageNames[s].whose}};
      stage.update(to_json(p));
      stage["share"] = p.mean / r.stages.mean_total_us;
      one["stages"].push_back(stage);
    }
    one["total"] = to_json(percentiles_of(r.stages.total));
    const Shares s = shares_of(r);
    one["share_rates"] = s.rates / s.total;
    one["share_tandem"] = s.tandem / s.total;
    one["share_kernel"] = s.kernel / s.total;
    one["processor"] = median(r.processor);
    one["processor_sleeping"] = median(r.processor_sleeping);
    for (const Carrier& c : r.carriers) {
      ordered_json carrier{{"name", c.name}, {"how", c.how}};
      if (c.why_not.empty())
        carrier.update(to_json(c.result));
      else
        carrier["why_not"] = c.why_not;
      one["carriers"].push_back(carrier);
    }
    json["rates"].push_back(one);
  }
  return json;
}

string Bench::csv() const {
  string text = "machine,packet_hz,kind,name,mean_us,p50_us,p99_us,p999_us,max_us,count\n";
  const auto add = [&](const AtRate& r, const char* kind, const string& name,
                       const Percentiles& p) {
    text += fmt::format("\"{}\",{},{},{},{:.3f},{:.3f},{:.3f},{:.3f},{:.3f},{}\n", machine_name(),
                        r.hz, kind, name, p.mean, p.p50, p.p99, p.p999, p.max, p.count);
  };
  for (const AtRate& r : rates_) {
    for (std::size_t s = 0; s < kStages; ++s)
      add(r, "stage", kStageNames[s].key, percentiles_of(r.stages.us[s]));
    add(r, "stage", "all", percentiles_of(r.stages.total));
    for (const Carrier& c : r.carriers)
      if (c.why_not.empty()) add(r, "carrier", c.name, c.result);
  }
  return text;
}

}  // namespace

double SockperfSummary::at(double fraction) const {
  for (const SockperfLine& line : percentiles)
    if (std::abs(line.fraction - fraction) < 1e-9) return line.us;
  return std::numeric_limits<double>::quiet_NaN();
}

SockperfSummary read_sockperf(const string& said) {
  SockperfSummary summary;
  std::istringstream lines(said);
  for (string line; std::getline(lines, line);) {
    const auto after = [&](const char* word) -> const char* {
      const auto at = line.find(word);
      return at == string::npos ? nullptr
                                : line.c_str() + at + std::char_traits<char>::length(word);
    };
    double a = 0.0, b = 0.0;
    int n = 0;
    if (const char* rest = after("Latency is "); rest && std::sscanf(rest, "%lf", &a) == 1)
      summary.mean_us = a;
    else if (rest = after("Total "); rest && std::sscanf(rest, "%d observations", &n) == 1)
      summary.count = n;
    else if (rest = after("percentile "); rest && std::sscanf(rest, "%lf = %lf", &a, &b) == 2)
      summary.percentiles.push_back({a / 100.0, b});
    else if (rest = after("<MAX> observation = "); rest && std::sscanf(rest, "%lf", &a) == 1)
      summary.percentiles.push_back({1.0, a});
  }
  return summary;
}

void add_bench_latency(CLI::App& bench) {
  CLI::App* app = bench.add_subcommand(
      "latency", "from a motion to the other user's force, part by part, beside other carriers");
  auto o = std::make_shared<Options>();
  app->add_option("--seconds", o->seconds, "of each run [s]")
      ->check(CLI::Range(0.5, 600.0))
      ->capture_default_str();
  app->add_option("--rounds", o->rounds, "of all in turns, each with another phase of the ticks")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  app->add_option("--rates", o->rates, "packets a second [Hz]")
      ->delimiter(',')
      ->check(CLI::Range(1.0, 1024.0))
      ->capture_default_str();
  app->add_option("--motions", o->motions, "random instants of each run and direction")
      ->check(CLI::Range(1, 10'000'000))
      ->capture_default_str();
  app->add_option("--priority", o->priority,
                  "SCHED_FIFO of the force threads, one less for link threads and peers; 0: "
                  "ordinary, and deep sleep allowed")
      ->check(CLI::Range(0, 99))
      ->capture_default_str();
  app->add_option("--scene", o->scene, "planar, DISTRIBUTED, of two users")->capture_default_str();
  app->add_option("--csv", o->csv, "write the rows to this file");
  app->add_option("--json", o->json, "write the result as JSON to this file; - is the output");
  app->callback([o] {
    Bench latency(*o);
    latency.run();
    write_csv(o->csv, latency.csv());
    report(o->json, latency.text(), latency.json());
  });
}

}  // namespace tandem::bench
