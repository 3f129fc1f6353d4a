#include "harness/condition.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>

namespace tandem::harness {

namespace {

constexpr double kLongest = 10.0;  ///< delays and jitter [s]
constexpr double kSlowest = 1e3;   ///< rate [bit/s]

bool is_fraction(double x) { return x >= 0.0 && x <= 1.0; }  // false for not-a-number

std::string percent(double fraction) { return fmt::format("{:.6g}%", 100.0 * fraction); }
std::string milliseconds(double seconds) { return fmt::format("{:.6g}ms", 1e3 * seconds); }
std::string for_people(double seconds) {
  return seconds >= 1.0 ? fmt::format("{:.4g} s", seconds)
                        : fmt::format("{:.4g} ms", 1e3 * seconds);
}

const char* netem_name(Distribution d) {
  switch (d) {
    case Distribution::kUniform:
      return "";  // netem's own, without a table
    case Distribution::kNormal:
      return "normal";
    case Distribution::kPareto:
      return "pareto";
    case Distribution::kParetoNormal:
      return "paretonormal";
  }
  return "";
}

core::JitterKind modelled(Distribution d) {
  switch (d) {
    case Distribution::kUniform:
      return core::JitterKind::kUniform;
    case Distribution::kNormal:
      return core::JitterKind::kNormal;
    case Distribution::kPareto:
      return core::JitterKind::kPareto;
    case Distribution::kParetoNormal:
      return core::JitterKind::kParetoNormal;
  }
  return core::JitterKind::kNone;
}

std::string problem_with_bursts(const Bursts& b) {
  const auto chance = [](double x) { return x > 0.0 && x <= 1.0; };
  if (!chance(b.enter))
    return fmt::format("bursts.enter {:g} must be more than 0 and at most 1", b.enter);
  if (!chance(b.leave))
    return fmt::format("bursts.leave {:g} must be more than 0 and at most 1", b.leave);
  if (!is_fraction(b.loss_inside))
    return fmt::format("bursts.loss_inside {:g} must be within 0 and 1", b.loss_inside);
  if (!is_fraction(b.loss_outside))
    return fmt::format("bursts.loss_outside {:g} must be within 0 and 1", b.loss_outside);
  return {};
}

std::string problem_with_outage(const Outage& o) {
  if (!(o.start >= 0.0 && o.start < 1e6))
    return fmt::format("outage.start {:g} s must be within 0 and 10^6 s", o.start);
  if (!(o.length > 0.0 && o.length < 1e6))
    return fmt::format("outage.length {:g} s must be more than 0 and less than 10^6 s", o.length);
  if (o.period != 0.0 && !(o.period > o.length && o.period < 1e6))
    return fmt::format(
        "outage.period {:g} s must be longer than the outage of {:g} s, or 0 for one", o.period,
        o.length);
  return {};
}

std::string problem_with_series(const RecordedSeries& s) {
  if (s.time.empty() || s.time.size() != s.delay.size())
    return fmt::format("recorded {}: needs as many delays as times, at least one ({} and {})",
                       s.source, s.delay.size(), s.time.size());
  for (std::size_t i = 1; i < s.time.size(); ++i)
    if (!(s.time[i] > s.time[i - 1]))
      return fmt::format("recorded {}: times must rise; entry {} has {:g} s after {:g} s", s.source,
                         i + 1, s.time[i], s.time[i - 1]);
  for (std::size_t i = 0; i < s.delay.size(); ++i)
    if (s.delay[i] < 0.0 || s.delay[i] > 1e3)
      return fmt::format("recorded {}: entry {} has a delay of {:g} s; 0 to 1000 s are allowed",
                         s.source, i + 1, s.delay[i]);
  return {};
}

/// What happened to a packet sent `time` after the start; the series goes round.
double recorded_at(const RecordedSeries& s, double time) {
  const double first = s.time.front();
  const std::size_t n = s.time.size();
  const double step = n > 1 ? (s.time.back() - first) / static_cast<double>(n - 1) : 1.0;
  const double length = s.time.back() - first + step;
  const double at = first + std::fmod(time, length);
  const auto after = std::upper_bound(s.time.begin(), s.time.end(), at);
  return s.delay[static_cast<std::size_t>(std::max<std::ptrdiff_t>(after - s.time.begin() - 1, 0))];
}

}  // namespace

bool is_clear(const Condition& c) {
  return c.delay == 0.0 && c.jitter == 0.0 && c.loss == 0.0 && !c.bursts && c.duplicate == 0.0 &&
         c.reorder == 0.0 && c.rate_bit_per_s == 0.0 && !c.outage && !c.recorded;
}

std::string problem_with(const Condition& c) {
  if (!(c.delay >= 0.0 && c.delay <= kLongest))
    return fmt::format("delay {:g} s must be within 0 and {:g} s", c.delay, kLongest);
  if (!(c.jitter >= 0.0 && c.jitter <= kLongest))
    return fmt::format("jitter {:g} s must be within 0 and {:g} s", c.jitter, kLongest);
  if (c.jitter > 0.0 && c.delay == 0.0 && !c.recorded)
    return fmt::format(
        "jitter {:g} s needs a delay to spread about: netem cuts what comes before 0", c.jitter);
  if (!(c.correlation >= 0.0 && c.correlation < 1.0))
    return fmt::format("correlation {:g} must be at least 0 and less than 1", c.correlation);
  if (c.correlation > 0.0 && c.jitter == 0.0)
    return fmt::format("correlation {:g} without jitter has nothing to correlate", c.correlation);
  if (!is_fraction(c.loss))
    return fmt::format("loss {:g} must be within 0 and 1 (it is a fraction, not percent)", c.loss);
  if (c.bursts && c.loss > 0.0)
    return fmt::format(
        "loss {:g} and bursts together: netem has one kind of loss at a time; put it into "
        "bursts.loss_outside",
        c.loss);
  if (c.bursts)
    if (std::string why = problem_with_bursts(*c.bursts); !why.empty()) return why;
  if (!is_fraction(c.duplicate))
    return fmt::format("duplicate {:g} must be within 0 and 1", c.duplicate);
  if (!is_fraction(c.reorder)) return fmt::format("reorder {:g} must be within 0 and 1", c.reorder);
  if (c.reorder > 0.0 && c.delay == 0.0)
    return fmt::format("reorder {:g} without delay: there is nothing to be sent past", c.reorder);
  if (c.rate_bit_per_s != 0.0 && !(c.rate_bit_per_s >= kSlowest && c.rate_bit_per_s <= 1e12))
    return fmt::format("rate_bit_per_s {:g} must be 0 (no limit) or within {:g} and 10^12",
                       c.rate_bit_per_s, kSlowest);
  if (c.outage)
    if (std::string why = problem_with_outage(*c.outage); !why.empty()) return why;
  if (c.recorded) {
    if (c.delay > 0.0 || c.jitter > 0.0 || c.loss > 0.0 || c.bursts || c.reorder > 0.0)
      return "a recorded network has delay and loss of its own: leave delay, jitter, loss, bursts "
             "and reorder out";
    if (std::string why = problem_with_series(*c.recorded); !why.empty()) return why;
  }
  return {};
}

std::string to_text(const Condition& c) {
  if (is_clear(c)) return "clear";
  std::vector<std::string> parts;
  if (c.recorded) parts.push_back("recorded " + c.recorded->source);
  if (c.delay > 0.0) parts.push_back(for_people(c.delay));
  if (c.jitter > 0.0)
    parts.push_back(c.distribution == Distribution::kUniform
                        ? "+- " + for_people(c.jitter) + " uniform"
                        : "sd " + for_people(c.jitter) + " " + netem_name(c.distribution));
  if (c.correlation > 0.0) parts.push_back("correlation " + percent(c.correlation));
  if (c.loss > 0.0) parts.push_back("loss " + percent(c.loss));
  if (c.bursts) {
    const Bursts usual;
    std::string text =
        fmt::format("bursts in {} out {}", percent(c.bursts->enter), percent(c.bursts->leave));
    if (c.bursts->loss_inside != usual.loss_inside)
      text += " losing " + percent(c.bursts->loss_inside);
    if (c.bursts->loss_outside != usual.loss_outside)
      text += ", else " + percent(c.bursts->loss_outside);
    parts.push_back(text);
  }
  if (c.duplicate > 0.0) parts.push_back("duplicate " + percent(c.duplicate));
  if (c.reorder > 0.0) parts.push_back("reorder " + percent(c.reorder));
  if (c.rate_bit_per_s > 0.0) parts.push_back(fmt::format("{:g} bit/s", c.rate_bit_per_s));
  if (c.outage)
    parts.push_back("outage " + for_people(c.outage->length) + " at " +
                    for_people(c.outage->start) +
                    (c.outage->period > 0.0 ? " every " + for_people(c.outage->period) : ""));
  return fmt::format("{}", fmt::join(parts, ", "));
}

std::vector<std::string> netem_arguments(const Condition& c) {
  std::vector<std::string> words;
  const auto say = [&](std::initializer_list<std::string> more) {
    words.insert(words.end(), more);
  };
  if (c.delay > 0.0 || c.jitter > 0.0) {
    say({"delay", milliseconds(c.delay)});
    if (c.jitter > 0.0) say({milliseconds(c.jitter)});
    if (c.correlation > 0.0) say({percent(c.correlation)});
    if (c.jitter > 0.0 && c.distribution != Distribution::kUniform)
      say({"distribution", netem_name(c.distribution)});
  }
  if (c.reorder > 0.0) say({"reorder", percent(c.reorder)});
  if (c.bursts) {
    const Bursts& b = *c.bursts;
    say({"loss", "gemodel", percent(b.enter), percent(b.leave), percent(b.loss_inside),
         percent(b.loss_outside)});
  } else if (c.loss > 0.0) {
    say({"loss", percent(c.loss)});
  }
  if (c.duplicate > 0.0) say({"duplicate", percent(c.duplicate)});
  if (c.rate_bit_per_s > 0.0) say({"rate", fmt::format("{:.0f}bit", c.rate_bit_per_s)});
  return words;
}

Condition at_time(const Condition& condition, double time) {
  Condition now = condition;
  now.outage.reset();
  now.recorded.reset();
  if (condition.recorded) {
    const double delay = recorded_at(*condition.recorded, time);
    if (std::isfinite(delay))
      now.delay = delay;
    else
      now.loss = 1.0;
  }
  if (condition.outage && time >= condition.outage->start) {
    double since = time - condition.outage->start;
    if (condition.outage->period > 0.0) since = std::fmod(since, condition.outage->period);
    if (since < condition.outage->length) {
      now.loss = 1.0;
      now.bursts.reset();
    }
  }
  return now;
}

FateStore::FateStore() = default;

const std::vector<double>& FateStore::fates(const RecordedSeries& series,
                                            const core::Rates& rates) {
  for (const Entry& e : entries_)
    if (e.series == &series && e.packet_hz == rates.packet_hz && e.local_hz == rates.local_hz)
      return *e.fates;
  constexpr std::size_t kMost = 1u << 20;  // packets; then the recording starts again
  const double n = static_cast<double>(series.time.size());
  const double length =
      n > 1 ? (series.time.back() - series.time.front()) * n / (n - 1) : 1.0 / rates.packet_hz;
  const auto count = static_cast<std::size_t>(std::ceil(length * rates.packet_hz));
  auto fates = std::make_unique<std::vector<double>>(std::clamp<std::size_t>(count, 1, kMost));
  for (std::size_t i = 0; i < fates->size(); ++i) {
    const double delay = recorded_at(series, static_cast<double>(i) / rates.packet_hz);
    (*fates)[i] = std::isfinite(delay) ? delay * rates.local_hz : -1.0;
  }
  entries_.push_back({&series, rates.packet_hz, rates.local_hz, std::move(fates)});
  return *entries_.back().fates;
}

core::LinkModelParameters modelled_link(const Condition& c, const core::Rates& rates,
                                        std::uint64_t seed, int bytes, FateStore& fates) {
  core::LinkModelParameters link;
  const auto ticks = [&](double seconds) { return seconds * rates.local_hz; };
  const auto slots = [&](double seconds) {
    return static_cast<std::int64_t>(std::llround(ticks(seconds)));
  };
  link.seed = seed;
  link.delay_ticks = ticks(c.delay);
  // What is a whole number of ticks in the sweep must not become one more by rounding.
  if (const double whole = std::round(link.delay_ticks); std::abs(link.delay_ticks - whole) < 1e-9)
    link.delay_ticks = whole;
  if (c.jitter > 0.0) {
    link.jitter = modelled(c.distribution);
    link.jitter_ticks = ticks(c.jitter);
  }
  link.loss = c.loss;
  if (c.bursts) {
    link.burst_enter = c.bursts->enter;
    link.burst_leave = c.bursts->leave;
    link.burst_loss = c.bursts->loss_inside;
    link.loss = c.bursts->loss_outside;
  }
  link.duplicate = c.duplicate;
  link.reorder = c.reorder;
  if (c.rate_bit_per_s > 0.0) link.service_ticks = ticks(8.0 * bytes / c.rate_bit_per_s);
  if (c.outage) {
    link.outage_start = slots(c.outage->start);
    link.outage_length = std::max<std::int64_t>(slots(c.outage->length), 1);
    link.outage_period = slots(c.outage->period);
  }
  if (c.recorded) {
    link.recorded = fates.fates(*c.recorded, rates);
  }
  return link;
}

namespace {

/// Of the packets that two clocks are set by: those that came soonest [ticks]. Jitter, which
/// mostly is alike both ways, is left out.
[[nodiscard]] double least_delay(const core::LinkModelParameters& link) {
  double recorded = std::numeric_limits<double>::infinity();
  for (const double delay : link.recorded)
    if (delay >= 0.0) recorded = std::min(recorded, delay);
  return link.delay_ticks + link.service_ticks + (std::isfinite(recorded) ? recorded : 0.0);
}

}  // namespace

core::NetworkModel modelled_network(const LinkConditions& conditions, const core::Scene& scene,
                                    std::uint64_t seed, FateStore& fates) {
  constexpr int kServer = core::NetworkModel::kServer;
  core::NetworkModel network;
  core::Random seeds(seed);
  const int bytes = packet_bytes(scene);
  for (int i = 0; i <= core::kMaxUsers; ++i)
    for (int j = 0; j <= core::kMaxUsers; ++j) {
      const bool there = (i < j && j != kServer) || i == kServer;
      network.link[i][j] = modelled_link(there ? conditions.there : conditions.back, scene.rates,
                                         seeds.bits(), bytes, fates);
    }
  for (int i = 0; i <= core::kMaxUsers; ++i)
    for (int j = 0; j <= core::kMaxUsers; ++j)
      network.link[i][j].age_error_ticks =
          0.5 * (least_delay(network.link[j][i]) - least_delay(network.link[i][j]));
  return network;
}

int packet_bytes(const core::Scene& scene) {
  constexpr int kFinger[] = {2, 4, 6}, kObject[] = {2, 6, 13};  // numbers, by space
  constexpr int kState = 8 + 80 + 3;                            // net/WIRE_FORMAT.md
  constexpr int kHeaders = 8 + 20 + 14;                         // UDP, IPv4, Ethernet
  const int space = static_cast<int>(scene.space);
  std::size_t fingers = 0;
  for (const auto& user : scene.users) fingers = std::max(fingers, user.fingers.size());
  return kState + kHeaders +
         8 * (static_cast<int>(fingers) * kFinger[space] +
              static_cast<int>(scene.objects.size()) * kObject[space]);
}

}  // namespace tandem::harness
