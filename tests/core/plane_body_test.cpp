#include "core/plane_body.h"

#include <cmath>
#include <type_traits>

#include <gtest/gtest.h>

#include "core/axis_world.h"
#include "core/coordination.h"
#include "core/plane_contact.h"
#include "core/random.h"

namespace tandem::core {
namespace {

constexpr double kT = 1.0 / 1024.0;
constexpr double kPi = 3.14159265358979323846;
constexpr auto kZoh = Integrator::kZeroOrderHold;
constexpr Integrator kAll[] = {Integrator::kZeroOrderHold, Integrator::kSemiImplicitEuler,
                               Integrator::kExplicitEuler};

static_assert(std::is_trivially_copyable_v<PlaneBody>);

PlaneBodyParameters box(double mass, double mu, double mu_rotation = 0.0) {
  ObjectParameters object;
  object.mass = mass;
  object.size = {0.1, 0.06, 0.0};
  object.ground_friction = mu;
  object.ground_friction_rotation = mu_rotation;
  return plane_body_parameters(object, 9.81);
}

TEST(PlaneBody, ConstantForceGivesTheParabolaExactly) {
  const PlaneBodyParameters p = box(0.7, 0.0);
  PlaneBody body{{0.1, -0.2}, 0.3, {0.4, 0.0}, -0.5};
  const int ticks = 4096;
  for (int k = 0; k < ticks; ++k) body = step(p, kZoh, kT, body, {{0.7, -1.4}, 0.002});
  const double t = ticks * kT, alpha = 0.002 * p.inverse_inertia;
  // Rounding of 4096 additions of numbers of size 10.
  EXPECT_NEAR(body.p.x, 0.1 + 0.4 * t + 0.5 * 1.0 * t * t, 1e-11);
  EXPECT_NEAR(body.p.y, -0.2 - 0.5 * 2.0 * t * t, 1e-11);
  EXPECT_NEAR(body.angle, 0.3 - 0.5 * t + 0.5 * alpha * t * t, 1e-11);
  EXPECT_NEAR(body.omega, -0.5 + alpha * t, 1e-11);
}

TEST(PlaneBody, InertiaOfUniformDensityIsTakenWhenNoneIsGiven) {
  EXPECT_NEAR(1.0 / box(0.6, 0.0).inverse_inertia, 0.6 * (0.01 + 0.0036) / 12, 1e-15);
  ObjectParameters object;
  object.mass = 0.6;
  object.size = {0.1, 0.06, 0.0};
  object.inertia.z = 0.002;
  EXPECT_NEAR(1.0 / plane_body_parameters(object, 9.81, 0.5).inverse_inertia, 0.001, 1e-15);
  EXPECT_NEAR(1.0 / plane_body_parameters(object, 9.81, 0.5).inverse_mass, 0.3, 1e-15);
}

TEST(PlaneBody, MassOnACouplerFollowsTheClosedFormOscillation) {
  const double m = 0.7, K = 400.0, B = 1.0, x0 = 0.02, T = 1e-5;
  const PlaneBodyParameters p = box(m, 0.0);
  const double J = 1.0 / p.inverse_inertia, K_r = 0.4, B_r = 0.001, a0 = 0.3;
  PlaneBody body{{x0, 0.0}, a0, {0.0, 0.0}, 0.0};
  for (int k = 0; k < 20000; ++k)
    body = step(p, kZoh, T, body, coordinate({K, B}, {K_r, B_r}, body, PlaneBody{}));
  const double t = 20000 * T;
  auto closed = [t](double start, double mass, double k, double b) {
    const double sigma = b / (2 * mass), w = std::sqrt(k / mass - sigma * sigma);
    return start * std::exp(-sigma * t) * (std::cos(w * t) + sigma / w * std::sin(w * t));
  };
  // The held force errs by K T / 2 of damping: relative K T t / (4 m) = 3e-4 of the amplitude.
  EXPECT_NEAR(body.p.x, closed(x0, m, K, B), 3e-4 * x0);
  EXPECT_NEAR(body.angle, closed(a0, J, K_r, B_r), 3 * K_r * T * t / (4 * J) * a0);
}

/// Largest stiffness, in units of b/T, for which a mass on a wall k, b does not grow in 4000 ticks.
/// Growth is seen by the norm over the last quarter against that over the second.
bool is_stable(Integrator integrator, double m, double k, double b, double T) {
  PlaneBodyParameters p;
  p.inverse_mass = 1.0 / m;
  PlaneBody body{{1.0, 0.0}, 0.0, {0.0, 0.0}, 0.0};
  double early = 0.0, late = 0.0;
  for (int i = 0; i < 40000; ++i) {
    body = step(p, integrator, T, body, {-(body.p * k + body.v * b), 0.0});
    const double norm = body.p.x * body.p.x * k / m + body.v.x * body.v.x;
    if (i >= 10000 && i < 20000) early += norm;
    if (i >= 30000) late += norm;
    if (norm > 1e200) return false;
  }
  return late <= early;
}

double stability_limit(Integrator integrator, double m, double b, double T, double guess) {
  double low = 0.5 * guess, high = 2.0 * guess;
  EXPECT_TRUE(is_stable(integrator, m, low, b, T));
  EXPECT_FALSE(is_stable(integrator, m, high, b, T));
  for (int i = 0; i < 14; ++i) {
    const double middle = 0.5 * (low + high);
    (is_stable(integrator, m, middle, b, T) ? low : high) = middle;
  }
  return low;
}

TEST(PlaneBody, StabilityLimitsOfTheThreeIntegratorsAreTheKnownOnes) {
  const double m = 0.4, b = 10.0, T = kT;  // methods of the linear 1-dof wall, known in closed form
  const double explicit_euler = b / T, zoh = 2 * b / T, semi = 4 * m / (T * T) - 2 * b / T;
  EXPECT_NEAR(stability_limit(Integrator::kExplicitEuler, m, b, T, explicit_euler), explicit_euler,
              0.005 * explicit_euler);
  EXPECT_NEAR(stability_limit(Integrator::kZeroOrderHold, m, b, T, zoh), zoh, 0.005 * zoh);
  EXPECT_NEAR(stability_limit(Integrator::kSemiImplicitEuler, m, b, T, semi), semi, 0.005 * semi);
}

/// Whether what is pressed to a wall and moved by a tenth of a micrometre comes back to rest.
/// `tick(force)` makes a tick under a steady force and returns its depth and its way in a tick: at
/// the limit the ends of the ticks hardly move, the velocity changes sign from one to the next.
template <typename Tick>
bool settles(double k, double b, double T, Tick&& tick) {
  const double press = 0.01 * k, rest = 0.01;
  for (int i = 0; i < 4; ++i) (void)tick(-press);
  double early = 0.0, late = 0.0;
  const int ticks = 20000 + static_cast<int>(2000 / (b * T));
  for (int i = 0; i < ticks; ++i) {
    const Vec2 at = tick(i == 0 ? -press * 1.00001 : -press);
    const double off = std::fmax(std::fabs(at.x - rest), std::fabs(at.y));
    if (off > 1e-3) return false;
    if (i >= ticks / 4 && i < ticks / 2) early = std::fmax(early, off);
    if (i >= 3 * ticks / 4) late = std::fmax(late, off);
  }
  return late <= early + 1e-12;
}

template <typename Stable>
double limit_by_halving(double low, double high, Stable&& stable) {
  EXPECT_TRUE(stable(low));
  EXPECT_FALSE(stable(high));
  for (int i = 0; i < 12; ++i) {
    const double middle = 0.5 * (low + high);
    (stable(middle) ? low : high) = middle;
  }
  return low;
}

TEST(PlaneBody, AWallMetWithinTheTickIsStableUpToTheClosedFormLimit) {
  // By hand, x the way from rest, w = T v, kappa = k T^2 / m, beta = b T / m; the mean way of the
  // tick is x + w / 2:
  //   x' = x + w + q / 2,  w' = w + q,  q = -kappa (x + w / 2) - beta w
  // trace 2 - kappa - beta, determinant 1 - beta: both roots inside the unit circle (Jury) for
  // 0 < beta < 2 and kappa < 4 - 2 beta, that is k < 4 m / T^2 - 2 b / T.
  const double m = 0.4, T = kT;
  for (const double b : {10.0, 100.0, 300.0}) {  // of at most 2 m / T = 819
    const double limit = 4 * m / (T * T) - 2 * b / T;
    const auto plane = [&](double k) {
      PlaneBodyParameters p = box(m, 0.0);
      p.inverse_inertia = 0.0;
      const PlaneBox shape{{0.05, 0.03}, 0.0};
      PlaneWall wall;  // two corners touch it, half of the gain each
      wall.gains.normal = {0.5 * k, 0.5 * b};
      WallContacts contacts;
      PlaneBody body{{0.0, 0.03 - 0.01}, 0.0, {0.0, 0.0}, 0.0};
      return settles(k, b, T, [&](double force) {
        PlaneWrench w = hold_back(contacts, wall, shape, body, T, true);
        w.force.y += force;
        body = step(p, kZoh, T, body, w);
        return Vec2{0.03 - body.p.y, T * body.v.y};
      });
    };
    EXPECT_NEAR(limit_by_halving(0.5 * limit, 2 * limit, plane), limit, 0.005 * limit) << b;
    const auto axis = [&](double k) {
      Scene scene;
      scene.rates.local_hz = 1.0 / T;
      scene.objects.resize(1);
      scene.objects[0].mass = m;
      scene.walls.resize(1);
      scene.walls[0].normal = {1.0, 0.0, 0.0};
      scene.walls[0].gain = {k, b};
      const AxisWorld world(scene, 1.0);
      AxisWorld::ObjectWalls memory;
      AxisState body{-0.01, 0.0};
      return settles(k, b, T, [&](double force) {
        body = world.step(0, body, force + world.walls_on_object(0, memory, body));
        return Vec2{-body.p, T * body.v};
      });
    };
    EXPECT_NEAR(limit_by_halving(0.5 * limit, 2 * limit, axis), limit, 0.005 * limit) << b;
  }
}

TEST(PlaneBody, SlidingBlockStopsWhereTheClosedFormSays) {
  const double mu = 0.05, v = 0.31;
  for (int degrees = 0; degrees < 360; degrees += 30) {
    const double a = degrees * kPi / 180;
    PlaneBody body{{0.0, 0.0}, 0.0, {v * std::cos(a), v * std::sin(a)}, 0.0};
    const PlaneBodyParameters p = box(0.7, mu);
    int ticks = 0;
    while (body.v != Vec2(0.0) && ticks < 5000) {
      const Vec2 before = body.v;
      body = step(p, kZoh, kT, body, {});
      EXPECT_GE(inner(before, body.v), 0.0);  // never reverses
      ++ticks;
    }
    EXPECT_EQ(ticks, static_cast<int>(std::ceil(v / (mu * 9.81 * kT))));
    const double way = v * v / (2 * mu * 9.81);
    EXPECT_NEAR(body.p.x, way * std::cos(a), 1e-12);  // exact but for rounding
    EXPECT_NEAR(body.p.y, way * std::sin(a), 1e-12);
  }
}

TEST(PlaneBody, SpinningBlockStopsWhereTheClosedFormSays) {
  const PlaneBodyParameters p = box(0.7, 0.0, 0.15);
  const double torque = 0.15 * 0.7 * 9.81 * mean_radius({0.05, 0.03}), omega = 4.0;
  EXPECT_NEAR(p.ground.torque, torque, 1e-15);
  PlaneBody body{{0.0, 0.0}, 0.0, {0.0, 0.0}, omega};
  for (int k = 0; k < 5000; ++k) body = step(p, kZoh, kT, body, {});
  EXPECT_EQ(body.omega, 0.0);
  EXPECT_NEAR(body.angle, omega * omega / (2 * torque * p.inverse_inertia), 1e-12);
}

TEST(PlaneBody, StaysExactlyAtRestUpToTheLimitAndStartsAboveIt) {
  const double mu = 0.05;
  for (const Integrator integrator : kAll) {
    for (int degrees = 0; degrees < 360; degrees += 15) {
      const double a = degrees * kPi / 180, limit = mu * 0.7 * 9.81;
      const PlaneBodyParameters p = box(0.7, mu, 0.15);
      const PlaneBody start{{0.123, -0.456}, 0.789, {0.0, 0.0}, 0.0};
      PlaneBody body = start;
      const double below = limit * (1 - 1e-12), torque = p.ground.torque * (1 - 1e-12);
      for (int k = 0; k < 1000; ++k)
        body = step(p, integrator, kT, body, {{below * std::cos(a), below * std::sin(a)}, torque});
      EXPECT_EQ(body.p, start.p);
      EXPECT_EQ(body.v, Vec2(0.0));
      EXPECT_EQ(body.angle, start.angle);
      EXPECT_EQ(body.omega, 0.0);
      const double above = limit * 1.001;
      body = step(p, integrator, kT, body, {{above * std::cos(a), above * std::sin(a)}, 0.0});
      EXPECT_GT(inner(body.v, Vec2{std::cos(a), std::sin(a)}), 0.0);
    }
  }
}

TEST(PlaneBody, OnAnInclineItSticksUpToTanThetaEqualToMu) {
  const double mu = 0.3, m = 0.7, g = 9.81;
  for (const double ratio : {0.999, 1.001}) {
    const double theta = std::atan(mu * ratio);
    ObjectParameters object;
    object.mass = m;
    object.size = {0.1, 0.1, 0.0};
    object.ground_friction = mu;
    // On the incline the normal load is m g cos(theta), the pull along it m g sin(theta).
    const PlaneBodyParameters p = plane_body_parameters(object, g * std::cos(theta));
    PlaneBody body;
    for (int k = 0; k < 1024; ++k)
      body = step(p, kZoh, kT, body, {{m * g * std::sin(theta), 0.0}, 0.0});
    if (ratio < 1) {
      EXPECT_EQ(body.p.x, 0.0);
    } else {  // slides with g (sin - mu cos), for 1 s
      EXPECT_NEAR(body.p.x, 0.5 * g * (std::sin(theta) - mu * std::cos(theta)), 1e-9);
    }
  }
}

TEST(PlaneBody, CompensationCancelsAViscousDrag) {
  PlaneBodyParameters p = box(0.7, 0.0);
  p.compensation = 2.5;
  p.compensation_rotation = 0.01;
  PlaneBody body{{0.0, 0.0}, 0.0, {0.3, -0.1}, 2.0};
  for (int k = 0; k < 2000; ++k)
    body = step(p, kZoh, kT, body, {body.v * -2.5, body.omega * -0.01});
  EXPECT_NEAR(body.v.x, 0.3, 1e-14);
  EXPECT_NEAR(body.omega, 2.0, 1e-13);
}

TEST(PlaneBody, MeanRadiusAgreesWithIntegrationOverTheRectangle) {
  for (const Vec2 half : {Vec2{0.05, 0.05}, Vec2{0.05, 0.03}, Vec2{0.2, 0.01}}) {
    double sum = 0.0;
    const int n = 400;
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j) sum += std::hypot((i + 0.5) / n * half.x, (j + 0.5) / n * half.y);
    EXPECT_NEAR(mean_radius(half), sum / (n * n), 1e-5 * half.x);  // midpoint rule, error ~ 1/n^2
  }
  EXPECT_NEAR(mean_radius({1.0, 1.0}), (std::sqrt(2.0) + std::asinh(1.0)) / 3, 1e-14);
}

TEST(PlaneBody, CoordinationPullsCopiesTogetherWithEqualAndOppositeWrench) {
  const PlaneBody a{{0.1, 0.2}, 3.0, {0.3, 0.1}, 0.2}, b{{0.15, 0.1}, 3.5, {0.0, 0.1}, 0.4};
  const PlaneWrench on_a = coordinate({400, 8}, {10, 0.1}, a, b);
  const PlaneWrench on_b = coordinate({400, 8}, {10, 0.1}, b, a);
  EXPECT_NEAR(on_a.force.x, 400 * 0.05 - 8 * 0.3, 1e-12);
  EXPECT_NEAR(on_a.torque, 10 * 0.5 + 0.1 * 0.2, 1e-12);
  EXPECT_EQ(on_a.force, -on_b.force);
  EXPECT_EQ(on_a.torque, -on_b.torque);
}

TEST(PlaneBody, WholeTurnsBetweenCopiesAreNotWoundBack) {
  EXPECT_NEAR(twist(2 * kPi + 0.1, 0.0), 0.1, 1e-14);
  EXPECT_NEAR(twist(0.0, 6 * kPi + 0.1), -0.1, 1e-13);
  EXPECT_EQ(twist(3.0, 0.0), 3.0);
  EXPECT_NEAR(twist(3.3, 0.0), 3.3 - 2 * kPi, 1e-14);
}

}  // namespace
}  // namespace tandem::core
