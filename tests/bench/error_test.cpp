#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "bench/error_reference.h"
#include "bench/error_table.h"
#include "bench/error_tandem.h"

namespace tandem::bench {
namespace {

int index_of_point(Case which, double stiffness = 0.0) {
  for (std::size_t i = 0; i < kErrorPoints.size(); ++i)
    if (kErrorPoints[i].which == which && kErrorPoints[i].stiffness == stiffness)
      return static_cast<int>(i);
  ADD_FAILURE() << "no such point";
  return 0;
}
const ErrorPoint& point_at(Case which, double stiffness = 0.0) {
  return kErrorPoints[static_cast<std::size_t>(index_of_point(which, stiffness))];
}
double time_of(int sample) { return (sample + 1.0) / kGridRate; }

// The reference itself, against closed forms worked by hand.

TEST(ErrorReference, TwoMassesSwingAboutTheirCentreOfMass) {
  for (const double k : {1000.0, 30000.0}) {
    const ErrorPoint& point = point_at(Case::kMasses, k);
    const std::vector<double> truth = error_reference(point).ideal;
    const double mu = kHandMass * kObjectMass / (kHandMass + kObjectMass);
    const double sigma = point.damping / (2 * mu), w = std::sqrt(k / mu - sigma * sigma);
    const double centre = kThrown * kObjectMass / (kHandMass + kObjectMass);
    for (int i = 0; i < sample_count(point); ++i) {
      const double t = time_of(i), apart = kThrown / w * std::exp(-sigma * t) * std::sin(w * t);
      // Rounding of sums of 0.02 m.
      EXPECT_NEAR(truth[4 * i], centre * t - kObjectMass / (kHandMass + kObjectMass) * apart,
                  1e-16);
      EXPECT_NEAR(truth[4 * i + 2], centre * t + kHandMass / (kHandMass + kObjectMass) * apart,
                  1e-16);
    }
  }
}

TEST(ErrorReference, TheWallIsLeftWhereItsForceIsZero) {
  for (const double k : {1000.0, 10000.0}) {
    const ErrorPoint& point = point_at(Case::kWall, k);
    const double sigma = point.damping / (2 * kObjectMass);
    const double w = std::sqrt(k / kObjectMass - sigma * sigma);
    const double t =
        (std::numbers::pi - std::atan(point.damping * w / (k - point.damping * sigma))) / w;
    const double kept = std::exp(-sigma * t) * (std::cos(w * t) - sigma / w * std::sin(w * t));
    EXPECT_NEAR(rebound(point), -kept, 1e-13);  // rounding of a phase of pi
  }
}

TEST(ErrorReference, TheFirstSlipOfRabinowiczEndsWhereTheSwingTurns) {
  const ErrorPoint& point = point_at(Case::kStickSlip, 30000.0);
  const std::vector<double> truth = error_reference(point).ideal;
  const double w = std::sqrt(kDrawSpring / kHandMass);
  const double away = kSticks * kNormalForce / (kDrawSpring * kDrawSpeed);  // 0.5 s
  const double A = (kSticks - kSlips) * kNormalForce / kDrawSpring;
  const double lasts = (2 * std::numbers::pi - 2 * std::atan(A * w / kDrawSpeed)) / w;
  const double rest = kDrawSpeed * (away + lasts) - kSlips * kNormalForce / kDrawSpring + A;
  EXPECT_EQ(truth[2 * static_cast<std::size_t>(0.49 * kGridRate)], 0.0);
  for (const double t : {0.65, 0.8})
    EXPECT_NEAR(truth[2 * static_cast<std::size_t>(t * kGridRate)], rest, 1e-15) << t;
}

TEST(ErrorReference, TheSpinningBodyKeepsMomentumAndEnergyAndDoesNotDependOnTheStep) {
  const ErrorPoint& point = point_at(Case::kSpin);
  const std::vector<double> truth = error_reference(point).ideal;
  const std::vector<double> coarse = error_reference(point, kSpinSteps / 4).ideal;
  // (omega h)^4 of the coarse one is 2e-14; a fourth-order error of it would show as 1/256 here.
  EXPECT_LT(error_of(point, coarse, truth), 2e-14);
  EXPECT_LT(energy_drift(point, coarse, truth), 1e-14);
}

TEST(ErrorReference, WhatBlewUpIsInfinitelyFar) {
  const ErrorPoint& point = point_at(Case::kWall, 1000.0);
  std::vector<double> samples = error_reference(point).ideal;
  const std::vector<double> truth = samples;
  EXPECT_EQ(error_of(point, samples, truth), 0.0);
  samples[4] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(std::isinf(error_of(point, samples, truth)));
  samples.resize(3);
  EXPECT_TRUE(std::isinf(error_of(point, samples, truth)));
}

// Tandem's laws in their loop.

double error_at(const ErrorPoint& point, const char* scheme, int hz) {
  return error_of(point, run_tandem(point, {scheme, false, true}, hz).samples,
                  error_reference(point).ideal);
}

/// Between 4096 and 16384 Hz, two halvings on end: no accident of one step.
double order(const ErrorPoint& point, const char* scheme) {
  return std::log2(error_at(point, scheme, 4096) / error_at(point, scheme, 16384)) / 2.0;
}

// Errors here are far above rounding and steps far below the time constants, so the observed order
// leaves the theoretical one by the next term only, some k T / b = 1 % of it.
constexpr double kOrder = 0.05;

TEST(ErrorOrder, HeldForcesConvergeInFirstOrderAndTheExactCouplerInSecond) {
  for (const Case which : {Case::kMasses, Case::kHands})
    for (const double k : {1000.0, 3000.0}) {
      const ErrorPoint& point = point_at(which, k);
      for (const char* scheme : {"zero_order_hold", "semi_implicit_euler", "explicit_euler"})
        EXPECT_NEAR(order(point, scheme), 1.0, kOrder) << point.name << " " << k << " " << scheme;
      EXPECT_NEAR(order(point, "exact_coupler"), 2.0, kOrder) << point.name << " " << k;
    }
}

TEST(ErrorOrder, FreeRotationConvergesInSecondOrder) {
  for (const char* scheme : {"zero_order_hold", "semi_implicit_euler", "explicit_euler"})
    EXPECT_NEAR(order(point_at(Case::kSpin), scheme), 2.0, kOrder) << scheme;
}

TEST(ErrorOrder, ASlidingBoxStopsExactlyUnderZeroOrderHoldAndInFirstOrderOtherwise) {
  const ErrorPoint& point = point_at(Case::kSlide);
  for (const int hz : {256, 1024, 16384})
    EXPECT_LT(error_at(point, "zero_order_hold", hz), 1e-14)
        << hz;  // rounding of 4096 sums of 0.04 m
  for (const char* scheme : {"semi_implicit_euler", "explicit_euler"})
    EXPECT_NEAR(order(point, scheme), 1.0, kOrder) << scheme;
}

TEST(ErrorOrder, AWallMetWithinTheTickIsFarNearerThanItsForceHeld) {
  // Its damper is of first order with a constant of b T / m = 1 % of the way damping takes. The
  // phase at which the tick meets the wall changes with the rate, and the error by some factor:
  // sixteen times shorter steps are 16.
  for (const double k : {1000.0, 3000.0, 10000.0, 30000.0}) {
    const ErrorPoint& point = point_at(Case::kWall, k);
    const double coarse = error_at(point, "zero_order_hold", 1024);
    EXPECT_LT(coarse, 1e-4) << k;
    EXPECT_GT(coarse / error_at(point, "zero_order_hold", 16384), 8.0) << k;
    EXPECT_GT(error_at(point, "explicit_euler", 1024), 20.0 * coarse) << k;
  }
}

TEST(ErrorOrder, StickSlipConvergesInFirstOrderToTheCourseOfItsOwnLaw) {
  const ErrorPoint& point = point_at(Case::kStickSlip, 3000.0);
  const ErrorReference truth = error_reference(point);
  const auto error = [&](int hz) {
    return error_of(point, run_tandem(point, {"contact_law", true, true}, hz).samples, truth.law);
  };
  // Events fall anywhere in a tick: 4 halvings, some factor about 16.
  EXPECT_GT(error(1024) / error(16384), 8.0);
}

TEST(ErrorOrder, ZeroOrderHoldIsTheMatrixExponentialOfTheWholeHeldNetwork) {
  for (const Case which : {Case::kMasses, Case::kHands})
    for (const double k : {300.0, 10000.0})
      for (const int hz : {1024, 16384}) {
        const ErrorPoint& point = point_at(which, k);
        const auto samples = run_tandem(point, {"zero_order_hold", true, true}, hz).samples;
        // Rounding of 4096 steps of 0.02 m.
        EXPECT_LT(error_of(point, samples, law_course(point, {}, hz)), 1e-14)
            << point.name << " " << k << " " << hz;
      }
}

// Tables worked by hand.

ErrorRow row(const char* engine, double ns, double error, bool is_default = true) {
  ErrorRow out;
  out.engine = out.setting = engine;
  out.is_default = is_default;
  out.ns_per_s = ns;
  out.error = error;
  return out;
}

TEST(ErrorTable, SpeedupIsOverTheLeastTimeThatKeepsThePeersError) {
  const std::vector<ErrorRow> rows{row("tandem", 10, 1e-3), row("tandem", 40, 1e-5),
                                   row("peer", 100, 1e-3),  row("peer", 200, 5e-4),
                                   row("peer", 300, 2e-3),  row("peer", 1000, 1e-6)};
  const CaseResult r = compare_case(rows, 0, 1.0, true);
  ASSERT_EQ(r.reached.size(), 2U);  // 300 ns for 2e-3 is beaten by another peer's point
  ASSERT_TRUE(r.least);
  EXPECT_EQ(r.least->speedup(), 200.0 / 40.0);
  EXPECT_EQ(r.least->error, 5e-4);
  ASSERT_EQ(r.unreached.size(), 1U);
  EXPECT_EQ(r.unreached[0].error, 1e-6);
  EXPECT_EQ(r.least_error, 1e-5);
}

TEST(ErrorTable, UselessErrorsAndOtherSchemesDoNotCount) {
  const std::vector<ErrorRow> rows{row("tandem", 10, 1e-3), row("tandem", 1, 1e-4, false),
                                   row("peer", 100, 1e-3), row("peer", 1, 0.06),
                                   row("peer", 1, std::numeric_limits<double>::infinity())};
  EXPECT_EQ(compare_case(rows, 0, 1.0, true).least->speedup(), 10.0);
  EXPECT_EQ(compare_case(rows, 0, 1.0, false).least->speedup(), 100.0);
}

}  // namespace
}  // namespace tandem::bench
