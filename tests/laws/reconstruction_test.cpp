#include "core/reconstruction.h"

#include <cmath>

#include <gtest/gtest.h>

namespace tandem::core {
namespace {

TEST(Reconstruction, HoldNeverMovesTheSample) {
  const Advance a = advance_by_age({ReconstructionKind::kHold, 0.05, 0.03}, 0.2);
  EXPECT_EQ(a.time, 0.0);
  EXPECT_EQ(a.keep, 1.0);
}

// age_eff = A + tau (1 - e^-(age - A)/tau), and velocity is its derivative: checked by difference.
TEST(Reconstruction, ExtrapolationIsCappedAndItsVelocityIsTheDerivativeOfItsWay) {
  const ReconstructionParameters p{ReconstructionKind::kExtrapolate, 0.05, 0.03};
  EXPECT_EQ(advance_by_age(p, 0.0).time, 0.0);
  EXPECT_EQ(advance_by_age(p, 0.03).time, 0.03);
  EXPECT_EQ(advance_by_age(p, 0.03).keep, 1.0);
  for (double age = 0.051; age < 0.5; age += 0.013) {
    const double expected = 0.05 + 0.03 * (1.0 - std::exp(-(age - 0.05) / 0.03));
    EXPECT_NEAR(advance_by_age(p, age).time, expected, 1e-15);
    const double h = 1e-6;
    const double slope =
        (advance_by_age(p, age + h).time - advance_by_age(p, age - h).time) / (2 * h);
    EXPECT_NEAR(advance_by_age(p, age).keep, slope, 1e-8);  // central difference, h^2 and 1e-16/h
  }
  EXPECT_NEAR(advance_by_age(p, 100.0).time, 0.08, 1e-15);
  EXPECT_NEAR(advance_by_age(p, 100.0).keep, 0.0, 1e-15);
}

TEST(Reconstruction, AnAgeThatIsNotANumberIsNoAge) {
  const ReconstructionParameters p{ReconstructionKind::kExtrapolate, 0.05, 0.03};
  EXPECT_EQ(advance_by_age(p, std::nan("")).time, 0.0);
  EXPECT_EQ(advance_by_age(p, -1.0).time, 0.0);
}

TEST(Elementary, LogarithmAndExponentialAgreeWithLongDouble) {
  for (double x = 1e-300; x < 1e300; x *= 1.37) {
    const long double exact = std::log(static_cast<long double>(x));
    EXPECT_NEAR(natural_log(x), static_cast<double>(exact),
                4e-16 * std::abs(static_cast<double>(exact)) + 2e-16);
  }
  for (double x = -690.0; x < 690.0; x += 0.37) {
    const double exact = static_cast<double>(std::exp(static_cast<long double>(x)));
    EXPECT_NEAR(natural_exp(x) / exact, 1.0, 1e-15);
  }
}

}  // namespace
}  // namespace tandem::core
