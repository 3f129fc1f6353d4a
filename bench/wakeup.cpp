// How late a periodic loop wakes, under each way a node can wait, beside cyclictest.
//
// What the numbers cannot tell: the loops do no work, one runs at a time, and nothing competes for
// the processors; the maximum is the machine's, not the way of waiting's.

#include "bench/wakeup.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <memory>
#include <stdexcept>
#include <sys/mman.h>
#include <thread>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "bench/cyclictest.h"
#include "bench/processor_time.h"
#include "core/periodic_schedule.h"
#include "core/realtime.h"
#include "core/wakeup_statistics.h"

namespace tandem::bench {
namespace {

using core::RealtimeGrant;
using core::RealtimeRequest;
using core::WakeupStatistics;

/// What one way of waiting gathers over the rounds.
struct Variant {
  std::string name;
  RealtimeRequest request;
  std::int64_t spin_ns = 0;
  bool node_default = false;  ///< spin window chosen by the grant, as a node does
  std::vector<double> p50, p99, p999;
  double max_us = 0.0;
  std::int64_t wakeups = 0, missed = 0;
  double processor_seconds = 0.0, wall_seconds = 0.0;
  std::string not_granted;
};

double median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  std::sort(values.begin(), values.end());
  const std::size_t middle = values.size() / 2;
  return values.size() % 2 == 1 ? values[middle] : 0.5 * (values[middle - 1] + values[middle]);
}

void add(Variant& variant, const WakeupStatistics& lateness) {
  variant.p50.push_back(1e-3 * static_cast<double>(lateness.percentile_ns(0.50)));
  variant.p99.push_back(1e-3 * static_cast<double>(lateness.percentile_ns(0.99)));
  variant.p999.push_back(1e-3 * static_cast<double>(lateness.percentile_ns(0.999)));
  variant.max_us = std::max(variant.max_us, 1e-3 * static_cast<double>(lateness.max_ns()));
  variant.wakeups += static_cast<std::int64_t>(lateness.count());
  variant.missed += lateness.missed();
}

/// One round of one variant, on a thread of its own so that its priority ends with it.
void measure(Variant& variant, double rate_hz, std::int64_t slots) {
  std::thread loop([&] {
    const RealtimeGrant grant = core::request_realtime(variant.request);
    variant.not_granted.clear();
    for (const auto& setting : grant.settings()) {
      if (setting.granted) continue;
      variant.not_granted +=
          (variant.not_granted.empty() ? "" : "; ") + setting.name + " (" + setting.refusal + ")";
    }
    if (variant.node_default) variant.spin_ns = grant.default_spin_ns();
    core::MonotonicClock clock;
    const auto lateness = std::make_unique<WakeupStatistics>();
    const std::int64_t start = clock.now_ns() + 10'000'000;
    core::PeriodicSchedule schedule(start, rate_hz, variant.spin_ns);
    constexpr std::int64_t kWarmUp = 20;  // first wake-ups fault pages in
    const double before = core_seconds();
    std::int64_t slot = 0;
    while (slot < slots + kWarmUp) {
      const auto wake = schedule.wait(clock);
      slot = wake.slot + 1;
      if (wake.slot >= kWarmUp) lateness->record(wake.lateness_ns, wake.missed);
    }
    variant.processor_seconds += core_seconds() - before;
    variant.wall_seconds += 1e-9 * static_cast<double>(clock.now_ns() - start);
    add(variant, *lateness);
  });
  loop.join();
  munlockall();  // the lock is the process's and would outlive the variant
}

std::vector<Variant> variants(int priority) {
  const RealtimeRequest nothing{.priority = 0,
                                .lock_memory = false,
                                .cpu = {},
                                .timer_slack_ns = 0,
                                .hold_cpu_dma_latency = false};
  RealtimeRequest fifo;
  fifo.priority = priority;
  fifo.hold_cpu_dma_latency = false;
  RealtimeRequest fifo_latency = fifo;
  fifo_latency.hold_cpu_dma_latency = true;
  std::vector<Variant> all(5);
  all[0].name = "plain";
  all[0].request = nothing;
  all[1].name = "fifo";
  all[1].request = fifo;
  all[2].name = "fifo+dma_latency_0";
  all[2].request = fifo_latency;
  all[3].name = "fifo+spin_120us";
  all[3].request = fifo;
  all[3].spin_ns = core::kSpinDeepSleepNs;
  all[4].name = "fifo+dma_latency_0+spin_default";
  all[4].request = fifo_latency;
  all[4].node_default = true;
  return all;
}

WakeupRow row_of(const Variant& variant) {
  WakeupRow row;
  row.name = variant.name;
  if (variant.node_default) {
    row.name = fmt::format("fifo+dma_latency_0+spin_{}us", variant.spin_ns / 1000);
  }
  row.node_default = variant.node_default;
  row.p50_us = median(variant.p50);
  row.p99_us = median(variant.p99);
  row.p999_us = median(variant.p999);
  row.max_us = variant.max_us;
  row.wakeups = variant.wakeups;
  row.missed = variant.missed;
  if (variant.wall_seconds > 0.0) {
    row.processor_fraction = variant.processor_seconds / variant.wall_seconds;
  }
  row.not_granted = variant.not_granted;
  return row;
}

void check(const WakeupBenchOptions& options) {
  if (!(options.seconds > 0.0) || options.rounds < 1) {
    throw std::invalid_argument(
        fmt::format("wake-up bench: seconds {} and rounds {} must be above 0", options.seconds,
                    options.rounds));
  }
  if (options.priority < 1 || options.priority > 99) {
    throw std::invalid_argument(
        fmt::format("wake-up bench: priority is {}, must be within [1, 99]", options.priority));
  }
}

}  // namespace

WakeupBenchResults run_wakeup_bench(const WakeupBenchOptions& options) {
  check(options);
  const auto slots = static_cast<std::int64_t>(
      std::ceil(options.seconds * options.rate_hz / static_cast<double>(options.rounds)));
  const long interval_us = std::lround(1e6 / options.rate_hz);
  std::vector<Variant> all = variants(options.priority);
  Variant peer;
  peer.name = "cyclictest";
  WakeupBenchResults results;
  for (int round = 0; round < options.rounds; ++round) {
    for (Variant& variant : all) measure(variant, options.rate_hz, slots);
    if (round > 0 && peer.p99.empty()) continue;  // it could not be run: said once
    const CyclictestRun run = run_cyclictest(
        {.priority = options.priority, .interval_us = interval_us, .wakeups = slots});
    results.cyclictest = run.lateness ? run.command : run.why_not;
    if (run.lateness) add(peer, *run.lateness);
  }
  for (const Variant& variant : all) {
    results.rows.push_back(row_of(variant));
    if (variant.node_default) results.p99_us = results.rows.back().p99_us;
  }
  if (!peer.p99.empty()) {
    results.rows.push_back(row_of(peer));
    results.cyclictest_p99_us = results.rows.back().p99_us;
  }
  return results;
}

nlohmann::json to_json(const WakeupBenchResults& results) {
  nlohmann::json json;
  json["p99_us"] = results.p99_us;
  json["cyclictest_p99_us"] = nullptr;
  if (results.cyclictest_p99_us) json["cyclictest_p99_us"] = *results.cyclictest_p99_us;
  json["cyclictest"] = results.cyclictest;
  for (const WakeupRow& row : results.rows) {
    json["variants"].push_back({{"name", row.name},
                                {"node_default", row.node_default},
                                {"p50_us", row.p50_us},
                                {"p99_us", row.p99_us},
                                {"p999_us", row.p999_us},
                                {"max_us", row.max_us},
                                {"wakeups", row.wakeups},
                                {"missed", row.missed},
                                {"processor_fraction", row.processor_fraction},
                                {"not_granted", row.not_granted}});
  }
  // cyclictest neither skips slots nor says what it used.
  for (auto& row : json["variants"]) {
    if (row["name"] == "cyclictest") row["missed"] = row["processor_fraction"] = nullptr;
  }
  return json;
}

std::string to_text(const WakeupBenchResults& results) {
  std::string text = fmt::format("{:<36}{:>9}{:>9}{:>9}{:>10}{:>9}{:>11}\n", "lateness [us]", "p50",
                                 "p99", "p99.9", "max", "missed", "processor");
  for (const WakeupRow& row : results.rows) {
    const bool peer = row.name == "cyclictest";
    text +=
        fmt::format("{:<36}{:>9.1f}{:>9.1f}{:>9.1f}{:>10.1f}{:>9}{:>11}{}\n", row.name, row.p50_us,
                    row.p99_us, row.p999_us, row.max_us, peer ? "-" : std::to_string(row.missed),
                    peer ? "-" : fmt::format("{:.1f} %", 100.0 * row.processor_fraction),
                    row.node_default ? "  <- what a node does" : "");
    if (!row.not_granted.empty()) text += "  not granted: " + row.not_granted + "\n";
  }
  text +=
      (results.cyclictest_p99_us ? "beside it: " : "no comparison: ") + results.cyclictest + "\n";
  text +=
      "Holding the dma latency at 0 keeps every processor of the machine awake while it waits; "
      "the\n"
      "spin costs the processor time shown. Percentiles are medians over the rounds.\n";
  return text;
}

void add_bench_wakeup(CLI::App& bench) {
  struct Arguments {
    WakeupBenchOptions options;
    std::string json_file;
  };
  const auto arguments = std::make_shared<Arguments>();
  CLI::App* const wakeup =
      bench.add_subcommand("wakeup", "How late a force loop wakes, beside cyclictest");
  wakeup->add_option("--seconds", arguments->options.seconds, "Of each way of waiting [s]")
      ->check(CLI::Range(0.1, 86'400.0))
      ->capture_default_str();
  wakeup->add_option("--rounds", arguments->options.rounds, "The ways take turns this often")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  wakeup->add_option("--rate", arguments->options.rate_hz, "Of the loop [Hz]")
      ->check(CLI::Range(10.0, 10'000.0))
      ->capture_default_str();
  wakeup->add_option("--priority", arguments->options.priority, "SCHED_FIFO, 1 to 99")
      ->check(CLI::Range(1, 99))
      ->capture_default_str();
  wakeup->add_option("--json", arguments->json_file, "Write one JSON object here; - is the screen");
  wakeup->callback([arguments] {
    const WakeupBenchResults results = run_wakeup_bench(arguments->options);
    if (arguments->json_file != "-") fmt::print("{}", to_text(results));
    if (arguments->json_file == "-") fmt::print("{}\n", to_json(results).dump(2));
    if (!arguments->json_file.empty() && arguments->json_file != "-") {
      std::ofstream file(arguments->json_file);
      file << to_json(results).dump(2) << '\n';
      if (!file.flush()) {
        throw CLI::FileError("--json " + arguments->json_file + ": cannot be written");
      }
    }
  });
}

}  // namespace tandem::bench
