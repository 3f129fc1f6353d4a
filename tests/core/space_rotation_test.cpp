#include "core/space_rotation.h"

#include <array>
#include <cmath>

#include <gtest/gtest.h>

#include "core/components.h"
#include "core/random.h"

// Rotations against the C library and against textbook formulas written out here.
namespace tandem::core {
namespace {

constexpr double kPi = 3.14159265358979323846;

Vec3 random_direction(Random& random) {
  const Vec3 a{random.normal(), random.normal(), random.normal()};
  return a * (1.0 / std::sqrt(inner(a, a)));
}

double length(const Vec3& a) { return std::sqrt(inner(a, a)); }

TEST(SpaceRotation, TheArcTangentAgreesWithTheLibraryOverTheWholeQuarter) {
  for (int i = 0; i <= 100000; ++i) {
    const double angle = kPi / 2 * i / 100000;
    const double y = std::sin(angle), x = std::fabs(std::cos(angle)),
                 scale = std::ldexp(1.0, i % 40);
    const double expected = std::atan2(y, x);
    // Two units in the last place: one of the polynomial, one of the quotient.
    EXPECT_NEAR(arctangent(y * scale, x * scale), expected, 4.5e-16 * expected) << angle;
  }
  EXPECT_EQ(arctangent(0.0, 3.0), 0.0);
  EXPECT_EQ(arctangent(2.0, 0.0), std::atan2(2.0, 0.0));
  EXPECT_NEAR(arctangent(1e-300, 1.0), 1e-300, 1e-315);
}

TEST(SpaceRotation, TheQuaternionOfARotationVectorHasHalfTheAngle) {
  Random random(3);
  for (int i = 0; i < 20000; ++i) {
    const Vec3 axis = random_direction(random);
    const double angle = std::exp(-30.0 * random.uniform()) * 6.0;  // from 1e-12 up, all branches
    const Quat q = rotation_by(axis * angle);
    // Rounding of axis and product moves the angle itself by 2e-16 of it.
    EXPECT_NEAR(q.w, std::cos(angle / 2), 2e-16 + 2e-16 * angle);
    const double sine = std::sin(angle / 2);
    EXPECT_NEAR(q.x, axis.x * sine, 3e-16 * (std::fabs(sine) + angle));
    EXPECT_NEAR(q.z, axis.z * sine, 3e-16 * (std::fabs(sine) + angle));
  }
  const Quat none = rotation_by(Vec3{0.0});
  EXPECT_TRUE(none.w == 1.0 && none.x == 0.0 && none.y == 0.0 && none.z == 0.0);
}

TEST(SpaceRotation, SeriesAndSineMeetWithoutAJump) {
  // The branch is at 0.2 rad; both sides must lie on the same curve to rounding.
  for (const double angle : {0.2 * (1 - 1e-15), 0.2, 0.2 * (1 + 1e-15)}) {
    const Quat q = rotation_by({angle, 0.0, 0.0});
    EXPECT_NEAR(q.w, std::cos(angle / 2), 1.2e-16);
    EXPECT_NEAR(q.x, std::sin(angle / 2), 3e-17);
  }
}

TEST(SpaceRotation, TheRotationVectorUndoesTheQuaternionUpToHalfATurn) {
  Random random(4);
  for (int i = 0; i < 20000; ++i) {
    const double angle = (i % 2 ? kPi : std::exp(-40.0 * random.uniform())) * random.uniform();
    const Vec3 r = random_direction(random) * angle;
    const Quat q = rotation_by(r);
    // Near half a turn w is the small number: its rounding of 1e-16 is the angle's.
    const double scale = std::exp(4 * random.uniform()) * (i % 3 ? 1.0 : -1.0);
    const Vec3 back = rotation_vector({q.w * scale, q.x * scale, q.y * scale, q.z * scale});
    EXPECT_LT(length(back - r), 2e-15 * angle + 1e-300) << angle;
  }
}

TEST(SpaceRotation, TheRotationVectorGoesTheShortestWay) {
  const Vec3 back = rotation_vector(rotation_by({0.0, 1.5 * kPi, 0.0}));
  EXPECT_NEAR(back.y, -0.5 * kPi, 1e-15);
  EXPECT_NEAR(length(rotation_vector({0.0, 0.6, 0.0, 0.8})), kPi, 1e-15);  // exactly half a turn
  EXPECT_EQ(length(rotation_vector({0.0, 0.0, 0.0, 0.0})), 0.0);           // no rotation at all
  EXPECT_EQ(length(rotation_vector({-2.0, 0.0, 0.0, 0.0})), 0.0);
}

TEST(SpaceRotation, TheAxesAreThoseOfRodriguesFormula) {
  Random random(5);
  for (int i = 0; i < 2000; ++i) {
    const Vec3 k = random_direction(random), a = random_direction(random);
    const double angle = kPi * (2 * random.uniform() - 1);
    const Vec3 expected = a * std::cos(angle) + glm::cross(k, a) * std::sin(angle) +
                          k * (glm::dot(k, a) * (1 - std::cos(angle)));
    const Quat q = rotation_by(k * angle);
    const double s = 0.5 + random.uniform();  // a length that is not 1 must not matter
    const Axes axes = axes_of({q.w * s, q.x * s, q.y * s, q.z * s});
    EXPECT_LT(length(axes.to_world(a) - expected), 2e-15);
    EXPECT_LT(length(axes.to_body(axes.to_world(a)) - a), 2e-15);
  }
}

TEST(SpaceRotation, TheWayBetweenTwoOrientationsIsMeasuredInTheWorld) {
  const Quat from = rotation_by({0.3, -0.8, 0.2});
  const Vec3 r{0.1, 0.7, -0.4};
  EXPECT_LT(length(rotation_between(from, rotation_by(r) * from) - r), 1e-15);
}

}  // namespace
}  // namespace tandem::core
