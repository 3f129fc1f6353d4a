#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "core/random.h"
#include "core/trigonometry.h"

namespace tandem::core {
namespace {

double ulps(double value, long double exact) {
  const double rounded = std::fabs(static_cast<double>(exact));
  const double ulp = std::nextafter(rounded, 2.0) - rounded;
  return static_cast<double>(std::fabs(static_cast<long double>(value) - exact)) / ulp;
}

TEST(PlaneTrigonometry, AgreesWithLongDoubleBelowOneUnitInTheLastPlace) {
  Random random(7);
  double worst = 0.0;
  for (int i = 0; i < 400000; ++i) {
    const double range = i % 4 == 0 ? 1e5 : (i % 4 == 1 ? 100.0 : (i % 4 == 2 ? 1.0 : 1e-4));
    const double angle = random.uniform(-range, range);
    const SinCos got = sin_cos(angle);
    worst = std::fmax(worst, ulps(got.sin, std::sin(static_cast<long double>(angle))));
    worst = std::fmax(worst, ulps(got.cos, std::cos(static_cast<long double>(angle))));
  }
  EXPECT_LT(worst, 1.0);  // fdlibm's bound for its kernels with the tail
}

TEST(PlaneTrigonometry, HoldsNextToMultiplesOfAQuarterTurn) {
  double worst = 0.0;
  for (int n = -60000; n <= 60000; n += 7) {
    const double near = n * 1.57079632679489661923;
    for (const double angle : {near, std::nextafter(near, 1e9), std::nextafter(near, -1e9)}) {
      const SinCos got = sin_cos(angle);
      worst = std::fmax(worst, ulps(got.sin, std::sin(static_cast<long double>(angle))));
      worst = std::fmax(worst, ulps(got.cos, std::cos(static_cast<long double>(angle))));
    }
  }
  // Cancellation at the zeros leaves 119 bits of pi/2, minus 17 of n and 60 of closeness.
  EXPECT_LT(worst, 1.0);
}

TEST(PlaneTrigonometry, IsExactAtZeroAndNotFiniteForWhatIsNot) {
  EXPECT_EQ(sin_cos(0.0).sin, 0.0);
  EXPECT_EQ(sin_cos(0.0).cos, 1.0);
  EXPECT_FALSE(std::isfinite(sin_cos(std::numeric_limits<double>::infinity()).sin));
  EXPECT_FALSE(std::isfinite(sin_cos(std::numeric_limits<double>::quiet_NaN()).cos));
}

}  // namespace
}  // namespace tandem::core
