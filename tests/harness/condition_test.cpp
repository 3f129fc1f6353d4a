#include "harness/condition.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <set>
#include <string>

#include <gtest/gtest.h>

#include "core/modelled_port.h"
#include "core/random.h"
#include "harness/point_result.h"
#include "harness/seen_check.h"

namespace tandem::harness {
namespace {

std::string joined(const Condition& c) {
  std::string text;
  for (const std::string& word : netem_arguments(c)) text += (text.empty() ? "" : " ") + word;
  return text;
}

core::LinkModelParameters link_of(const Condition& c) {
  FateStore fates;
  return modelled_link(c, core::Rates{}, 1, 125, fates);
}

// What `man tc-netem` asks for, word for word.
TEST(Condition, IsSaidToNetemInItsOwnWords) {
  EXPECT_EQ(joined({}), "");
  EXPECT_EQ(joined({.delay = 0.005}), "delay 5ms");
  EXPECT_EQ(joined({.delay = 0.01, .jitter = 0.002, .distribution = Distribution::kUniform}),
            "delay 10ms 2ms");
  EXPECT_EQ(joined({.delay = 0.01, .jitter = 0.002, .correlation = 0.25}),
            "delay 10ms 2ms 25% distribution normal");
  EXPECT_EQ(joined({.delay = 0.0015, .jitter = 1e-6, .distribution = Distribution::kParetoNormal}),
            "delay 1.5ms 0.001ms distribution paretonormal");
  EXPECT_EQ(joined({.loss = 0.05, .duplicate = 0.01}), "loss 5% duplicate 1%");
  EXPECT_EQ(joined({.bursts = Bursts{0.01, 0.25, 1.0, 0.0}}), "loss gemodel 1% 25% 100% 0%");
  EXPECT_EQ(joined({.delay = 0.01, .reorder = 0.1, .rate_bit_per_s = 1e6}),
            "delay 10ms reorder 10% rate 1000000bit");
}

TEST(Condition, BecomesTicksOfTheModelledLink) {
  const auto link = link_of({.delay = 0.0078125, .jitter = 0.001, .loss = 0.1, .duplicate = 0.2});
  EXPECT_EQ(link.delay_ticks, 8.0);  // a packet period at 1024 and 128 Hz, exactly
  EXPECT_NEAR(link.jitter_ticks, 1.024, 1e-12);
  EXPECT_EQ(link.jitter, core::JitterKind::kNormal);
  EXPECT_EQ(link.loss, 0.1);
  EXPECT_EQ(link.duplicate, 0.2);
  const auto burst = link_of({.bursts = Bursts{0.01, 0.25, 0.9, 0.02},
                              .rate_bit_per_s = 1e6,
                              .outage = Outage{1.0, 0.1, 2.0}});
  EXPECT_EQ(burst.burst_enter, 0.01);
  EXPECT_EQ(burst.burst_leave, 0.25);
  EXPECT_EQ(burst.burst_loss, 0.9);
  EXPECT_EQ(burst.loss, 0.02);
  EXPECT_NEAR(burst.service_ticks, 1.024, 1e-12);  // 125 bytes at 1 Mbit/s are 1 ms
  EXPECT_EQ(burst.outage_start, 1024);
  EXPECT_EQ(burst.outage_length, 102);
  EXPECT_EQ(burst.outage_period, 2048);
}

TEST(Condition, OfOneDirectionStaysThere) {
  core::Scene scene;
  scene.architecture = core::Architecture::kCentral;
  scene.users.resize(2);
  FateStore fates;
  const auto network = modelled_network({{.delay = 1.0 / 128}, {}}, scene, 1, fates);
  constexpr int kServer = core::NetworkModel::kServer;
  EXPECT_EQ(network.link[0][1].delay_ticks, 8.0);
  EXPECT_EQ(network.link[1][0].delay_ticks, 0.0);
  EXPECT_EQ(network.link[kServer][1].delay_ticks, 8.0);  // the returned force
  EXPECT_EQ(network.link[1][kServer].delay_ticks, 0.0);
}

// Two clocks are set by packets both ways, which cannot tell where the delay is: a sample that took
// 8 ticks is reckoned half the round trip old, and so is one that took none.
TEST(Condition, AgesAreReckonedByHalfTheRoundTrip) {
  core::Scene scene;
  scene.users.resize(2);
  FateStore fates;
  const auto one_sided = modelled_network({{.delay = 1.0 / 128}, {}}, scene, 1, fates);
  EXPECT_EQ(one_sided.link[0][1].age_error_ticks, -4.0);
  EXPECT_EQ(one_sided.link[1][0].age_error_ticks, 4.0);
  const Condition slow{.delay = 0.010, .rate_bit_per_s = 1e6};
  const auto alike = modelled_network({slow, slow}, scene, 1, fates);
  EXPECT_EQ(alike.link[0][1].age_error_ticks, 0.0);
  // The line takes its time for every packet, those that clocks are set by too.
  Condition fast = slow;
  fast.rate_bit_per_s = 0.0;
  const auto rates = modelled_network({slow, fast}, scene, 1, fates);
  EXPECT_NEAR(rates.link[0][1].age_error_ticks,
              -0.5 * 8e-6 * packet_bytes(scene) * scene.rates.local_hz, 1e-12);
}

// The receiver takes a sample for older than it is by the error, and for no younger than nothing.
TEST(Condition, AModelledPortReckonsAgesAsItsLinkSays) {
  for (const double error : {0.0, 2.5, -3.25}) {
    core::LinkModelParameters link;
    link.delay_ticks = 2.0;
    link.age_error_ticks = error;
    core::ModelledPort<int> port(link);
    port.push(7, 10);
    EXPECT_EQ(port.receive(11), nullptr);
    EXPECT_EQ(port.reckoned_age(11), 0.0);  // before the first
    ASSERT_NE(port.receive(12), nullptr);
    for (std::int64_t slot = 12; slot < 20; ++slot) {
      EXPECT_EQ(port.age(slot), slot - 10);
      EXPECT_EQ(port.reckoned_age(slot), std::max(0.0, static_cast<double>(slot - 10) + error));
    }
  }
}

TEST(Condition, SaysWhatIsWrongWithIt) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::pair<Condition, const char*> wrong[] = {
      {{.delay = -0.001}, "delay"},
      {{.delay = nan}, "delay"},
      {{.delay = 11.0}, "delay"},
      {{.jitter = 0.001}, "needs a delay"},
      {{.correlation = 0.5}, "without jitter"},
      {{.loss = 5.0}, "fraction, not percent"},
      {{.loss = 0.1, .bursts = Bursts{0.01, 0.25}}, "one kind of loss"},
      {{.bursts = Bursts{0.0, 0.25}}, "bursts.enter"},
      {{.bursts = Bursts{0.1, nan}}, "bursts.leave"},
      {{.reorder = 0.1}, "without delay"},
      {{.rate_bit_per_s = 10.0}, "rate_bit_per_s"},
      {{.outage = Outage{1.0, 0.0}}, "outage.length"},
      {{.outage = Outage{1.0, 2.0, 1.5}}, "outage.period"},
  };
  for (const auto& [condition, word] : wrong)
    EXPECT_NE(problem_with(condition).find(word), std::string::npos) << word;
  EXPECT_EQ(problem_with({}), "");
  EXPECT_EQ(problem_with({.delay = 0.1, .jitter = 0.01, .loss = 1.0}), "");
}

TEST(Condition, OtherConditionsHaveOtherTexts) {
  Condition a;
  a.bursts = Bursts{.enter = 0.02, .leave = 0.2};
  a.outage = Outage{.start = 0.5, .length = 0.1};
  std::set<std::string> texts{to_text(a)};
  a.bursts->loss_inside = 0.7;
  texts.insert(to_text(a));
  a.bursts->loss_outside = 0.01;
  texts.insert(to_text(a));
  a.outage->period = 1.0;
  texts.insert(to_text(a));
  EXPECT_EQ(texts.size(), 4u);
}

TEST(Condition, OutageAndRecordingAreWhatHoldsAtThatTime) {
  Condition c{.delay = 0.002, .outage = Outage{1.0, 0.5, 2.0}};
  EXPECT_EQ(at_time(c, 0.99).loss, 0.0);
  EXPECT_EQ(at_time(c, 1.2).loss, 1.0);
  EXPECT_EQ(at_time(c, 1.2).delay, 0.002);
  EXPECT_EQ(at_time(c, 1.6).loss, 0.0);
  EXPECT_EQ(at_time(c, 3.1).loss, 1.0);
  auto series = std::make_shared<RecordedSeries>();
  series->time = {0.0, 1.0, 2.0};
  series->delay = {0.01, std::nan(""), 0.03};
  const Condition recorded{.recorded = series};
  EXPECT_EQ(at_time(recorded, 0.5).delay, 0.01);
  EXPECT_EQ(at_time(recorded, 1.5).loss, 1.0);
  EXPECT_EQ(at_time(recorded, 2.9).delay, 0.03);
  EXPECT_EQ(at_time(recorded, 3.5).delay, 0.01);  // from the start again
}

TEST(Condition, RecordingIsPlayedPacketByPacket) {
  auto series = std::make_shared<RecordedSeries>();
  series->time = {0.0, 0.5};
  series->delay = {2.0 / 128, std::nan("")};
  FateStore fates;
  const auto p = modelled_link({.recorded = series}, core::Rates{}, 1, 100, fates);
  ASSERT_EQ(p.recorded.size(), 128u);  // a second of packets, then again
  core::LinkModel<int> link(p);
  int arrived = 0;
  for (int slot = 0; slot < 2048 + 32; ++slot) {
    if (slot % 8 == 0 && slot < 2048) link.push(slot, slot);
    link.deliver(slot, [&](int sent, std::int64_t, std::uint64_t) {
      EXPECT_EQ(slot - sent, 16);
      ++arrived;
    });
  }
  EXPECT_EQ(arrived, 128);
  EXPECT_EQ(link.lost(), 128);
}

// Packets that take longer to send than there is between them queue: the k-th leaves k service
// times after the first came.
TEST(Condition, SlowLineMakesPacketsQueue) {
  core::LinkModelParameters p;
  p.service_ticks = 12.0;
  core::LinkModel<int> link(p);
  int last = 0;
  for (int slot = 0; slot < 400; ++slot) {
    if (slot % 8 == 0 && slot < 80) link.push(slot / 8, slot);
    link.deliver(slot, [&](int k, std::int64_t, std::uint64_t) {
      EXPECT_EQ(slot, 12 * (k + 1));
      last = k;
    });
  }
  EXPECT_EQ(last, 9);
}

// Closed forms: a uniform spread of half width w has the standard deviation w / sqrt 3; of n
// packets lost with chance p each, the share lost spreads by sqrt(p (1 - p) / n), in
// Gilbert-Elliott bursts by sqrt((1 + rho) / (1 - rho)) times that with rho = 1 - enter - leave.
TEST(ExpectedSight, IsWhatWasSet) {
  const ProbePlan plan;  // 1000 packets
  const ExpectedSight uniform = expected_sight(
      {.delay = 0.01, .jitter = 0.003, .distribution = Distribution::kUniform}, plan);
  EXPECT_NEAR(uniform.delay_p50, 0.01, 2e-5);  // ticks of 10 us, 60 runs
  EXPECT_NEAR(uniform.delay_sd, 0.003 / std::sqrt(3.0), 0.02 * 0.00173);
  EXPECT_NEAR(uniform.delay_spread, 0.8 * 2.0 * 0.003, 1e-4);
  EXPECT_EQ(uniform.loss, 0.0);
  EXPECT_EQ(uniform.reordered, 0.0);  // not asked for, though jitter overtakes

  const ExpectedSight lossy = expected_sight({.loss = 0.05}, plan);
  EXPECT_NEAR(lossy.loss, 0.05, 4.0 * std::sqrt(0.05 * 0.95 / 60e3));
  EXPECT_NEAR(lossy.loss_sd, std::sqrt(0.05 * 0.95 / 1000), 0.3 * 0.0069);  // of 60 runs: 9 %

  Condition bursts;
  bursts.bursts = Bursts{.enter = 0.01, .leave = 0.25, .loss_inside = 1.0, .loss_outside = 0.0};
  const ProbePlan long_plan = probe_plan(bursts);
  const double n = long_plan.rate_hz * long_plan.seconds, p = 0.01 / 0.26, rho = 0.74;
  const double sd = std::sqrt(p * (1.0 - p) / n * (1.0 + rho) / (1.0 - rho));
  EXPECT_NEAR(expected_sight(bursts, long_plan).loss, p, 4.0 * sd / std::sqrt(60.0));
  EXPECT_NEAR(expected_sight(bursts, long_plan).loss_sd, sd, 0.3 * sd);

  // Held back with chance 3/4, and one of the five packets sent in the next 10 ms is not.
  const ExpectedSight reordered = expected_sight({.delay = 0.0105, .reorder = 0.25}, plan);
  EXPECT_NEAR(reordered.reordered, 0.75 * (1.0 - std::pow(0.75, 5)), 0.02);

  Condition outages;
  outages.outage = Outage{.start = 0.5, .length = 0.1, .period = 1.0};
  EXPECT_NEAR(expected_sight(outages, probe_plan(outages)).loss, 0.1, 1e-3);
}

// The rms of all samples counts only where there is no spread to compare with; a spread twice as
// wide is twice the deviation.
// 10 ms, and from `edge` on 100 ms: of a probe of 5 s the median is one or the other.
ExpectedSight of_two_delays(double edge) {
  RecordedSeries series;
  series.time = {0.0, edge, 20.0};
  series.delay = {0.01, 0.1, 0.1};
  Condition condition;
  condition.recorded = std::make_shared<const RecordedSeries>(series);
  return expected_sight(condition, probe_plan(condition));
}

TEST(ExpectedSight, AMedianThatHangsOnWhenThePlayingBeganIsNotHeldToTheSecond) {
  EXPECT_NEAR(of_two_delays(2.0).delay_p50, 0.1, 1e-4);
  EXPECT_LT(of_two_delays(2.0).delay_p50_sd, 1e-4);
  // Begun 0 to 0.2 s ahead, it has 2.6 to 2.4 of 5 s at 10 ms.
  EXPECT_GT(of_two_delays(2.6).delay_p50_sd, 0.02);
}

TEST(ExpectedSight, AStallIsNoJitter) {
  SeenLink seen;
  seen.delay_rms = 0.009;
  seen.delay_spread = 0.0024;
  EXPECT_EQ(sd_by_spread(seen), 0.009);  // nothing to compare with
  seen.expected.delay_sd = 0.001;
  seen.expected.delay_spread = 0.0024;
  EXPECT_DOUBLE_EQ(sd_by_spread(seen), 0.001);
  seen.delay_spread = 0.0048;
  EXPECT_DOUBLE_EQ(sd_by_spread(seen), 0.002);
}

TEST(ExpectedSight, WhatIsOutOfItsBoundIsNamed) {
  SeenLink seen;
  seen.sent = 1000;
  seen.expected = {
      .delay_p50 = 0.01, .delay_p50_sd = 0.0, .delay_sd = 0.002, .loss = 0.05, .loss_sd = 0.007};
  seen.delay_p50 = 0.01025;
  seen.delay_sd = 0.0021;
  seen.loss = 0.06;
  EXPECT_TRUE(out_of_bounds(seen).empty());
  const auto named = [&](auto change, const std::string& word) {
    SeenLink wrong = seen;
    change(wrong);
    const std::vector<std::string> said = out_of_bounds(wrong);
    return said.size() == 1 && said[0].find(word) != std::string::npos;
  };
  EXPECT_TRUE(named([](SeenLink& s) { s.delay_p50 = 0.0104; }, "delay"));
  EXPECT_TRUE(named([](SeenLink& s) { s.delay_sd = 0.0023; }, "standard deviation"));
  EXPECT_TRUE(named([](SeenLink& s) { s.loss = 0.08; }, "loss"));
  EXPECT_TRUE(named([](SeenLink& s) { s.duplicates = 3; }, "duplicates"));
  EXPECT_TRUE(named([](SeenLink& s) { s.rate_set = 1e6, s.rate_seen = 0.9e6; }, "rate"));
}

// Of iproute2's tables: mean 0 before the cut at 4; cut where u^(-1/3) = 4.5, so
//   E x = 4/3 (3/2 (1 - u_c^(2/3)) + 4.5 u_c - 3/2),  u_c = 4.5^-3.
TEST(Condition, ParetoDrawsHaveTheMomentsOfNetemsTable) {
  core::Random random(5);
  const int n = 400000;
  double sum = 0, square = 0, mixed = 0;
  for (int i = 0; i < n; ++i) {
    const double x = random.netem_pareto();
    EXPECT_LE(x, 4.0);
    EXPECT_GE(x, -2.0 / 3.0 - 1e-12);
    sum += x, square += x * x;
    mixed += random.netem_pareto_normal();
  }
  const double uc = std::pow(4.5, -3.0);
  const double mean = 4.0 / 3.0 * (1.5 * (1.0 - std::pow(uc, 2.0 / 3.0)) + 4.5 * uc - 1.5);
  // E u^(-2/3) above the cut is 3 (1 - u_c^(1/3)).
  const double second = 3.0 * (1.0 - std::cbrt(uc)) + 20.25 * uc;
  const double first = 1.5 * (1.0 - std::pow(uc, 2.0 / 3.0)) + 4.5 * uc;
  const double variance = 16.0 / 9.0 * (second - first * first);
  EXPECT_NEAR(sum / n, mean, 4.0 * std::sqrt(variance / n));  // four standard errors
  EXPECT_NEAR(square / n - mean * mean, variance, 0.02 * variance);
  EXPECT_NEAR(mixed / n, 0.75 * mean, 0.01);  // the normal quarter has mean 0
}

}  // namespace
}  // namespace tandem::harness
