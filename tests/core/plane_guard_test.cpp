#include <cmath>
#include <limits>
#include <type_traits>

#include <gtest/gtest.h>

#include "core/contact_state.h"
#include "core/force_guard.h"
#include "core/random.h"
#include "core/velocity_estimate.h"

namespace tandem::core {
namespace {

constexpr double kT = 1.0 / 1024.0;
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

static_assert(std::is_trivially_copyable_v<ForceGuard<Vec3>>);
static_assert(std::is_trivially_copyable_v<VelocityEstimate<Vec2>>);

TEST(PlaneGuard, WhatIsNotFiniteBecomesZeroAndAFaultBit) {
  for (const double bad : {kInfinity, -kInfinity, kNan}) {
    Fault faults = Fault::kNone;
    EXPECT_EQ(finite_or_zero(bad, faults), 0.0);
    EXPECT_TRUE(has(faults, Fault::kNotFinite));
    faults = Fault::kNone;
    EXPECT_EQ(finite_or_zero(Vec3{1.0, bad, 2.0}, faults), Vec3(0.0));
    EXPECT_TRUE(has(faults, Fault::kNotFinite));
  }
  Fault faults = Fault::kNone;
  EXPECT_EQ(finite_or_zero(Vec2{1.0, -2.0}, faults), Vec2(1.0, -2.0));
  EXPECT_EQ(faults, Fault::kNone);
}

TEST(PlaneGuard, SaturationKeepsTheDirection) {
  ForceGuard<Vec2> guard(5.0, 0.0, kT);
  Fault faults = Fault::kNone;
  const Vec2 f = guard.pass({30.0, 40.0}, faults);
  EXPECT_NEAR(f.x, 3.0, 1e-12);
  EXPECT_NEAR(f.y, 4.0, 1e-12);
  EXPECT_EQ(faults, Fault::kForceSaturated);
}

TEST(PlaneGuard, HugeFiniteForcesAreCutAndNotOverflowed) {
  ForceGuard<Vec3> guard(5.0, 0.0, kT);
  Fault faults = Fault::kNone;
  const Vec3 f = guard.pass({3e200, 0.0, -4e200}, faults);
  EXPECT_NEAR(f.x, 3.0, 1e-12);
  EXPECT_NEAR(f.z, -4.0, 1e-12);
  EXPECT_EQ(faults, Fault::kForceSaturated);
}

TEST(PlaneGuard, SlewLimitsTheFirstCommandFromZeroAndEveryNext) {
  ForceGuard<double> guard(10.0, 1024.0, kT);  // 1 N a tick
  Fault faults = Fault::kNone;
  EXPECT_NEAR(guard.pass(3.5, faults), 1.0, 1e-12);
  EXPECT_NEAR(guard.pass(3.5, faults), 2.0, 1e-12);
  EXPECT_NEAR(guard.pass(3.5, faults), 3.0, 1e-12);
  EXPECT_TRUE(has(faults, Fault::kForceSlewed));
  faults = Fault::kNone;
  EXPECT_NEAR(guard.pass(3.5, faults), 3.5, 1e-12);
  EXPECT_EQ(faults, Fault::kNone);
  guard.reset();
  EXPECT_NEAR(guard.pass(-9.0, faults), -1.0, 1e-12);
}

TEST(PlaneGuard, EveryOutputIsFiniteBelowTheLimitAndBelowTheSlewWhateverComesIn) {
  Random random(9);
  ForceGuard<Vec3> guard(7.0, 3000.0, kT);
  Vec3 last{0.0};
  for (int k = 0; k < 200000; ++k) {
    Vec3 wanted{random.normal() * 20, random.normal() * 20, random.normal() * 20};
    const double dice = random.uniform();
    if (dice < 0.02) wanted.y = kNan;
    if (dice > 0.98) wanted.x = -kInfinity;
    if (dice > 0.5 && dice < 0.52) wanted *= 1e250;
    Fault faults = Fault::kNone;
    const Vec3 f = guard.pass(wanted, faults);
    ASSERT_TRUE(is_finite(f));
    ASSERT_LE(std::sqrt(inner(f, f)), 7.0);
    // The subtraction here rounds at the size of the force: 7 * 2^-52 a coordinate.
    ASSERT_LE(std::sqrt(inner(f - last, f - last)), 3000.0 * kT + 1e-14);
    last = f;
  }
}

TEST(PlaneGuard, VelocityEstimateStartsAtZeroAndFollowsTheExactLowPass) {
  const double cutoff = 30.0, p0 = 0.4, speed = 0.2;
  VelocityEstimate<double> estimate(cutoff, kT);
  EXPECT_EQ(estimate.update(p0), 0.0);
  for (int k = 1; k < 200; ++k) {
    const double v = estimate.update(p0 + speed * k * kT);
    // First-order step response at t = k T.
    EXPECT_NEAR(v, speed * (1 - std::exp(-2 * 3.14159265358979323846 * cutoff * k * kT)), 1e-11);
  }
}

TEST(PlaneGuard, VelocityEstimateOfAQuantisedRestIsBoundedByOneFilteredQuantum) {
  const double quantum = 1e-5, cutoff = 30.0;
  VelocityEstimate<Vec2> estimate(cutoff, kT);
  const double gain = 1 - std::exp(-2 * 3.14159265358979323846 * cutoff * kT);
  for (int k = 0; k < 2000; ++k) {
    const Vec2 v = estimate.update({k % 2 ? quantum : 0.0, 0.0});
    EXPECT_LE(std::fabs(v.x), gain * quantum / kT * (1 + 1e-12));
    EXPECT_EQ(v.y, 0.0);
  }
}

TEST(PlaneGuard, ContactBitsKeepStateAndSideOfEightContacts) {
  std::uint32_t bits = 0;
  for (int i = 0; i < 8; ++i) bits = with_contact(bits, i, static_cast<ContactState>(i % 4), i / 2);
  for (int i = 0; i < 8; ++i) {
    EXPECT_EQ(contact_state(bits, i), static_cast<ContactState>(i % 4));
    EXPECT_EQ(contact_side(bits, i), i / 2);
  }
  EXPECT_EQ(with_contact(bits, 8, ContactState::kSlide), bits);
  // Two objects touched by one finger stay apart; the first touched one is the finger's.
  const std::uint32_t word = contact_word(with_contact(0, 0, ContactState::kPreSlide, 1), 1, 2) |
                             contact_word(with_contact(0, 0, ContactState::kSlide, 3), 0, 3);
  EXPECT_EQ(contact_state(word, 6), ContactState::kPreSlide);
  EXPECT_EQ(contact_side(word, 6), 1);
  EXPECT_EQ(contact_of_finger(word, 2), 6);
  EXPECT_EQ(contact_of_finger(word, 3), 3);
  EXPECT_EQ(contact_state(word, contact_of_finger(word, 1)), ContactState::kFree);
  EXPECT_EQ(contact_word(1u, 2, 0), 0u);  // no room for a third object
  bits = with_contact(bits, 3, ContactState::kFree);
  EXPECT_EQ(contact_state(bits, 3), ContactState::kFree);
  EXPECT_EQ(contact_state(bits, 2), ContactState::kPreSlide);
}

}  // namespace
}  // namespace tandem::core
