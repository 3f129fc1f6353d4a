#include "harness/seen_check.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include <fmt/format.h>

#include "harness/point_result.h"

namespace tandem::harness {
namespace {

constexpr double kFineHz = 100e3;  // ticks of 10 us
constexpr int kCapacity = 4096;    // packets in flight
constexpr double kChance = 3.3;    // standard deviations: 99.9 %

struct Run {
  double p50 = 0.0, spread = 0.0, mean = 0.0, variance = 0.0, loss = 0.0, duplicates = 0.0,
         reordered = 0.0;
};

/// One probe through the modelled link.
[[nodiscard]] Run probed(const core::LinkModelParameters& parameters, int packets, int every) {
  using Link = core::LinkModel<int, kCapacity>;
  const auto link = std::make_unique<Link>(parameters);
  std::vector<double> delays(static_cast<std::size_t>(packets), -1.0);
  Run run;
  int newest = -1;
  const auto accept = [&](int number, std::int64_t sent, std::int64_t now) {
    double& delay = delays[static_cast<std::size_t>(number)];
    if (delay >= 0.0) {
      run.duplicates += 1.0;
      return;
    }
    delay = static_cast<double>(now - sent) / kFineHz;
    if (number < newest) run.reordered += 1.0;
    newest = std::max(newest, number);
  };
  const std::int64_t last_sent = std::int64_t{packets - 1} * every;
  for (std::int64_t slot = 0; slot <= last_sent || link->in_flight() > 0; ++slot) {
    if (slot <= last_sent && slot % every == 0) link->push(static_cast<int>(slot / every), slot);
    link->deliver(
        slot, [&](int number, std::int64_t sent, std::uint64_t) { accept(number, sent, slot); });
  }
  const double n = packets;
  const auto lost = std::partition(delays.begin(), delays.end(), [](double d) { return d >= 0.0; });
  run.loss = static_cast<double>(delays.end() - lost) / n;
  run.duplicates /= n;
  run.reordered /= n;
  delays.erase(lost, delays.end());
  if (delays.empty()) return run;
  std::sort(delays.begin(), delays.end());
  const auto at = [&](double f) {
    return delays[static_cast<std::size_t>(f * static_cast<double>(delays.size()))];
  };
  run.p50 = at(0.5);
  run.spread = at(0.9) - at(0.1);
  for (const double d : delays) run.mean += d / static_cast<double>(delays.size());
  for (const double d : delays)
    run.variance += (d - run.mean) * (d - run.mean) / static_cast<double>(delays.size());
  return run;
}

/// A recorded network whose playing began `ahead` before the probe [s].
[[nodiscard]] Condition begun(Condition condition, double ahead) {
  const RecordedSeries& whole = *condition.recorded;
  RecordedSeries rest = whole;
  rest.time.clear();
  rest.delay.clear();
  const double first = whole.time.front() + ahead;
  for (std::size_t k = 0; k < whole.time.size(); ++k) {
    if (k + 1 < whole.time.size() && whole.time[k + 1] <= first) continue;
    rest.time.push_back(std::max(whole.time[k], first));
    rest.delay.push_back(whole.delay[k]);
  }
  condition.recorded = std::make_shared<const RecordedSeries>(std::move(rest));
  return condition;
}

}  // namespace

ProbePlan probe_plan(const Condition& condition) {
  ProbePlan plan;
  const bool slow = condition.outage || condition.recorded;
  if (slow || condition.bursts) plan.seconds = 5.0;
  // A line must carry the probe, or its queue is what is seen.
  constexpr double kProbeBits = 8.0 * (64 + 42);
  if (condition.rate_bit_per_s > 0.0)
    plan.rate_hz = std::min(plan.rate_hz, 0.2 * condition.rate_bit_per_s / kProbeBits);
  return plan;
}

ExpectedSight expected_sight(const Condition& condition, const ProbePlan& plan) {
  const int every = static_cast<int>(std::lround(kFineHz / plan.rate_hz));
  const int packets = std::max(1, static_cast<int>(plan.rate_hz * plan.seconds));
  core::Rates rates;
  rates.local_hz = kFineHz;
  rates.packet_hz = plan.rate_hz;
  Condition unqueued = condition;  // its own packets never meet: the time on the line is a delay
  unqueued.rate_bit_per_s = 0.0;
  const bool by_chance = condition.jitter > 0.0 || condition.loss > 0.0 || condition.bursts ||
                         condition.duplicate > 0.0 || condition.reorder > 0.0;
  // A median that hangs on when the playing began says nothing of the network: it is looked for at
  // beginnings up to kPlayed apart.
  constexpr double kPlayed = 0.2;  // [s]
  constexpr int kBeginnings = 11;
  const int runs = by_chance ? 60 : condition.recorded ? kBeginnings : 1;
  std::vector<Run> all;
  for (int i = 0; i < runs; ++i) {
    FateStore fates;
    const Condition as_played =
        condition.recorded ? begun(unqueued, kPlayed * i / (runs - 1.0)) : unqueued;
    all.push_back(
        probed(modelled_link(as_played, rates, static_cast<std::uint64_t>(i + 1), 64, fates),
               packets, every));
  }
  const auto mean_and_sd = [&](double Run::*what, double& mean, double& sd) {
    mean = sd = 0.0;
    for (const Run& run : all) mean += run.*what / runs;
    for (const Run& run : all) sd += (run.*what - mean) * (run.*what - mean) / runs;
    sd = std::sqrt(sd);
  };
  ExpectedSight out;
  double variance = 0.0, ignored = 0.0;
  mean_and_sd(&Run::p50, out.delay_p50, out.delay_p50_sd);
  mean_and_sd(&Run::spread, out.delay_spread, ignored);
  mean_and_sd(&Run::variance, variance, ignored);
  mean_and_sd(&Run::loss, out.loss, out.loss_sd);
  mean_and_sd(&Run::duplicates, out.duplicates, out.duplicates_sd);
  if (condition.reorder > 0.0) mean_and_sd(&Run::reordered, out.reordered, out.reordered_sd);
  out.delay_sd = std::sqrt(variance);
  if (condition.rate_bit_per_s > 0.0)
    out.delay_p50 += 8.0 * (64 + 42) / condition.rate_bit_per_s;  // probe, UDP, IPv4, Ethernet
  return out;
}

double sd_by_spread(const SeenLink& seen) {
  const ExpectedSight& e = seen.expected;
  return e.delay_spread > 0.0 ? e.delay_sd * seen.delay_spread / e.delay_spread : seen.delay_rms;
}

std::vector<std::string> out_of_bounds(const SeenLink& seen) {
  constexpr double kDelay = 0.3e-3, kOwnSd = 0.5e-3, kSd = 0.1, kRate = 0.05;
  std::vector<std::string> out;
  if (seen.sent <= 0) return out;
  const ExpectedSight& e = seen.expected;
  const auto check = [&](const char* what, double got, double wanted, double bound, double factor,
                         const char* unit) {
    if (std::abs(got - wanted) > bound)
      out.push_back(fmt::format("{} seen {:.4g} {}, set {:.4g} +- {:.2g}", what, factor * got, unit,
                                factor * wanted, factor * bound));
  };
  if (e.loss < 0.5)  // else there is nothing to take a delay of
    check("delay p50", seen.delay_p50, e.delay_p50, kDelay + kChance * e.delay_p50_sd, 1e3, "ms");
  if (e.delay_sd > kOwnSd && e.loss < 0.5)
    check("standard deviation", seen.delay_sd, e.delay_sd, kSd * e.delay_sd, 1e3, "ms");
  // Edges of outages and recorded losses are played some milliseconds late.
  const double n = static_cast<double>(seen.sent);
  const double edge = seen.changes ? 0.01 : 0.0;
  check("loss", seen.loss, e.loss, kChance * e.loss_sd + edge + 1e-9, 100.0, "%");
  check("duplicates", static_cast<double>(seen.duplicates) / n, e.duplicates,
        kChance * e.duplicates_sd + 1e-9, 100.0, "%");
  if (e.reordered_sd > 0.0)
    check("overtaken", static_cast<double>(seen.reordered) / n, e.reordered,
          kChance * e.reordered_sd, 100.0, "%");
  if (seen.rate_set > 0.0)
    check("rate", seen.rate_seen, seen.rate_set, kRate * seen.rate_set, 1e-3, "kbit/s");
  return out;
}

}  // namespace tandem::harness
