#include <cmath>
#include <type_traits>

#include <gtest/gtest.h>

#include "core/contact_law.h"
#include "core/random.h"

namespace tandem::core {
namespace {

constexpr double kT = 1.0 / 1024.0;

ContactGains grasp_gains() {
  ContactGains gains;
  gains.normal = {800.0, 3.0};
  gains.tangential = {1200.0, 10.0};
  gains.friction = {0.6, 0.5, 0.005};
  return gains;
}

static_assert(std::is_trivially_copyable_v<ContactMemory<double>>);
static_assert(std::is_trivially_copyable_v<ContactMemory<Vec2>>);

TEST(PlaneContactLaw, NormalForceIsThePenaltyAndNeverPulls) {
  ContactMemory<double> memory;
  const ContactGains gains = grasp_gains();
  EXPECT_NEAR(press(memory, gains, {0.002, -0.1, 0.0, 0.0}, kT).normal, 800 * 0.002 + 3 * 0.1,
              1e-12);
  EXPECT_EQ(press(memory, gains, {0.002, 10.0, 0.0, 0.0}, kT).normal, 0.0);
  EXPECT_EQ(press(memory, gains, {0.0, -0.1, 0.0, 0.0}, kT).normal, 0.0);
  EXPECT_EQ(memory.state, ContactState::kFree);
}

TEST(PlaneContactLaw, PreSlideIsASpringAndDamperAboutTheFirstTouch) {
  ContactMemory<double> memory;
  const ContactGains gains = grasp_gains();
  EXPECT_EQ(press(memory, gains, {0.01, 0.0, 0.3, 0.0}, kT).tangential, 0.0);
  EXPECT_NEAR(press(memory, gains, {0.01, 0.0, 0.301, 0.02}, kT).tangential,
              -1200 * 0.001 - 10 * 0.02, 1e-12);
  EXPECT_EQ(memory.state, ContactState::kPreSlide);
}

TEST(PlaneContactLaw, BreaksAwayAtTheStaticConeAndSlidesWithTheDynamicOne) {
  ContactMemory<double> memory;
  ContactGains gains = grasp_gains();
  gains.tangential.damping = 0.0;
  const double normal = 800 * 0.01, breakaway = 0.6 * normal / 1200;
  (void)press(memory, gains, {0.01, 0.0, 0.0, 0.0}, kT);
  EXPECT_NEAR(press(memory, gains, {0.01, 0.0, breakaway * 0.999, 0.1}, kT).tangential,
              -0.6 * normal * 0.999, 1e-12);
  EXPECT_EQ(memory.state, ContactState::kPreSlide);
  EXPECT_NEAR(press(memory, gains, {0.01, 0.0, breakaway * 1.001, 0.1}, kT).tangential,
              -0.5 * normal, 1e-12);
  EXPECT_EQ(memory.state, ContactState::kSlide);
  // The contact point is dragged until its spring carries the sliding force.
  EXPECT_NEAR(1200 * (breakaway * 1.001 - memory.anchor), 0.5 * normal, 1e-12);
}

TEST(PlaneContactLaw, SlideReturnsToPreSlideAtTheThresholdVelocityOnly) {
  ContactMemory<double> memory;
  const ContactGains gains = grasp_gains();
  (void)press(memory, gains, {0.01, 0.0, 0.0, 0.0}, kT);
  (void)press(memory, gains, {0.01, 0.0, 0.02, 0.1}, kT);
  ASSERT_EQ(memory.state, ContactState::kSlide);
  (void)press(memory, gains, {0.01, 0.0, 0.021, 0.0051}, kT);
  EXPECT_EQ(memory.state, ContactState::kSlide);
  (void)press(memory, gains, {0.01, 0.0, 0.021, 0.005}, kT);
  EXPECT_EQ(memory.state, ContactState::kPreSlide);
}

TEST(PlaneContactLaw, WithoutFrictionThereIsNoTangentialForce) {
  ContactMemory<double> memory;
  ContactGains gains = grasp_gains();
  gains.friction = {};
  for (int k = 0; k < 10; ++k)
    EXPECT_EQ(press(memory, gains, {0.01, 0.0, 0.01 * k, 0.1 * k}, kT).tangential, 0.0);
}

/// A free hand of mass m_h meets a wall that cannot move, at v_c; only the contact acts on it.
struct Arrival {
  int pulses = 0;
  double momentum = 0.0;        // delivered by the pulses [N s]
  double velocity_after = 0.0;  // along the outward normal, at the end of the state
};

Arrival arrive(double mass, double speed, double pulse_force) {
  ContactGains gains = grasp_gains();
  gains.moment_cancellation = true;
  gains.pulse_force = pulse_force;
  gains.mass = mass;
  ContactMemory<double> memory;
  Arrival out;
  double depth = 1e-6, v = -speed;
  for (int k = 0; k < 2000; ++k) {
    const double f = press(memory, gains, {depth, v, 0.0, 0.0}, kT).normal;
    if (memory.state != ContactState::kMomentCancellation) break;
    ++out.pulses;
    out.momentum += f * kT;
    depth -= v * kT;
    v += f / mass * kT;
  }
  out.velocity_after = v;
  return out;
}

TEST(PlaneContactLaw, MomentCancellationPlaysTheLargestWholeNumberBelowTheRatio) {
  // m_h v_c / (T F_max) = 0.1 * 0.5 * 1024 / 5 = 10.24
  EXPECT_EQ(arrive(0.1, 0.5, 5.0).pulses, 10);
  // Exactly 8 in binary arithmetic: "smaller than", so 7.
  EXPECT_EQ(arrive(0.125, 0.25, 4.0).pulses, 7);
  // Less than one pulse's momentum: the state is never entered.
  EXPECT_EQ(arrive(0.1, 0.01, 5.0).pulses, 0);
}

TEST(PlaneContactLaw, PulsesNeverCarryMoreMomentumThanArrivedNorReverseTheHand) {
  Random random(3);
  for (int i = 0; i < 20000; ++i) {
    const double m = random.uniform(0.02, 1.0), v = random.uniform(0.0, 3.0);
    const Arrival a = arrive(m, v, random.uniform(0.5, 20.0));
    EXPECT_LT(a.momentum, m * v + 1e-12);  // rounding of the sum of at most 2000 pulses
    EXPECT_LE(a.velocity_after, 1e-12);
  }
}

TEST(PlaneContactLaw, PulsesEndWhenTheApproachVelocityChangesSign) {
  ContactGains gains = grasp_gains();
  gains.moment_cancellation = true;
  gains.pulse_force = 5.0;
  gains.mass = 0.1;
  ContactMemory<double> memory;
  EXPECT_EQ(press(memory, gains, {1e-4, -0.5, 0.0, 0.0}, kT).normal, 5.0);
  EXPECT_EQ(memory.state, ContactState::kMomentCancellation);
  (void)press(memory, gains, {1e-4, +0.01, 0.0, 0.0}, kT);
  EXPECT_EQ(memory.state, ContactState::kPreSlide);
}

template <typename Tangent>
struct Walk;  // random walk along the surface in one or two directions
template <>
struct Walk<double> {
  static double step(Random& r) { return r.normal(); }
};
template <>
struct Walk<Vec2> {
  static Vec2 step(Random& r) {
    const double x = r.normal();
    return {x, r.normal()};
  }
};

template <typename Tangent>
void check_invariants_on_random_motion() {
  Random random(11);
  ContactMemory<Tangent> memory;
  const ContactGains gains = grasp_gains();
  Tangent x{0.0}, v{0.0};
  int slides = 0, sticks = 0;
  for (int k = 0; k < 300000; ++k) {
    const double depth = random.uniform(-0.0005, 0.01), v_n = 0.05 * random.normal();
    const Tangent before = memory.anchor;
    const bool was_free = memory.state == ContactState::kFree;
    const auto f = press(memory, gains, {depth, v_n, x, v}, kT);
    const double f_t = magnitude(f.tangential);
    ASSERT_GE(f.normal, 0.0);
    ASSERT_LE(f_t, gains.friction.static_coefficient * f.normal * (1 + 1e-9));
    if (memory.state == ContactState::kSlide) {
      ++slides;
      ASSERT_NEAR(f_t, 0.5 * f.normal, 1e-9 * (1 + f.normal));
      if (magnitude(v) > gains.friction.threshold_velocity) {
        ASSERT_LE(inner(f.tangential, v), 0.0);
      } else if (!was_free && inner(f.tangential, v) > 0.0) {  // then the contact point slips
        ASSERT_LE(inner(f.tangential, memory.anchor - before), 1e-12);
      }
      ASSERT_LE(1200 * magnitude(x - memory.anchor), 0.5 * f.normal * (1 + 1e-9) + 1e-12);
    } else if (memory.state == ContactState::kPreSlide) {
      ++sticks;
    }
    v = v * 0.98 + Walk<Tangent>::step(random) * 0.004;
    x += v * kT;
  }
  EXPECT_GT(slides, 10000);  // both were seen
  EXPECT_GT(sticks, 10000);
}

TEST(PlaneContactLaw, InvariantsHoldOnRandomMotionInThePlane) {
  check_invariants_on_random_motion<double>();
}

TEST(PlaneContactLaw, InvariantsHoldOnRandomMotionInSpace) {
  check_invariants_on_random_motion<Vec2>();
}

TEST(PlaneContactLaw, FrictionIsAConeAndNotAPyramid) {
  for (int degrees = 0; degrees < 360; degrees += 5) {
    const double a = degrees * 3.14159265358979323846 / 180.0;
    const Vec2 direction{std::cos(a), std::sin(a)};
    ContactMemory<Vec2> memory;
    ContactGains gains = grasp_gains();
    gains.tangential.damping = 0.0;
    SurfaceForce<Vec2> f;
    double breakaway = 0.0;
    for (int k = 0; k < 1000; ++k) {
      const double s = 1e-5 * k;
      f = press(memory, gains, SurfaceMotion<Vec2>{0.01, 0.0, direction * s, direction * 0.01024},
                kT);
      if (memory.state == ContactState::kSlide && breakaway == 0.0) breakaway = s;
    }
    EXPECT_NEAR(breakaway, 0.6 * 8.0 / 1200, 1.01e-5) << degrees;  // one step of the ramp
    EXPECT_NEAR(magnitude(f.tangential), 0.5 * 8.0, 1e-9) << degrees;
    EXPECT_NEAR(inner(f.tangential, direction), -0.5 * 8.0, 1e-9) << degrees;
  }
}

/// Work a contact without dampers does on a point that is led round a closed path, depth included.
template <typename Path>
double work_on_closed_path(const Path& path, int ticks) {
  ContactGains gains = grasp_gains();
  gains.normal.damping = 0.0;
  gains.tangential.damping = 0.0;
  ContactMemory<double> memory;
  double work = 0.0;
  for (int k = 0; k < 3 * ticks; ++k) {
    const auto [d0, x0] = path(k % ticks);
    const auto [d1, x1] = path((k + 1) % ticks);
    const auto f = press(memory, gains, {d0, -(d1 - d0) / kT, x0, (x1 - x0) / kT}, kT);
    // The spring's energy is quadratic: the held force errs by k/2 dx^2, taken out exactly for the
    // normal; for the tangential it is the bound in the test.
    if (k >= 2 * ticks) work += -f.normal * (d1 - d0) + f.tangential * (x1 - x0);
  }
  return work;
}

TEST(PlaneContactLaw, ClosedFrictionLoopsNeverReturnEnergy) {
  Random random(5);
  const int ticks = 2048;
  for (int trial = 0; trial < 200; ++trial) {
    const double depth = random.uniform(0.002, 0.01), swing = random.uniform(0.0, 0.9) * depth;
    const double reach = random.uniform(0.0005, 0.03), phase = random.uniform(0.0, 6.28);
    const int turns = 1 + static_cast<int>(random.uniform(0.0, 3.0));
    const double w = 2 * 3.14159265358979323846 / ticks;
    double quadratic = 0.0;
    auto path = [&](int k) {
      return std::pair{depth + swing * std::sin(w * k + phase), reach * std::sin(turns * w * k)};
    };
    for (int k = 0; k < ticks; ++k) {
      const auto [d0, x0] = path(k);
      const auto [d1, x1] = path(k + 1);
      quadratic += 0.5 * 800 * (d1 - d0) * (d1 - d0) + 0.5 * 1200 * (x1 - x0) * (x1 - x0);
    }
    const double work = work_on_closed_path(path, ticks);
    // A force held over a tick returns at most k/2 dx^2 more than the spring holds.
    // Elastic loops return just that; 1e-12 is rounding of the sums.
    EXPECT_LE(work, quadratic + 1e-12) << trial;
    // And friction was at work: longer loops dissipate.
    if (reach > 0.02) {
      EXPECT_LT(work, -0.05) << trial;
    }
  }
}

TEST(PlaneContactLaw, PressingHarderWhileSlidingDoesNotChargeTheSpring) {
  ContactMemory<double> memory;
  const ContactGains gains = grasp_gains();
  double x = 0.0;
  for (int k = 0; k < 100; ++k) (void)press(memory, gains, {0.001, 0.0, x = 0.1 * k * kT, 0.1}, kT);
  const double before = x - memory.anchor;
  EXPECT_NEAR(before, 0.5 * 0.8 / 1200, 1e-12);
  const double step = 0.1 * kT;
  const auto f = press(memory, gains, {0.01, 0.0, x + step, 0.1}, kT);  // ten times the load
  EXPECT_NEAR(f.tangential, -0.5 * 8.0, 1e-12);                         // friction at once
  EXPECT_NEAR(x + step - memory.anchor, before + step, 1e-12);          // stored by motion only
}

/// Hayward, Armstrong, Dupont: friction integrated over the way, w += dx, |w| <= mu f_n / sigma.
template <typename Tangent>
void expect_space_integrated(std::uint64_t seed) {
  Random random(seed);
  ContactGains gains = grasp_gains();
  gains.tangential.damping = 0.0;
  gains.friction = {0.5, 0.5, 1e9};
  ContactMemory<Tangent> memory;
  Tangent x{0.0}, w{0.0};
  int slid = 0;
  for (int k = 0; k < 20000; ++k) {
    const double depth = random.uniform(0.002, 0.01);
    Tangent step{0.0};
    for (int i = 0; i < kComponents<Tangent>; ++i) component(step, i) = random.normal() * 0.001;
    if (k == 0) step = Tangent{0.0};
    x += step;
    w += step;
    const double most = 0.5 * 800.0 * depth / 1200.0, length = magnitude(w);
    const SurfaceForce<Tangent> f =
        press(memory, gains, SurfaceMotion<Tangent>{depth, 0.0, x, step * (1.0 / kT)}, kT);
    if (length > most) w *= most / length, ++slid;
    // Positions wander by 0.3 m: the rounding of some tens of sums of it, times 1200 N/m.
    EXPECT_LT(magnitude(f.tangential + w * 1200.0), 1e-11) << k;
    if (testing::Test::HasFailure()) return;
  }
  EXPECT_GT(slid, 1000);
}

// The cone proxy and elasto-plastic friction are the same code: equal while the slip is slower than
// v_tr. Faster, friction opposes the velocity at once.
TEST(PlaneContactLaw, BelowTheThresholdVelocityItIsElastoPlasticFrictionIntegratedOverTheWay) {
  expect_space_integrated<double>(1);
  expect_space_integrated<Vec2>(2);
}

TEST(PlaneContactLaw, SubBreakawayVibrationDoesNotDrift) {
  ContactMemory<double> memory;
  const ContactGains gains = grasp_gains();
  (void)press(memory, gains, {0.01, 0.0, 0.0, 0.0}, kT);
  for (int k = 0; k < 1000000; ++k) {
    const double x = (k % 2 ? 1.0 : -1.0) * 0.001;
    (void)press(memory, gains, {0.01, 0.0, x, 0.0}, kT);
  }
  EXPECT_EQ(memory.anchor, 0.0);
}

}  // namespace
}  // namespace tandem::core
