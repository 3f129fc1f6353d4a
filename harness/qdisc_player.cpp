#include "harness/qdisc_player.h"

#include <algorithm>
#include <cmath>
#include <condition_variable>
#include <mutex>

#include "core/clock.h"
#include "core/realtime.h"

namespace tandem::harness {
namespace {

void add_outage(const Outage& outage, double seconds, std::vector<double>& times) {
  for (double start = outage.start; start < seconds; start += outage.period) {
    times.push_back(start);
    times.push_back(start + outage.length);
    if (outage.period <= 0.0) break;
  }
}

void add_series(const RecordedSeries& series, double seconds, std::vector<double>& times) {
  if (series.time.size() < 2) return;
  // It starts again after its end; the last entry holds as long as the mean of the others.
  const double length = series.time.back() * static_cast<double>(series.time.size()) /
                        static_cast<double>(series.time.size() - 1);
  if (!(length > 0.0)) return;
  double last = -1.0;
  for (double begin = 0.0; begin < seconds; begin += length)
    for (const double time : series.time) {
      if (begin + time - last < 1.0 / kLargestChangeRate) continue;
      times.push_back(last = begin + time);
      if (last > seconds) return;
    }
}

}  // namespace

std::vector<ConditionChange> changes_of(const Condition& condition, double seconds) {
  std::vector<double> times;
  if (condition.outage) add_outage(*condition.outage, seconds, times);
  if (condition.recorded) add_series(*condition.recorded, seconds, times);
  std::sort(times.begin(), times.end());
  std::vector<ConditionChange> changes;
  for (const double time : times) {
    if (time > seconds) break;
    // Just after the edge: sums of times are not exact.
    std::vector<std::string> arguments = netem_arguments(at_time(condition, time + 1e-6));
    if (arguments.empty()) arguments = {"delay", "0ms"};
    if (changes.empty() || changes.back().netem_arguments != arguments)
      changes.push_back({time, std::move(arguments)});
  }
  return changes;
}

QdiscPlayer::QdiscPlayer(const std::string& network, std::vector<ConditionChange> changes,
                         std::int64_t start_ns)
    : tc_({"tc", "-batch", "-"}, {.network = network, .environment = {}, .takes_input = true}) {
  thread_ =
      std::jthread([this, changes = std::move(changes), start_ns](const std::stop_token& stop) {
        // A little below the nodes' link threads: late by microseconds, not by a node's whole turn.
        const core::RealtimeGrant grant = core::request_realtime({.priority = 60,
                                                                  .lock_memory = false,
                                                                  .cpu = {},
                                                                  .timer_slack_ns = 1,
                                                                  .hold_cpu_dma_latency = false});
        std::mutex mutex;
        std::condition_variable_any wake;
        core::MonotonicClock clock;
        for (const ConditionChange& change : changes) {
          std::string line = "qdisc change dev eth0 root netem";
          for (const std::string& word : change.netem_arguments) line += " " + word;
          const std::int64_t due = start_ns + std::llround(1e9 * change.time);
          std::unique_lock lock(mutex);
          const std::chrono::steady_clock::time_point when{std::chrono::nanoseconds(due)};
          if (clock.now_ns() < due) wake.wait_until(lock, stop, when, [] { return false; });
          if (stop.stop_requested() || !tc_.write(line + "\n")) return;
        }
      });
}

QdiscPlayer::~QdiscPlayer() {
  thread_.request_stop();
  if (thread_.joinable()) thread_.join();
}

std::string QdiscPlayer::failure() {
  thread_.request_stop();
  if (thread_.joinable()) thread_.join();
  tc_.end_input();
  const auto status = tc_.wait(2.0);
  if (status == 0) return {};
  return tc_.said().empty() ? "it did not end well, and said nothing" : tc_.said();
}

}  // namespace tandem::harness
