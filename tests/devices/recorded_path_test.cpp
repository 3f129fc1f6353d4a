#include "devices/recorded_path.h"

#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>

namespace tandem::devices {
namespace {

std::vector<PathSample> sampled(double (*x)(double), double length, double step) {
  std::vector<PathSample> samples;
  for (int i = 0; i * step <= length + 1e-12; ++i)
    samples.push_back({i * step, {x(i * step), 0, 0}});
  return samples;
}

double parabola(double t) { return 0.3 - 0.2 * t + 0.7 * t * t; }
double swing(double t) { return 0.05 * std::sin(6.0 * t); }

// Three-point slopes are exact for a parabola, and a cubic with exact ends is the parabola itself;
// only the two outer pieces, which have secants, differ.
TEST(RecordedPath, CubicIsExactOnAParabolaEvenWithUnevenSteps) {
  std::vector<PathSample> samples;
  for (const double t : {0.0, 0.1, 0.15, 0.4, 0.42, 0.7, 0.9, 1.0}) {
    samples.push_back({t, {parabola(t), 0, 0}});
  }
  const RecordedPath path(samples, Interpolation::kCubic, PathEnd::kHold, 0.0);
  for (double t = 0.1; t <= 0.9; t += 0.013) {
    EXPECT_NEAR(path.at(t).position.x, parabola(t), 1e-14) << t;     // rounding
    EXPECT_NEAR(path.at(t).velocity.x, -0.2 + 1.4 * t, 1e-12) << t;  // divided by steps of 0.02
  }
}

// Error of the cubic with second-order slopes is of third order in the step, plus a fourth.
TEST(RecordedPath, CubicConvergesAtLeastWithTheThirdPowerOfTheStep) {
  const auto error = [](double step) {
    const RecordedPath path(sampled(swing, 1.0, step), Interpolation::kCubic, PathEnd::kHold, 0.0);
    double worst = 0.0;
    for (double t = 0.1; t < 0.9; t += 0.0007) {
      worst = std::max(worst, std::abs(path.at(t).position.x - swing(t)));
    }
    return worst;
  };
  EXPECT_GT(error(0.02) / error(0.01), 7.0);  // 8 for the third power, less end effects
  EXPECT_LT(error(0.01), 1e-6);
}

TEST(RecordedPath, PassesThroughEverySample) {
  const auto samples = sampled(swing, 1.0, 0.01);
  for (const auto kind : {Interpolation::kCubic, Interpolation::kLinear}) {
    const RecordedPath path(samples, kind, PathEnd::kHold, 0.0);
    for (const PathSample& s : samples) {
      EXPECT_NEAR(path.at(s.time).position.x, s.position.x, 1e-16);
    }
  }
}

TEST(RecordedPath, LinearIsTheStraightLineBetweenSamples) {
  const RecordedPath path({{5.0, {0, 1, 0}}, {5.5, {0, 2, 0}}, {6.5, {0, 0, 3}}},
                          Interpolation::kLinear, PathEnd::kHold, 0.0);
  EXPECT_DOUBLE_EQ(path.length(), 1.5);  // time starts at the first sample
  EXPECT_DOUBLE_EQ(path.at(0.25).position.y, 1.5);
  EXPECT_DOUBLE_EQ(path.at(0.25).velocity.y, 2.0);
  EXPECT_DOUBLE_EQ(path.at(1.0).position.z, 1.5);
  EXPECT_DOUBLE_EQ(path.at(1.0).velocity.y, -2.0);
}

TEST(RecordedPath, RestsBeforeTheStartAndAfterTheEnd) {
  const RecordedPath path(sampled(parabola, 1.0, 0.1), Interpolation::kCubic, PathEnd::kHold, 0.0);
  EXPECT_EQ(path.at(-3.0).position.x, parabola(0.0));
  EXPECT_EQ(path.at(-3.0).velocity.x, 0.0);
  EXPECT_NEAR(path.at(50.0).position.x, parabola(1.0), 1e-15);
  EXPECT_EQ(path.at(50.0).velocity.x, 0.0);
  EXPECT_EQ(path.at(std::numeric_limits<double>::quiet_NaN()).position.x, parabola(0.0));
}

// A ramp jumps back at the end of every lap; the seam spreads that over 0.2 s.
TEST(RecordedPath, ALoopHasNoJumpInValueOrSlopeOverTheSeam) {
  const RecordedPath path(sampled([](double t) { return t; }, 2.0, 0.01), Interpolation::kCubic,
                          PathEnd::kLoop, 0.2);
  EXPECT_DOUBLE_EQ(path.lap(), 1.8);
  const double step = 1e-5;
  // The blend falls by 1.8 m in 0.2 s, steepest 1.5 times the mean: |v| <= 13.5 + 1, and the slope
  // of that is at most 6 / 0.2^2 times 1.8 m.
  for (double t = 0.0; t < 6.0; t += step) {
    const auto a = path.at(t), b = path.at(t + step);
    ASSERT_LE(std::abs(b.position.x - a.position.x), 14.6 * step) << t;
    ASSERT_LE(std::abs(b.velocity.x - a.velocity.x), 300.0 * step) << t;
    ASSERT_NEAR((b.position.x - a.position.x) / step, a.velocity.x, 300.0 * step) << t;
  }
  EXPECT_NEAR(path.at(0.0).position.x, 0.0, 1e-15);  // the first lap starts unfaded
}

// The lap is not a whole number of slots, so its phase would show any drift. 20 days at 1024 Hz:
// t is 1.7e6 s, whose last bit is 2.3e-10 s; the path moves at up to 0.3 m/s.
TEST(RecordedPath, ALoopDoesNotDriftInTwentyDays) {
  const RecordedPath path(sampled(swing, 1.7, 0.0005), Interpolation::kCubic, PathEnd::kLoop, 0.1);
  const double lap = path.lap();
  const std::int64_t laps = 1'000'000;
  for (const double phase : {0.3, 0.7, 1.1, 1.5}) {
    const double t = phase + static_cast<double>(laps) * lap;
    EXPECT_NEAR(path.at(t).position.x, swing(phase), 1e-9) << phase;
  }
}

TEST(RecordedPath, RefusesWhatIsNoPath) {
  const auto make = [](std::vector<PathSample> samples, double seam = 0.0) {
    return RecordedPath(std::move(samples), Interpolation::kCubic, PathEnd::kLoop, seam);
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(make({}), std::invalid_argument);
  EXPECT_THROW(make({{0, {0, 0, 0}}}), std::invalid_argument);
  EXPECT_THROW(make({{0, {0, 0, 0}}, {1, {0, nan, 0}}}), std::invalid_argument);
  EXPECT_THROW(make({{0, {0, 0, 0}}, {nan, {0, 0, 0}}}), std::invalid_argument);
  EXPECT_THROW(make({{0, {0, 0, 0}}, {1, {0, 0, 0}}}, 0.6), std::invalid_argument);
  EXPECT_THROW(make({{0, {0, 0, 0}}, {1, {0, 0, 0}}}, -0.1), std::invalid_argument);
  try {
    make({{0, {0, 0, 0}}, {1, {0, 0, 0}}, {1, {0, 0, 0}}});
    FAIL() << "must throw";
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("sample 3"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace tandem::devices
