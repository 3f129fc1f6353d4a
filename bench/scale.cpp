#include "bench/scale.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <unistd.h>
#include <utility>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "bench/machine.h"
#include "bench/report.h"
#include "bench/scale_json.h"
#include "core/records.h"
#include "scene/load_scene.h"

namespace tandem::bench {
namespace {

using nlohmann::ordered_json;

struct Options {
  int users = 64, objects = 64;
  ScaleWork work;
  std::string central = "box_central", mesh = "box_distributed";
  std::string json, csv;
};

constexpr double kTickBudget_ns = 1e6;
constexpr double kLoopbackSeconds = 0.3;
constexpr double kHeld = 0.99;  // of the packets of a period's rate, else they fall behind

/// Programs like scale_wide.cpp with other capacities, the smaller one first.
struct Wide {
  const char* name;
  int users, objects;
};
constexpr std::array<Wide, 2> kWide{{{"bench_scale_64x4", 64, 4}, {"bench_scale_8x64", 8, 64}}};

std::string beside_us(const std::string& name) {
  std::error_code error;
  const auto self = std::filesystem::read_symlink("/proc/self/exe", error);
  const auto file = self.parent_path() / name;
  return !error && access(file.c_str(), X_OK) == 0 ? file.string() : "";
}

ScaleRow measure_wide(const std::string& program, const std::string& scene, const ScaleSize& size,
                      const ScaleWork& work) {
  const std::string command = fmt::format("'{}' '{}' {} {} {} {} {}", program, scene, size.users,
                                          size.objects, work.rounds, work.seconds, work.priority);
  const std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen(command.c_str(), "r"), pclose);
  if (!pipe) throw std::runtime_error("cannot start " + command);
  std::string text;
  std::array<char, 4096> part{};
  for (std::size_t n; (n = fread(part.data(), 1, part.size(), pipe.get())) > 0;)
    text.append(part.data(), n);
  const ordered_json json = ordered_json::parse(text, nullptr, false);
  if (json.is_discarded()) throw std::runtime_error("it measured nothing: " + command);
  return row_from(json);
}

/// 2, 4, 8, ... and `most` itself; from 1 on for objects, and 20 of them, the most that fit.
std::vector<int> steps(int from, int most) {
  std::vector<int> all;
  for (int n = from; n <= most; n *= 2) all.push_back(n);
  if (all.empty() || all.back() != most) all.push_back(most);
  if (from == 1 && most > 20) all.insert(std::upper_bound(all.begin(), all.end(), 20), 20);
  return all;
}

class Bench {
 public:
  explicit Bench(const Options& options) : options_(options) {}

  void run() {
    // What is wrong is said before anything is measured.
    const std::array<std::pair<std::string, core::Scene>, 2> scenes{
        {{options_.central, scene_of("--central", options_.central, core::Architecture::kCentral)},
         {options_.mesh, scene_of("--mesh", options_.mesh, core::Architecture::kDistributed)}}};
    loopback_ = measure_loopback(kBytes, kLoopbackSeconds);
    std::vector<ScaleSize> sizes;
    for (const int n : steps(2, options_.users)) sizes.push_back({n, 1});
    for (const int n : steps(1, options_.objects))
      if (n > 1) sizes.push_back({2, n});
    for (const auto& [scene, loaded] : scenes) {
      for (const ScaleSize& size : sizes) measure(scene, loaded, size);
      // The same work with room for more.
      for (const Wide& wide : kWide)
        if (const std::string program = beside_us(wide.name); !program.empty())
          roomy_.push_back(measure_wide(program, scene, {2, 1}, without_traffic()));
    }
    // Before and after: what the machine can do drifts.
    const LoopbackRate again = measure_loopback(kBytes, kLoopbackSeconds);
    loopback_.sendmmsg = 0.5 * (loopback_.sendmmsg + again.sendmmsg);
    loopback_.send = 0.5 * (loopback_.send + again.send);
    growths_ = growths_of(rows_, loopback_.sendmmsg);
  }

  [[nodiscard]] std::string text() const;
  [[nodiscard]] ordered_json json() const;
  [[nodiscard]] std::string csv() const;

 private:
  static constexpr std::size_t kBytes = 228;  // of a planar packet with two fingers and a box

  [[nodiscard]] static core::Scene scene_of(const std::string& option, const std::string& name,
                                            core::Architecture architecture) {
    core::Scene scene = scene::load_scene(name);
    (void)grown_scene(scene, {3, 1});
    if (scene.architecture != architecture)
      throw std::invalid_argument(option + " " + name + ": of the other architecture");
    return scene;
  }

  [[nodiscard]] ScaleWork without_traffic() const {
    ScaleWork work = options_.work;
    work.seconds = 0.0;
    return work;
  }

  void measure(const std::string& name, const core::Scene& scene, const ScaleSize& size) {
    if (isatty(STDERR_FILENO) == 1)
      fmt::print(stderr, "\r\033[K{}: {} users, {} objects", name, size.users, size.objects);
    if (size.users <= core::kMaxUsers && size.objects <= core::kMaxObjects) {
      rows_.push_back(measure_scale(scene, size, options_.work));
    } else {
      const auto wide = std::find_if(kWide.begin(), kWide.end(), [&](const Wide& w) {
        return size.users <= w.users && size.objects <= w.objects;
      });
      const std::string program = wide == kWide.end() ? "" : beside_us(wide->name);
      if (program.empty())
        ++beyond_;
      else
        rows_.push_back(measure_wide(program, name, size, options_.work));
    }
    if (isatty(STDERR_FILENO) == 1) fmt::print(stderr, "\r\033[K");
  }

  [[nodiscard]] double tick_at_two(const std::string& architecture) const {
    for (const ScaleRow& row : rows_)
      if (row.architecture == architecture && row.size.users == 2 && row.size.objects == 1)
        return row.tick_ns;
    return 0.0;
  }

  Options options_;
  LoopbackRate loopback_;
  std::vector<ScaleRow> rows_, roomy_;
  std::vector<Growth> growths_;
  int beyond_ = 0;
};

double session_packets(const ScaleRow& row) {
  const double n = row.size.users;
  return row.packet_hz * (row.architecture == "central" ? 2.0 * (n - 1.0) : n * (n - 1.0));
}

bool is_held(const ScaleRow& row) {
  const double wanted = kHeld * row.packet_hz * (row.size.users - 1);
  return row.traffic.in_per_s >= wanted && row.traffic.delivered_per_s >= wanted;
}

std::string meeting(const Growth& g) {
  if (std::isinf(g.knee.n)) return "not in reach";
  return fmt::format("{} {:.0f} {}", g.knee.measured ? "at" : "by the law at", g.knee.n, g.over);
}

std::string line(const ScaleRow& row) {
  const Traffic& t = row.traffic;
  std::string text = fmt::format("  {:<8}{:>6}{:>8}{:>10.0f}{:>10.1f}", row.architecture,
                                 row.size.users, row.size.objects, row.tick_ns, row.virtual_speed);
  if (!row.fits)
    text += fmt::format("  {} values, a datagram holds {}", std::max(row.values_in, row.values_out),
                        core::kMaxPacketValues);
  else if (!t.why_not.empty())
    text += "  " + t.why_not;
  else if (t.in_per_s > 0.0)
    text += fmt::format("{:>9.0f}{:>9.0f}{:>9.0f}{:>9.1f}{:>8.1f}{:>8.1f}{:>8.2f}  {}", t.in_per_s,
                        t.out_per_s, 1e-3 * (t.bytes_in_per_s + t.bytes_out_per_s),
                        session_packets(row) * 1e-3, 100 * t.link_share, 100 * t.force_share,
                        100 * t.missed_share, is_held(row) ? "held" : "NOT HELD");
  return text + (row.finite ? "\n" : "  the session blew up\n");
}

std::string Bench::text() const {
  std::string text = fmt::format(
      "users and objects beyond two and one: {} and {} grown in code ({})\n"
      "  site: the server, or one of the replicas; its packets and threads in real time on "
      "loopback\n"
      "  {:<8}{:>6}{:>8}{:>10}{:>10}{:>9}{:>9}{:>9}{:>9}{:>8}{:>8}{:>8}  {}\n"
      "  {:<8}{:>6}{:>8}{:>10}{:>10}{:>9}{:>9}{:>9}{:>9}{:>8}{:>8}{:>8}\n",
      options_.central, options_.mesh, machine_name(), "", "users", "objects", "tick", "virtual",
      "in", "out", "kB", "session", "link", "force", "missed", "rate", "", "", "", "ns", "x real",
      "1/s", "1/s", "1/s", "1000/s", "cpu %", "cpu %", "%");
  for (const ScaleRow& row : rows_) text += line(row);
  text += "how it grows, fitted to the larger half, and where it meets its budget\n";
  for (const Growth& g : growths_)
    text += fmt::format("  {:<8}{:<24}~ {:<13} (within {:2.0f} %)  {:<32}{}\n", g.architecture,
                        g.what, fmt::format("{}^{:.2f}", g.over, g.law.exponent),
                        100 * g.law.spread, g.of, meeting(g));
  text += fmt::format(
      "beside it, one thread to itself, {} bytes: sendmmsg {:.0f}, send {:.0f} datagrams/s\n"
      "caps: {} users, {} objects in the laws as shipped; {} numbers in a datagram, so {} planar "
      "bodies with two fingers (a replica),\n  {} at a server; a tick of a recording names {}\n",
      kBytes, loopback_.sendmmsg, loopback_.send, core::kMaxUsers, core::kMaxObjects,
      core::kMaxPacketValues, (core::kMaxPacketValues - 8) / 6, (core::kMaxPacketValues - 4) / 6,
      8 * sizeof(core::TickRecord::fresh));
  for (const ScaleRow& row : roomy_)
    text += fmt::format(
        "  two users and one object in laws for {} and {}: {} tick {:.0f} ns, {:.2f} "
        "times that as shipped\n",
        row.most_users, row.most_objects, row.architecture, row.tick_ns,
        row.tick_ns / tick_at_two(row.architecture));
  if (beyond_ > 0)
    text += fmt::format(
        "  {} sizes beyond that were left out; to have them, build bench_scale_64x4 "
        "and bench_scale_8x64\n  (cmake --build build/release --target bench_scale)\n",
        beyond_);
  return text;
}

ordered_json Bench::json() const {
  ordered_json json;
  json["machine"] = machine_name();
  json["sendmmsg_per_s"] = loopback_.sendmmsg;
  json["send_per_s"] = loopback_.send;
  json["bytes"] = kBytes;
  json["capacity_users"] = core::kMaxUsers;
  json["capacity_objects"] = core::kMaxObjects;
  json["capacity_values"] = core::kMaxPacketValues;
  json["left_out"] = beyond_;
  json["growth"] = ordered_json::array();
  for (const Growth& g : growths_) {
    ordered_json one{{"architecture", g.architecture},
                     {"over", g.over},
                     {"what", g.what},
                     {"unit", g.unit},
                     {"exponent", g.law.exponent},
                     {"factor", g.law.factor},
                     {"spread", g.law.spread},
                     {"points", g.law.points},
                     {"budget", g.budget},
                     {"budget_of", g.of},
                     {"knee", nullptr},
                     {"knee_measured", g.knee.measured}};
    if (std::isfinite(g.knee.n)) one["knee"] = g.knee.n;
    json["growth"].push_back(one);
  }
  for (const ScaleRow& row : rows_) {
    json["rows"].push_back(to_json(row));
    json["rows"].back()["session_packets_per_s"] = session_packets(row);
    json["rows"].back()["held"] = is_held(row);
  }
  json["roomy"] = ordered_json::array();
  for (const ScaleRow& row : roomy_)
    json["roomy"].push_back({{"architecture", row.architecture},
                             {"capacity_users", row.most_users},
                             {"capacity_objects", row.most_objects},
                             {"tick_ns", row.tick_ns},
                             {"ratio", row.tick_ns / tick_at_two(row.architecture)}});
  return json;
}

std::string Bench::csv() const {
  std::string text;
  for (const ScaleRow& row : rows_) {
    const ordered_json json = to_json(row);
    if (text.empty()) {
      text = "machine";
      for (const auto& [key, value] : json.items()) text += "," + key;
      text += "\n";
    }
    text += "\"" + machine_name() + "\"";
    for (const auto& [key, value] : json.items()) text += "," + value.dump();
    text += "\n";
  }
  return text;
}

}  // namespace

std::vector<Growth> growths_of(const std::vector<ScaleRow>& rows, double sendmmsg_per_s) {
  struct Quantity {
    const char* what;
    const char* unit;
    const char* of;
    double budget;
    double (*value)(const ScaleRow&);
    bool on_wire;
  };
  const std::array<Quantity, 7> quantities{{
      {"tick of the site", "ns", "1 ms", kTickBudget_ns,
       [](const ScaleRow& r) { return r.tick_ns; }, false},
      {"time of the session", "s/s", "real time on one core", 1.0,
       [](const ScaleRow& r) { return 1.0 / r.virtual_speed; }, false},
      {"packets of the site", "1/s", "sendmmsg, in and out", sendmmsg_per_s,
       [](const ScaleRow& r) { return 0.5 * (r.traffic.in_per_s + r.traffic.out_per_s); }, true},
      {"packets of the session", "1/s", "sendmmsg, all on one machine", sendmmsg_per_s,
       session_packets, false},
      {"bytes of the site", "1/s", "1 Gbit/s", 1.25e8,
       [](const ScaleRow& r) {
         return 0.5 * (r.traffic.bytes_in_per_s + r.traffic.bytes_out_per_s);
       },
       true},
      {"link thread", "s/s", "one processor", 1.0,
       [](const ScaleRow& r) { return r.traffic.link_share; }, true},
      {"force thread", "s/s", "one processor", 1.0,
       [](const ScaleRow& r) { return r.traffic.force_share; }, true},
  }};
  std::vector<Growth> out;
  for (const char* architecture : {"central", "mesh"})
    for (const bool over_users : {true, false})
      for (const Quantity& q : quantities) {
        std::vector<ScalePoint> points;
        for (const ScaleRow& row : rows) {
          if (row.architecture != architecture || (q.on_wire && !(row.traffic.in_per_s > 0.0)) ||
              (over_users ? row.size.objects != 1 : row.size.users != 2))
            continue;
          points.push_back(
              {static_cast<double>(over_users ? row.size.users : row.size.objects), q.value(row)});
        }
        Growth g;
        g.architecture = architecture;
        g.over = over_users ? "users" : "objects";
        g.what = q.what;
        g.unit = q.unit;
        g.budget = q.budget;
        g.of = q.of;
        if (points.size() < 2) continue;
        g.law = fit_power_law(points, points[points.size() / 2].n);
        if (g.law.points < 2) g.law = fit_power_law(points);
        g.knee = find_knee(points, g.law, q.budget);
        out.push_back(g);
      }
  return out;
}

void add_bench_scale(CLI::App& bench) {
  CLI::App* app = bench.add_subcommand(
      "scale", "tick, packets, processor and virtual time of 2..64 users and 1..64 objects");
  auto o = std::make_shared<Options>();
  app->add_option("--users", o->users, "up to so many")
      ->check(CLI::Range(2, 64))
      ->capture_default_str();
  app->add_option("--objects", o->objects, "up to so many")
      ->check(CLI::Range(1, 64))
      ->capture_default_str();
  app->add_option("--seconds", o->work.seconds,
                  "in real time on loopback, for each size [s]; 0: laws only")
      ->check(CLI::Range(0.0, 60.0))
      ->capture_default_str();
  app->add_option("--rounds", o->work.rounds, "timed stretches of each size; the median counts")
      ->check(CLI::Range(1, 10000))
      ->capture_default_str();
  app->add_option("--priority", o->work.priority, "SCHED_FIFO of the force thread; 0: ordinary")
      ->check(CLI::Range(0, 99))
      ->capture_default_str();
  app->add_option("--central", o->central, "planar scene of two users that is grown")
      ->capture_default_str();
  app->add_option("--mesh", o->mesh, "the same, distributed")->capture_default_str();
  app->add_option("--csv", o->csv, "write the rows to this file");
  app->add_option("--json", o->json, "write the result as JSON to this file; - is the output");
  app->callback([o] {
    Bench scale(*o);
    scale.run();
    write_csv(o->csv, scale.csv());
    report(o->json, scale.text(), scale.json());
  });
}

}  // namespace tandem::bench
