#include "core/space_body.h"

#include <array>
#include <cmath>

#include <gtest/gtest.h>

#include "core/plane_body.h"
#include "core/random.h"

// The step of a rigid body in space against closed forms, invariants and the plane.
namespace tandem::core {
namespace {

constexpr double kT = 1.0 / 1024.0;
constexpr std::array kAll{Integrator::kZeroOrderHold, Integrator::kSemiImplicitEuler,
                          Integrator::kExplicitEuler};

double length(const Vec3& a) { return std::sqrt(inner(a, a)); }

SpaceBodyParameters body_of(const Vec3& inertia) {
  ObjectParameters object;
  object.mass = 0.7;
  object.inertia = inertia;
  return space_body_parameters(object, 0.0);
}

Vec3 spin_momentum(const SpaceBodyParameters& p, const SpaceBody& b) {
  const Axes axes = axes_of(b.q);
  return axes.to_world(p.inertia * axes.to_body(b.omega));
}

double spin_energy(const SpaceBodyParameters& p, const SpaceBody& b) {
  return 0.5 * inner(b.omega, spin_momentum(p, b));
}

TEST(SpaceBody, MomentsOfInertiaAreThoseOfUniformDensityUnlessTheSceneGivesThem) {
  ObjectParameters box;
  box.shape = Shape::kBox;
  box.mass = 1.2;
  box.size = {0.1, 0.2, 0.3};
  const SpaceBodyParameters p = space_body_parameters(box, 0.0, 0.5);
  EXPECT_NEAR(p.inertia.x, 0.5 * 0.1 * (0.04 + 0.09), 1e-15);
  EXPECT_NEAR(p.inertia.y, 0.5 * 0.1 * (0.09 + 0.01), 1e-15);
  EXPECT_NEAR(p.inertia.z, 0.5 * 0.1 * (0.01 + 0.04), 1e-15);
  EXPECT_NEAR(1.0 / p.inverse_mass, 0.6, 1e-15);
  ObjectParameters ball;
  ball.shape = Shape::kSphere;
  ball.mass = 2.0;
  ball.radius = 0.05;
  EXPECT_NEAR(principal_moments(ball).y, 0.002, 1e-17);
  box.inertia = {0.01, 0.02, 0.025};
  EXPECT_EQ(principal_moments(box).z, 0.025);
}

/// Pose of a torque-free symmetric top, moments (A, A, C), after `time`: it turns about the fixed
/// angular momentum at |L|/A and about its own axis at omega_3 (1 - C/A) beside that (Goldstein,
/// Classical Mechanics, 5.6).
Quat top_at(double A, double C, const Quat& start, const Vec3& omega_B, double time) {
  const Vec3 momentum_B{A * omega_B.x, A * omega_B.y, C * omega_B.z};
  const Vec3 L = axes_of(start).to_world(momentum_B);
  return rotation_by(L * (time / A)) * start *
         rotation_by({0.0, 0.0, omega_B.z * (1.0 - C / A) * time});
}

TEST(SpaceBody, ASymmetricTopPrecessesAsInClosedFormWithAnErrorOfSecondOrder) {
  for (const double C : {0.4e-3, 1.7e-3}) {  // long and flat
    const double A = 1e-3;
    const SpaceBodyParameters p = body_of({A, A, C});
    const Quat start = rotation_by({0.4, -0.9, 0.3});
    const Vec3 omega_B{3.0, -1.0, 8.0};
    std::array<double, 2> error{};
    for (int fine = 0; fine < 2; ++fine) {
      const double T = kT / (1 + fine);
      SpaceBody b;
      b.q = start;
      b.omega = axes_of(start).to_world(omega_B);
      for (int k = 0; k < 1024 * (1 + fine); ++k) b = step(p, Integrator::kZeroOrderHold, T, b, {});
      error[fine] = length(rotation_between(b.q, top_at(A, C, start, omega_B, 1.0)));
    }
    // Midpoint rule: (T omega)^2 / 12 of the angle turned, (8/1024)^2 / 12 * 8 rad = 4e-5 rad.
    EXPECT_LT(error[0], 1e-4);
    EXPECT_NEAR(error[0] / error[1], 4.0, 0.05);  // second order; the next is fourth
  }
}

TEST(SpaceBody, ABodySpunAboutItsMiddleAxisTumblesAndKeepsEnergyAndMomentum) {
  const SpaceBodyParameters p = body_of({1e-3, 2e-3, 2.8e-3});
  for (const Integrator integrator : kAll) {
    SpaceBody b;
    b.q = rotation_by({0.2, 0.1, -0.4});
    b.omega = axes_of(b.q).to_world({1e-3, 20.0, 1e-3});
    const Vec3 momentum = spin_momentum(p, b);
    const double energy = spin_energy(p, b);
    double worst_momentum = 0.0, worst_energy = 0.0, worst_unit = 0.0;
    int turns_over = 0;
    bool up = true;
    for (int k = 0; k < 50000; ++k) {
      b = step(p, integrator, kT, b, {});
      worst_momentum = std::fmax(worst_momentum, length(spin_momentum(p, b) - momentum));
      worst_energy = std::fmax(worst_energy, std::fabs(spin_energy(p, b) - energy));
      worst_unit = std::fmax(worst_unit, std::fabs(glm::dot(b.q, b.q) - 1.0));
      const bool now_up = axes_of(b.q).to_body(b.omega).y > 0.0;
      turns_over += now_up != up;
      up = now_up;
    }
    // Rounding of 50000 ticks adds up as a random walk: 1e-16 sqrt(5e4) = 3e-14; some margin.
    EXPECT_LT(worst_momentum, 1e-12 * length(momentum));
    EXPECT_LT(worst_energy, 1e-12 * energy);
    EXPECT_LT(worst_unit, 1e-15);
    EXPECT_GT(turns_over, 20);  // Dzhanibekov: about every 1.5 s
  }
}

/// Euler's equations in the body frame, in the fine steps of a classical Runge-Kutta.
Vec3 euler_by_runge_kutta(const Vec3& J, Vec3 omega, double time) {
  const auto rate = [&](const Vec3& w) { return -glm::cross(w, J * w) / J; };
  const int steps = 20000;
  const double h = time / steps;
  for (int k = 0; k < steps; ++k) {
    const Vec3 a = rate(omega), b = rate(omega + a * (h / 2)), c = rate(omega + b * (h / 2)),
               d = rate(omega + c * h);
    omega += (a + b * 2.0 + c * 2.0 + d) * (h / 6);
  }
  return omega;
}

TEST(SpaceBody, AFreeAsymmetricBodyFollowsEulersEquationsWithAnErrorOfSecondOrder) {
  const Vec3 J{1e-3, 2e-3, 2.8e-3}, start{4.0, 6.0, -3.0};
  const SpaceBodyParameters p = body_of(J);
  const Vec3 expected = euler_by_runge_kutta(J, start, 1.0);
  std::array<double, 2> error{};
  for (int fine = 0; fine < 2; ++fine) {
    SpaceBody b;
    b.omega = start;
    for (int k = 0; k < 1024 * (1 + fine); ++k)
      b = step(p, Integrator::kZeroOrderHold, kT / (1 + fine), b, {});
    error[fine] = length(axes_of(b.q).to_body(b.omega) - expected);
  }
  EXPECT_LT(error[0], 1e-3);  // (6/1024)^2 / 12 * 6 rad of phase, times some 6 rad/s
  EXPECT_NEAR(error[0] / error[1], 4.0, 0.05);
}

TEST(SpaceBody, TheTorquesImpulseIsExactlyTheGainOfMomentumInTheWorld) {
  Random random(7);
  const SpaceBodyParameters p = body_of({1e-3, 2e-3, 2.8e-3});
  for (const Integrator integrator : kAll) {
    SpaceBody b;
    Vec3 spin{0.0}, push{0.0};
    for (int k = 0; k < 2000; ++k) {
      const SpaceWrench w{{random.normal(), random.normal(), random.normal()},
                          Vec3{random.normal(), random.normal(), random.normal()} * 0.1};
      b = step(p, integrator, kT, b, w);
      spin += w.torque * kT;
      push += w.force * kT;
    }
    EXPECT_LT(length(spin_momentum(p, b) - spin), 1e-15);  // of about 5e-3: some 1e-13 of it
    EXPECT_LT(length(b.v * 0.7 - push), 1e-14);
  }
}

TEST(SpaceBody, TurningAboutOnePrincipalAxisIsTheStepOfThePlane) {
  ObjectParameters object;
  object.shape = Shape::kBox;
  object.size = {0.1, 0.08, 0.05};
  object.mass = 0.7;
  object.compensation_rotation = 1e-4;
  object.compensation = 0.2;
  const SpaceBodyParameters p = space_body_parameters(object, 0.0);
  const PlaneBodyParameters q = plane_body_parameters(object, 9.81);
  for (const Integrator integrator : kAll) {
    SpaceBody b;
    PlaneBody flat;
    for (int k = 0; k < 1000; ++k) {
      const double f = std::sin(0.01 * k), tau = 0.01 * std::cos(0.02 * k);
      b = step(p, integrator, kT, b, {{f, -f, 0.0}, {0.0, 0.0, tau}});
      flat = step(q, integrator, kT, flat, {{f, -f}, tau});
    }
    EXPECT_NEAR(b.p.x, flat.p.x, 1e-14);
    EXPECT_NEAR(b.omega.z, flat.omega, 1e-12);  // some 10 rad/s
    EXPECT_LT(length(rotation_vector(b.q * rotation_by({0.0, 0.0, -flat.angle}))), 1e-12);
    EXPECT_EQ(b.omega.x, 0.0);
  }
}

TEST(SpaceBody, WeightAloneGivesFreeFall) {
  ObjectParameters object;
  object.shape = Shape::kSphere;
  object.radius = 0.02;
  const SpaceBodyParameters p = space_body_parameters(object, 9.81, 0.5);
  SpaceBody b;
  b.v = {0.3, 0.0, 1.0};
  for (int k = 0; k < 1024; ++k) b = step(p, Integrator::kZeroOrderHold, kT, b, {});
  EXPECT_NEAR(b.p.z, 1.0 - 9.81 / 2, 1e-13);
  EXPECT_NEAR(b.p.x, 0.3, 1e-14);
  EXPECT_NEAR(b.v.z, 1.0 - 9.81, 1e-13);
}

TEST(SpaceBody, ATurnOfRadiansATickNeitherBlowsUpNorLosesMomentum) {
  const SpaceBodyParameters p = body_of({1e-3, 2e-3, 2.8e-3});
  SpaceBody b;
  b.omega = {1500.0, 2000.0, -900.0};
  const Vec3 momentum = spin_momentum(p, b);
  for (int k = 0; k < 10000; ++k) {
    b = step(p, Integrator::kZeroOrderHold, kT, b, {});
    ASSERT_LE(spin_energy(p, b), inner(momentum, momentum) / 2e-3 * (1 + 1e-12));
  }
  EXPECT_LT(length(spin_momentum(p, b) - momentum), 1e-12 * length(momentum));
}

TEST(SpaceBody, ABodyAtRestStaysWhereItIsToTheBit) {
  const SpaceBodyParameters p = body_of({1e-3, 2e-3, 2.8e-3});
  SpaceBody b;
  b.p = {0.1, 0.2, 0.3};
  b.q = normalised({0.9, 0.1, -0.3, 0.2});
  const SpaceBody once = step(p, Integrator::kZeroOrderHold, kT, b, {});
  SpaceBody later = once;
  for (int k = 0; k < 1000; ++k) later = step(p, Integrator::kZeroOrderHold, kT, later, {});
  EXPECT_TRUE(later.p == b.p && later.v == b.v && later.omega == b.omega);
  EXPECT_LT(length(rotation_between(b.q, later.q)), 3e-16);
}

}  // namespace
}  // namespace tandem::core
