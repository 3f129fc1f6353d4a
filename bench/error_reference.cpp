#include "bench/error_reference.h"

#include <cmath>
#include <functional>
#include <limits>
#include <unsupported/Eigen/MatrixFunctions>

#include <Eigen/Dense>

namespace tandem::bench {
namespace {

using Real = long double;
using Matrix = Eigen::Matrix<Real, Eigen::Dynamic, Eigen::Dynamic>;
using Vector = Eigen::Matrix<Real, Eigen::Dynamic, 1>;

Matrix exponential(const Matrix& a) { return a.exp(); }

/// Adds the force of a spring and damper between masses i and j (-1: the ground) to x' = A x, whose
/// states are p v p v ...
void join(Matrix& a, int i, int j, Real mass, const ErrorPoint& point) {
  const auto k = static_cast<Real>(point.stiffness) / mass, b = point.damping / mass;
  a(2 * i + 1, 2 * i) -= k, a(2 * i + 1, 2 * i + 1) -= b;
  if (j >= 0) a(2 * i + 1, 2 * j) += k, a(2 * i + 1, 2 * j + 1) += b;
}

std::vector<double> linear_course(const ErrorPoint& point, const Matrix& a, Vector state) {
  const Matrix step = exponential(a / Real{kGridRate});
  std::vector<double> out;
  for (int i = 0; i < sample_count(point); ++i) {
    state = step * state;
    for (int j = 0; j < sample_width(point.which); ++j)
      out.push_back(static_cast<double>(state(j)));
  }
  return out;
}

/// x' = (A + C) x: what goes on by itself, and what the couplers add.
struct Network {
  Matrix a, c;
  Vector start;
};

Network network(const ErrorPoint& point) {
  const bool two = point.which == Case::kHands;
  const int n = two ? 7 : 4;
  Network out{Matrix::Zero(n, n), Matrix::Zero(n, n), Vector::Zero(n)};
  out.a(0, 1) = out.a(2, 3) = 1;
  join(out.c, 0, 1, kHandMass, point);
  join(out.c, 1, 0, kObjectMass, point);
  if (!two) {
    out.start(3) = kThrown;
    return out;
  }
  out.a(4, 5) = 1;
  join(out.c, 2, 1, kHandMass, point);
  join(out.c, 1, 2, kObjectMass, point);
  out.a(1, 6) = static_cast<Real>(kPushed[0]) / kHandMass;
  out.a(5, 6) = static_cast<Real>(kPushed[1]) / kHandMass;
  out.start(6) = 1;
  return out;
}

std::vector<double> true_network(const ErrorPoint& point) {
  const Network n = network(point);
  return linear_course(point, n.a + n.c, n.start);
}

/// The couplers' part is held from tick to tick: as states u' = 0 beside x' = A x + u.
std::vector<double> held_network(const ErrorPoint& point, int hz) {
  const Network net = network(point);
  const auto n = net.a.rows();
  Matrix both = Matrix::Zero(2 * n, 2 * n);
  both.topLeftCorner(n, n) = net.a;
  both.topRightCorner(n, n).setIdentity();
  const Matrix step = exponential(both / Real(hz));
  const Matrix tick = step.topLeftCorner(n, n) + step.topRightCorner(n, n) * net.c;
  Vector state = net.start;
  std::vector<double> out;
  for (int i = 0; i < sample_count(point); ++i) {
    for (int s = 0; s < hz / kGridRate; ++s) state = tick * state;
    for (int j = 0; j < sample_width(point.which); ++j)
      out.push_back(static_cast<double>(state(j)));
  }
  return out;
}

/// x' = A x until `ends` turns positive; then `next` says in which mode it goes on, and may change
/// the state.
struct Mode {
  Matrix a;
  std::function<Real(const Vector&)> ends;
  std::function<int(Vector&)> next;
};

/// States 0 and 1 are position and velocity. Events are found to the last bit of the time in a
/// step.
std::vector<double> switched_course(const ErrorPoint& point, const std::vector<Mode>& modes,
                                    Vector state) {
  constexpr int kSteps = 16;  // between two grid points; events in one step are not missed
  const Real h = Real{1} / (kGridRate * kSteps);
  std::vector<Matrix> whole;
  for (const Mode& mode : modes) whole.push_back(exponential(mode.a * h));
  std::size_t at = 0;
  std::vector<double> out;
  for (int i = 0; i < sample_count(point); ++i) {
    for (int s = 0; s < kSteps; ++s) {
      Real left = h;
      for (int events = 0; events < 8; ++events) {
        const Mode& mode = modes[at];
        const Vector end = left == h ? whole[at] * state : exponential(mode.a * left) * state;
        if (!(mode.ends(end) > 0)) {
          state = end;
          break;
        }
        Real low = 0, high = left;
        for (int b = 0; b < 70; ++b) {
          const Real middle = (low + high) / 2;
          (mode.ends(exponential(mode.a * middle) * state) > 0 ? high : low) = middle;
        }
        state = exponential(mode.a * high) * state;
        left -= high;
        at = static_cast<std::size_t>(mode.next(state));
      }
    }
    out.push_back(static_cast<double>(state(0)));
    out.push_back(static_cast<double>(state(1)));
  }
  return out;
}

/// The wall is at the origin here and pushes while k d + b v > 0.
std::vector<Mode> wall_modes(const ErrorPoint& point) {
  Mode before, inside, after;
  before.a = inside.a = Matrix::Zero(2, 2);
  before.a(0, 1) = inside.a(0, 1) = 1;
  join(inside.a, 0, -1, kObjectMass, point);
  after.a = before.a;
  before.ends = [](const Vector& x) { return x(0); };
  before.next = [](Vector&) { return 1; };
  const Real k = point.stiffness, b = point.damping;
  inside.ends = [k, b](const Vector& x) { return -(k * x(0) + b * x(1)); };
  inside.next = [](Vector&) { return 2; };
  after.ends = [](const Vector&) { return Real{-1}; };
  after.next = [](Vector&) { return 2; };
  return {before, inside, after};
}

std::vector<double> wall(const ErrorPoint& point) {
  Vector state(2);
  state << -static_cast<Real>(kGap), static_cast<Real>(kFlight);
  std::vector<double> out = switched_course(point, wall_modes(point), state);
  for (std::size_t i = 0; i < out.size(); i += 2) out[i] += kGap;
  return out;
}

/// States x v 1 t a, the anchor last. Ideal: no spring, the mass stands still until it breaks away.
std::vector<double> stick_slip(const ErrorPoint& point, bool ideal) {
  const Real m = kHandMass, K = kDrawSpring, V = kDrawSpeed, N = kNormalForce;
  const Real k = ideal ? 0 : point.stiffness, b = ideal ? 0 : point.damping;
  const Real threshold = ideal ? 0 : 0.005L;
  Mode stick, slip;
  stick.a = slip.a = Matrix::Zero(5, 5);
  for (Mode* mode : {&stick, &slip}) mode->a(3, 2) = 1;
  const auto drawn = [&](Matrix& a) {
    a(0, 1) = 1;
    a(1, 0) -= K / m, a(1, 3) += K * V / m;
  };
  drawn(slip.a);
  slip.a(1, 2) = -kSlips * N / m;
  if (ideal) {
    stick.ends = [=](const Vector& x) { return K * (V * x(3) - x(0)) - kSticks * N; };
    stick.next = [](Vector&) { return 1; };
  } else {
    drawn(stick.a);
    stick.a(1, 0) -= k / m, stick.a(1, 4) += k / m, stick.a(1, 1) -= b / m;
    stick.ends = [=](const Vector& x) { return k * (x(0) - x(4)) + b * x(1) - kSticks * N; };
    stick.next = [=](Vector& x) {
      x(4) = x(0) - kSlips * N / k;
      return x(1) > threshold ? 1 : 0;
    };
  }
  slip.ends = [=](const Vector& x) { return threshold - x(1); };
  slip.next = [=](Vector& x) {
    if (ideal)
      x(1) = 0;
    else
      x(4) = x(0) - kSlips * N / k;
    return 0;
  };
  // An ideal slip starts at zero velocity: it has not ended before it has begun.
  if (ideal)
    slip.ends = [=](const Vector& x) {
      return K * (V * x(3) - x(0)) < kSlips * N ? -x(1) : Real{-1};
    };
  Vector state = Vector::Zero(5);
  state(2) = 1;
  return switched_course(point, {stick, slip}, state);
}

std::vector<double> slide(const ErrorPoint& point) {
  const Real speed = std::hypot(static_cast<Real>(kSlideSpeed[0]), kSlideSpeed[1]);
  const Real braking = static_cast<Real>(kSlideFriction) * kGravity;
  std::vector<double> out;
  for (int i = 1; i <= sample_count(point); ++i) {
    const Real t = std::min(static_cast<Real>(i) / kGridRate, speed / braking);
    const Real way = t * (speed - braking * t / 2) / speed, rest = 1 - braking * t / speed;
    for (const double v : kSlideSpeed) out.push_back(static_cast<double>(v * way));
    for (const double v : kSlideSpeed) out.push_back(static_cast<double>(v * rest));
  }
  return out;
}

using Turn = Eigen::Quaternion<Real>;
using Vector3 = Eigen::Matrix<Real, 3, 1>;

/// Euler's equations with the orientation, classical Runge-Kutta.
std::vector<double> spin(const ErrorPoint& point, int steps_per_second) {
  using State = Eigen::Matrix<Real, 7, 1>;  // q (w x y z), omega in B
  const Vector3 J(kMoments[0], kMoments[1], kMoments[2]);
  const auto slope = [&J](const State& s) {
    const Turn q(s(0), s(1), s(2), s(3));
    const Vector3 w = s.tail<3>();
    const Turn dq = q * Turn(0, w.x() / 2, w.y() / 2, w.z() / 2);
    const Vector3 dw = -w.cross(J.cwiseProduct(w)).cwiseQuotient(J);
    State out;
    out << dq.w(), dq.x(), dq.y(), dq.z(), dw;
    return out;
  };
  State s;
  s << 1, 0, 0, 0, kSpin[0], kSpin[1], kSpin[2];
  const Real h = Real{1} / steps_per_second;
  std::vector<double> out;
  for (int i = 0; i < sample_count(point); ++i) {
    for (int n = 0; n < steps_per_second / kGridRate; ++n) {
      const State a = slope(s), b = slope(s + a * (h / 2)), c = slope(s + b * (h / 2)),
                  d = slope(s + c * h);
      s += (a + 2 * b + 2 * c + d) * (h / 6);
    }
    const Turn q(s(0), s(1), s(2), s(3));
    const Vector3 w = q * Vector3(s.tail<3>());
    for (const Real x : {s(0), s(1), s(2), s(3), w.x(), w.y(), w.z()})
      out.push_back(static_cast<double>(x));
  }
  return out;
}

double energy(const ErrorPoint& point, const double* s, double time) {
  const auto kinetic = [](double m, double v) { return 0.5 * m * v * v; };
  const auto spring = [&](double stretch) { return 0.5 * point.stiffness * stretch * stretch; };
  switch (point.which) {
    case Case::kMasses:
      return kinetic(kHandMass, s[1]) + kinetic(kObjectMass, s[3]) + spring(s[0] - s[2]);
    case Case::kHands:
      return kinetic(kHandMass, s[1]) + kinetic(kObjectMass, s[3]) + kinetic(kHandMass, s[5]) +
             spring(s[0] - s[2]) + spring(s[4] - s[2]);
    case Case::kWall:
      return kinetic(kObjectMass, s[1]) + spring(std::max(0.0, s[0] - kGap));
    case Case::kStickSlip: {
      const double stretch = kDrawSpeed * time - s[0];
      return kinetic(kHandMass, s[1]) + 0.5 * kDrawSpring * stretch * stretch;
    }
    case Case::kSlide:
      return kinetic(kObjectMass, s[2]) + kinetic(kObjectMass, s[3]);
    case Case::kSpin: {
      const Eigen::Quaterniond q(s[0], s[1], s[2], s[3]);
      const Eigen::Vector3d w = q.normalized().conjugate() * Eigen::Vector3d(s[4], s[5], s[6]);
      return kinetic(kMoments[0], w.x()) + kinetic(kMoments[1], w.y()) +
             kinetic(kMoments[2], w.z());
    }
  }
  return 0.0;
}

double distance(const ErrorPoint& point, const double* s, const double* t) {
  switch (point.which) {
    case Case::kMasses:
      return std::max(std::abs(s[0] - t[0]), std::abs(s[2] - t[2]));
    case Case::kHands:
      return std::max({std::abs(s[0] - t[0]), std::abs(s[2] - t[2]), std::abs(s[4] - t[4])});
    case Case::kWall:
    case Case::kStickSlip:
      return std::abs(s[0] - t[0]);
    case Case::kSlide:
      return std::hypot(s[0] - t[0], s[1] - t[1]);
    case Case::kSpin: {
      const Eigen::Quaterniond p(s[0], s[1], s[2], s[3]), q(t[0], t[1], t[2], t[3]);
      const Eigen::Quaterniond turn = p.conjugate() * q;
      return 2.0 * std::atan2(turn.vec().norm(), std::abs(turn.w()));
    }
  }
  return 0.0;
}

bool complete(const ErrorPoint& point, const std::vector<double>& samples) {
  if (samples.size() != static_cast<std::size_t>(sample_width(point.which)) * sample_count(point))
    return false;
  for (const double x : samples)
    if (!(std::abs(x) < 1e3)) return false;
  return true;
}

}  // namespace

ErrorReference error_reference(const ErrorPoint& point, int spin_steps) {
  ErrorReference out;
  switch (point.which) {
    case Case::kMasses:
    case Case::kHands:
      out.ideal = true_network(point);
      break;
    case Case::kWall:
      out.ideal = wall(point);
      break;
    case Case::kStickSlip:
      out.ideal = stick_slip(point, true);
      out.law = stick_slip(point, false);
      break;
    case Case::kSlide:
      out.ideal = slide(point);
      break;
    case Case::kSpin:
      out.ideal = spin(point, spin_steps);
      break;
  }
  return out;
}

std::vector<double> law_course(const ErrorPoint& point, const ErrorReference& truth, int hz) {
  if (point.which == Case::kStickSlip) return truth.law;
  if (point.which == Case::kMasses || point.which == Case::kHands) return held_network(point, hz);
  return truth.ideal;
}

double rebound(const ErrorPoint& point) { return -wall(point).back() / kFlight; }

double error_of(const ErrorPoint& point, const std::vector<double>& samples,
                const std::vector<double>& truth) {
  if (!complete(point, samples)) return std::numeric_limits<double>::infinity();
  double worst = 0.0;
  const int width = sample_width(point.which);
  for (int i = 0; i < sample_count(point); ++i)
    worst = std::max(worst, distance(point, &samples[i * width], &truth[i * width]));
  return worst;
}

double energy_drift(const ErrorPoint& point, const std::vector<double>& samples,
                    const std::vector<double>& truth) {
  if (!complete(point, samples)) return std::numeric_limits<double>::infinity();
  double worst = 0.0, most = 0.0;
  const int width = sample_width(point.which);
  for (int i = 0; i < sample_count(point); ++i) {
    const double time = (i + 1.0) / kGridRate;
    const double right = energy(point, &truth[i * width], time);
    worst = std::max(worst, std::abs(energy(point, &samples[i * width], time) - right));
    most = std::max(most, right);
  }
  return worst / most;
}

}  // namespace tandem::bench
