#include "bench/view.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <stdexcept>
#include <string>
#include <unistd.h>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace tandem::bench {
namespace {

using nlohmann::ordered_json;

struct ViewBench {
  int pairs = 5, priority = 80;
  double seconds = 8.0;
  std::string scene = "plane_single", size = "1280x720", json;
};

struct Run {
  double p99 = 0.0;  ///< [us]
  std::int64_t missed = 0, ticks = 0;
  double pictures_a_second = 0.0, picture_ms = 0.0;
  std::string renderer;
};

/// One node as a process of its own.
Run run_node(const ViewBench& b, bool window) {
  std::array<char, 4096> self{};
  if (readlink("/proc/self/exe", self.data(), self.size() - 1) <= 0)
    throw std::runtime_error("bench view: this program does not know where it is");
  const std::string command = fmt::format(
      "'{}' server --scene '{}' --bind 127.0.0.1:0 --seconds {} --priority {} --quiet --json - {} "
      "2>/dev/null",
      self.data(), b.scene, b.seconds, b.priority,
      window ? "--view --view-hidden --view-size " + b.size : "");
  std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen(command.c_str(), "r"), pclose);
  if (!pipe) throw std::runtime_error("bench view: cannot start a node");
  std::string text;
  std::array<char, 4096> part{};
  for (std::size_t n; (n = fread(part.data(), 1, part.size(), pipe.get())) > 0;)
    text.append(part.data(), n);
  const ordered_json j = ordered_json::parse(text, nullptr, false);
  if (j.is_discarded())
    throw std::runtime_error("bench view: the node said nothing; try by hand: " + command);
  Run r;
  r.p99 = j["wakeup_us"]["p99"].get<double>();
  r.missed = j["missed_ticks"].get<std::int64_t>();
  r.ticks = j["ticks"].get<std::int64_t>();
  if (!window) return r;
  if (!j.contains("window") || !j["window"].contains("pictures_a_second"))
    throw std::runtime_error("bench view: no window: " + (j.contains("window")
                                                              ? j["window"].dump()
                                                              : std::string("not built in")));
  r.pictures_a_second = j["window"]["pictures_a_second"].get<double>();
  r.picture_ms = j["window"]["picture_ms"]["mean"].get<double>();
  r.renderer = j["window"]["renderer"].get<std::string>();
  return r;
}

double middle_of(std::vector<double> v) {
  std::sort(v.begin(), v.end());
  const std::size_t n = v.size();
  return n % 2 == 1 ? v[n / 2] : 0.5 * (v[n / 2 - 1] + v[n / 2]);
}

void bench_view(const ViewBench& b) {
  std::vector<double> rise, without, with, rate, ms;
  std::int64_t missed[2] = {0, 0}, ticks = 0;
  ordered_json pairs = ordered_json::array();
  std::string renderer;
  const bool to_stdout = b.json == "-";
  if (!to_stdout)
    fmt::print("{:>5}{:>16}{:>16}{:>10}{:>10}{:>10}{:>14}{:>12}\n", "pair", "p99 without us",
               "p99 with us", "rise us", "missed", "with", "pictures/s", "drawing ms");
  for (int i = 0; i < b.pairs; ++i) {
    // In turns, and which goes first too, so that what drifts falls out.
    Run r[2];
    for (const bool window : {i % 2 == 1, i % 2 == 0}) r[window ? 1 : 0] = run_node(b, window);
    without.push_back(r[0].p99);
    with.push_back(r[1].p99);
    rise.push_back(r[1].p99 - r[0].p99);
    rate.push_back(r[1].pictures_a_second);
    ms.push_back(r[1].picture_ms);
    missed[0] += r[0].missed;
    missed[1] += r[1].missed;
    ticks += r[0].ticks;
    renderer = r[1].renderer;
    pairs.push_back({{"p99_without_us", r[0].p99},
                     {"p99_with_us", r[1].p99},
                     {"missed_without", r[0].missed},
                     {"missed_with", r[1].missed},
                     {"pictures_a_second", r[1].pictures_a_second}});
    if (!to_stdout) {
      fmt::print("{:>5}{:>16.1f}{:>16.1f}{:>10.1f}{:>10}{:>10}{:>14.1f}{:>12.1f}\n", i + 1,
                 r[0].p99, r[1].p99, rise.back(), r[0].missed, r[1].missed, rate.back(), ms.back());
      std::fflush(stdout);
    }
  }
  if (!to_stdout)
    fmt::print(
        "median: p99 lateness {:.1f} us without, {:.1f} us with a window of {}; it rises by {:.1f} "
        "us "
        "(20 are\n  allowed); missed {} without and {} with, of {} ticks each; {:.1f} pictures a "
        "second (32 are wanted)\n  drawn by {}\n",
        middle_of(without), middle_of(with), b.size, middle_of(rise), missed[0], missed[1], ticks,
        middle_of(rate), renderer);
  if (b.json.empty()) return;
  const ordered_json j = {{"scene", b.scene},
                          {"size", b.size},
                          {"seconds", b.seconds},
                          {"priority", b.priority},
                          {"renderer", renderer},
                          {"pairs", pairs},
                          {"p99_rise_us_median", middle_of(rise)},
                          {"missed_without", missed[0]},
                          {"missed_with", missed[1]},
                          {"pictures_a_second_median", middle_of(rate)}};
  const std::string text = j.dump(2) + "\n";
  std::unique_ptr<FILE, int (*)(FILE*)> out(
      to_stdout ? fdopen(dup(STDOUT_FILENO), "w") : std::fopen(b.json.c_str(), "w"), std::fclose);
  if (!out || std::fputs(text.c_str(), out.get()) < 0)
    throw std::runtime_error("bench view: cannot write " + b.json);
}

}  // namespace

void add_bench_view(CLI::App& bench) {
  auto b = std::make_shared<ViewBench>();
  CLI::App* command = bench.add_subcommand(
      "view", "what a window costs the force loop: the same node without and with one, in turns");
  command->add_option("--pairs", b->pairs, "of runs")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  command->add_option("--seconds", b->seconds, "of each run [s]")
      ->check(CLI::Range(1.0, 3600.0))
      ->capture_default_str();
  command->add_option("--scene", b->scene, "with all users at one node")->capture_default_str();
  command->add_option("--size", b->size, "of the window")->capture_default_str();
  command->add_option("--priority", b->priority, "SCHED_FIFO of the force loop; 0: ordinary")
      ->check(CLI::Range(0, 99))
      ->capture_default_str();
  command->add_option("--json", b->json, "write the numbers here; - is standard output");
  command->callback([b] { bench_view(*b); });
}

}  // namespace tandem::bench
