// Which reconstruction wins where, from results written by hand; the expected values are worked out
// from those numbers.
#include "harness/statement.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

namespace tandem::harness {
namespace {

PointResult result(const char* style, const char* label, double age_ms, double weber,
                   double coupling, double drag = 0.0) {
  PointResult r;
  r.point.architecture = "distributed";
  r.point.scene.architecture = core::Architecture::kDistributed;
  r.point.style = style;
  r.point.knob = "delay";
  r.point.label = label;
  r.mean_age = 1e-3 * age_ms;
  r.measures.stability.judged = r.measures.stability.stable = true;
  r.measures.sites.resize(2);
  for (int i : {0, 1}) {  // 0.5 and 1.5 times: the mean of the hands
    r.measures.sites[static_cast<std::size_t>(i)].force_error_weber = (0.5 + i) * weber;
    r.measures.sites[static_cast<std::size_t>(i)].force_error = (0.5 + i) * 10.0 * weber;
  }
  r.measures.drag = drag;
  r.prediction.judged = true;
  r.prediction.largest_coupling = coupling;
  r.largest_coupling = coupling;
  return r;
}

/// Extrapolation wins by error until it is no longer stable, by coupling from 10 ms to 20 ms.
std::vector<PointResult> sweep() {
  std::vector<PointResult> all = {
      result("hold", "5 ms", 5.0, 0.2, 4000.0, 2.0),
      result("compensated", "5 ms", 5.0, 0.1, 3600.0, 0.1),
      result("extrapolate", "5 ms", 5.0, 0.01, 2000.0),
      result("hold", "10 ms", 10.0, 0.3, 1000.0, 4.0),
      result("compensated", "10 ms", 10.0, 0.15, 700.0, 0.2),
      result("extrapolate", "10 ms", 10.0, 0.02, 2000.0),
      result("hold", "20 ms", 20.0, 0.4, 500.0, 8.0),
      result("compensated", "20 ms", 20.0, 0.19, 250.0, 0.4),
      result("extrapolate", "20 ms", 20.0, 0.188, 1000.0),
      result("hold", "40 ms", 40.0, 0.5, 200.0, 16.0),
      result("compensated", "40 ms", 40.0, 0.25, 0.0, 0.8),
      result("extrapolate", "40 ms", 40.0, 0.1, 100.0),
  };
  all[10].measures.stability.stable = false;  // compensated at 40 ms
  all[11].measures.stability.stable = false;  // extrapolated at 40 ms
  all[9].prediction.near_boundary = true;     // hold at 40 ms
  return all;
}

Contests only(const std::vector<PointResult>& results) {
  const std::vector<Contests> all = contests(results);
  EXPECT_EQ(all.size(), 1U);
  return all.empty() ? Contests{} : all.front();
}

std::string all_of(const std::vector<PointResult>& results) {
  std::string text;
  for (const std::string& sentence : statement(contests(results))) text += sentence + "\n";
  return text;
}

bool says(const std::string& text, const std::string& what) {
  return text.find(what) != std::string::npos;
}

using Who = std::vector<int>;

TEST(Contest, TheBestAtEveryValueAreNamedAndThoseWithinTwoPercentOfThem) {
  const Contests c = only(sweep());
  ASSERT_EQ(c.at.size(), 4U);
  EXPECT_EQ(c.at[0].least_error, Who{kExtrapolation});
  EXPECT_EQ(c.at[2].least_error, (Who{kCompensation, kExtrapolation}));  // 0.190 / 0.188 = 1.011
  EXPECT_EQ(c.at[3].least_error, Who{kHeld});                            // the others not stable
  EXPECT_EQ(c.at[0].largest_coupling, Who{kHeld});
  EXPECT_EQ(c.at[1].largest_coupling, Who{kExtrapolation});
  EXPECT_EQ(c.at[3].largest_coupling, Who{kHeld});
  EXPECT_DOUBLE_EQ(c.at[0].by[kHeld].weber, 0.2);
}

TEST(Contest, CompensationLeavesOfHoldsCouplingWhatTheNumbersSay) {
  const Margin m = only(sweep()).margin;  // 0.9, 0.7, 0.5, and nothing
  ASSERT_TRUE(m.known);
  EXPECT_DOUBLE_EQ(m.least, 0.5);
  EXPECT_EQ(m.least_at, "20 ms");
  EXPECT_EQ(m.nothing_at, std::vector<std::string>{"40 ms"});
  EXPECT_DOUBLE_EQ(m.most, 0.9);
  EXPECT_EQ(m.most_at, "5 ms");
  EXPECT_DOUBLE_EQ(m.median, 0.7);
}

TEST(Contest, ExtrapolationCrossesWhereTheLogarithmOfTheRatioIsZero) {
  const ByAge coupling = only(sweep()).by_coupling;  // 0.5, 2, 2, 0.5 times hold's
  ASSERT_EQ(coupling.crossings.size(), 2U);
  EXPECT_FALSE(coupling.crossings[0].from.wins());
  EXPECT_NEAR(coupling.crossings[0].at, 7.5e-3, 1e-15);  // log 0.5 to log 2 over 5 to 10 ms
  EXPECT_NEAR(coupling.crossings[1].at, 30e-3, 1e-15);   // over 20 to 40 ms
  EXPECT_DOUBLE_EQ(coupling.crossings[1].from.age, 20e-3);
  EXPECT_DOUBLE_EQ(coupling.crossings[1].to.age, 40e-3);
  const ByAge error = only(sweep()).by_error;  // 10, 7.5, alike, not stable
  ASSERT_EQ(error.crossings.size(), 1U);
  EXPECT_EQ(error.crossings[0].from.label, "10 ms");
  EXPECT_EQ(error.crossings[0].to.label, "40 ms");
  EXPECT_TRUE(std::isnan(error.crossings[0].at));  // nothing to interpolate
}

TEST(Contest, AgesDecideTheOrderNotTheSweep) {
  std::vector<PointResult> turned = sweep();
  std::reverse(turned.begin(), turned.end());
  const ByAge a = only(sweep()).by_coupling, b = only(turned).by_coupling;
  ASSERT_EQ(b.crossings.size(), 2U);
  EXPECT_DOUBLE_EQ(a.crossings[0].at, b.crossings[0].at);
}

TEST(Contest, WhatIsNotThereFailedOrMissedItsTicksDoesNotCompete) {
  std::vector<PointResult> some = sweep();
  some.resize(6);
  some[2].failed = true;       // extrapolated at 5 ms
  some[5].kick_missed = 0.02;  // extrapolated at 10 ms: twice what is let pass
  some[5].largest_coupling = kNotMeasured;
  const Contests c = only(some);
  EXPECT_EQ(c.at[0].error_known, 2);
  EXPECT_EQ(c.at[0].least_error, Who{kCompensation});
  EXPECT_EQ(c.at[1].least_error, Who{kCompensation});
  EXPECT_TRUE(c.by_error.standings.empty());
  const std::string text = all_of(some);
  EXPECT_TRUE(says(text, "Did not run: extrapolated at 5 ms.")) << text;
  EXPECT_TRUE(says(text, "over 1 % of the ticks were missed: extrapolated at 10 ms.")) << text;
}

TEST(Statement, NamesWinnersMarginCrossingsAndFailures) {
  const std::string text = all_of(sweep());
  for (const char* part :
       {"Least force error: extrapolated at 5 ms, 10 ms; compensated and extrapolated alike at 20 "
        "ms; hold at 40 ms.",
        "Largest stable k_o: hold at 5 ms, 40 ms; extrapolated at 10 ms, 20 ms.",
        "leaves 0.50 (20 ms) to 0.90 (5 ms), 0.70 in the median: 10 to 50 % of the margin is lost; "
        "at 40 ms no k_o at all is stable with it",
        "0.1 to 0.4 N s/m with it, 2 to 8 without",
        "it wins up to 10.0 ms (10 ms: 7.50) and loses at 40.0 ms (40 ms: it is not stable); it "
        "changes somewhere from 10.0 ms to 40.0 ms; is even at 20 ms.",
        "it loses at 5.0 ms (5 ms: 0.50), wins from 10.0 ms (10 ms: 2.00) to 20.0 ms (20 ms: "
        "2.00) and loses at 40.0 ms (40 ms: 0.50); it changes at about 7.5 ms and at about 30.0 "
        "ms.",
        "compensation loses: distributed 10 to 50 % and all of it at 40 ms.",
        "has the least force error: distributed below 10.0...40.0 ms.",
        "has the largest stable coupling: distributed from 7.5 ms to 30.0 ms.",
        "not stable as the scene is: compensated at 40 ms; extrapolated at 40 ms. Within 10 % of "
        "the boundary: hold at 40 ms."})
    EXPECT_TRUE(says(text, part)) << part << "\n" << text;
}

TEST(Statement, OfSamplesOfTheSameAgeSaysNothingByAge) {
  std::vector<PointResult> all = sweep();
  for (PointResult& r : all) r.mean_age = 5e-3;
  const std::string text = all_of(all);
  for (const char* part :
       {"by delay (the samples are of much the same age).",
        "it wins at 10 ms (2.00) and 20 ms (2.00); loses at 5 ms (0.50) and 40 ms (0.50).",
        "has the largest stable coupling: distributed at 10 ms and 20 ms."})
    EXPECT_TRUE(says(text, part)) << part << "\n" << text;
  EXPECT_FALSE(says(text, "it changes")) << text;
}

TEST(Statement, ACouplingWithoutBoundIsNotCalledUnstable) {
  std::vector<PointResult> all = sweep();
  all[0].largest_coupling = std::numeric_limits<double>::infinity();  // hold at 5 ms
  const std::string text = all_of(all);
  EXPECT_TRUE(says(text, "it loses at 5.0 ms (5 ms: 0.00), wins from")) << text;
  EXPECT_EQ(contests(all).at(0).margin.nothing_at, std::vector<std::string>{"40 ms"});
}

TEST(Statement, OfOneReconstructionSaysThatNoneCanWinAndOfNothingNothing) {
  const std::string text = all_of({sweep()[0]});
  EXPECT_TRUE(says(text, "No two reconstructions are known at the same value")) << text;
  EXPECT_TRUE(says(text, "every session is stable")) << text;
  EXPECT_FALSE(says(text, "Least force error:")) << text;
  EXPECT_TRUE(statement({}).empty());
  PointResult own_style = sweep()[0];
  own_style.point.style = "";
  EXPECT_TRUE(contests({own_style}).empty());
}

TEST(Statement, SaysWhereNewtonsNameAnother) {
  std::vector<PointResult> all = sweep();
  for (SiteMeasures& site : all[1].measures.sites) site.force_error = 0.09;  // others: 2 and 0.1 N
  EXPECT_EQ(only(all).at[0].least_newton, Who{kCompensation});
  const std::string text = all_of(all);
  EXPECT_TRUE(says(text, "hold at 40 ms. (In newton compensated at 5 ms.)")) << text;
  EXPECT_FALSE(says(all_of(sweep()), "In newton"));
}

/// As sockets give it: nothing searched for, tries on both sides of the prediction.
PointResult tried(bool below_stable, bool above_stable) {
  PointResult r = result("hold", "5 ms", 5.0, 0.2, 4000.0);
  r.real = true;
  r.largest_coupling = kNotMeasured;
  for (BoundaryTry* t : {&r.below, &r.above}) t->done = t->stability.judged = true;
  r.below.stability.stable = below_stable;
  r.above.stability.stable = above_stable;
  r.below.ratio = 0.93;
  r.above.ratio = 1.05;
  return r;
}

TEST(ConfirmedCoupling, IsThePredictedOneWhereSocketsAreStableBelowAndNotAbove) {
  std::string why;
  EXPECT_DOUBLE_EQ(confirmed_coupling(tried(true, false), why), 4000.0);
  EXPECT_EQ(why, "");
  EXPECT_TRUE(std::isnan(confirmed_coupling(tried(true, true), why)));
  EXPECT_EQ(why, "stable at 1.1 times the prediction");
  EXPECT_TRUE(std::isnan(confirmed_coupling(tried(false, false), why)));
  EXPECT_EQ(why, "not stable at 0.9 times the prediction");

  PointResult r = tried(true, false);
  r.above.ratio = 1.1 * 1.3;  // its delays were others, beyond kSameNetwork
  EXPECT_TRUE(std::isnan(confirmed_coupling(r, why)));
  r = tried(true, false);
  r.below.missed_share = 0.011;
  EXPECT_TRUE(std::isnan(confirmed_coupling(r, why)));
  EXPECT_EQ(why, "ticks were missed");
  r = tried(true, false);
  r.above.done = false;
  EXPECT_TRUE(std::isnan(confirmed_coupling(r, why)));
}

TEST(ConfirmedCoupling, OfNoneIsConfirmedByASceneThatIsNotStable) {
  PointResult r = tried(true, false);
  r.prediction.largest_coupling = 0.0;
  r.below = r.above = {};
  std::string why;
  EXPECT_TRUE(std::isnan(confirmed_coupling(r, why)));
  r.measures.stability.stable = false;
  EXPECT_EQ(confirmed_coupling(r, why), 0.0);
}

TEST(Statement, OnSocketsSaysWhereTheLargestCouplingIsFromAndWhatWasNotConfirmed) {
  PointResult other = tried(true, true);
  other.point.style = "compensated";
  const std::string text = all_of({tried(true, false), other});
  EXPECT_TRUE(says(text, "Largest couplings are not searched for on sockets")) << text;
  EXPECT_TRUE(says(text,
                   "not counted above: compensated at 5 ms (stable at 1.1 times the "
                   "prediction)."))
      << text;
  EXPECT_TRUE(says(text, "not compared (too few are known) at 5 ms")) << text;
  EXPECT_FALSE(says(all_of(sweep()), "not searched for on sockets"));
}

}  // namespace
}  // namespace tandem::harness
