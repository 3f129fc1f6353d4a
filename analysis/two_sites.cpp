#include "analysis/two_sites.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

namespace tandem::analysis {

namespace {

constexpr int kMaxDelay = 24;
constexpr int kMaxDegree = 8 + kMaxDelay;

struct Polynomial {
  int degree = 0;
  std::array<double, kMaxDegree + 1> c{};
};

Polynomial product(const Polynomial& a, const Polynomial& b) noexcept {
  Polynomial p;
  p.degree = a.degree + b.degree;
  for (int i = 0; i <= a.degree; ++i)
    for (int j = 0; j <= b.degree; ++j) p.c[i + j] += a.c[i] * b.c[j];
  return p;
}

/// Powers of (1 + x) and of (1 - x / 2).
struct Binomials {
  double plus[kMaxDegree + 1][kMaxDegree + 1] = {};
  double half[kMaxDegree + 1][kMaxDegree + 1] = {};
  Binomials() noexcept {
    for (int n = 0; n <= kMaxDegree; ++n) {
      plus[n][0] = 1.0;
      for (int k = 1; k <= n; ++k) plus[n][k] = plus[n][k - 1] * (n - k + 1) / k;
      double f = 1.0;
      for (int k = 0; k <= n; ++k, f *= -0.5) half[n][k] = plus[n][k] * f;
    }
  }
};
const Binomials kBinomials;

Polynomial times_z_to(Polynomial p, int d) noexcept {
  if (d == 0) return p;
  Polynomial z;
  z.degree = d;
  for (int k = 0; k <= d; ++k) z.c[k] = kBinomials.plus[d][k];
  return product(p, z);
}

/// A workstation with n states over m ticks: E = A^m - I and the effect b of a force held so long.
template <int n>
struct Carried {
  double e[n][n];
  double b[n];
};

/// A^(i+j) - I = E_i + E_j + E_i E_j, and likewise the held force.
template <int n>
Carried<n> then(const Carried<n>& first, const Carried<n>& second) noexcept {
  Carried<n> out;
  for (int r = 0; r < n; ++r) {
    out.b[r] = first.b[r] + second.b[r];
    for (int c = 0; c < n; ++c) out.e[r][c] = first.e[r][c] + second.e[r][c];
    for (int k = 0; k < n; ++k) {
      out.b[r] += second.e[r][k] * first.b[k];
      for (int c = 0; c < n; ++c) out.e[r][c] += second.e[r][k] * first.e[k][c];
    }
  }
  return out;
}

template <int n>
Carried<n> carry(const Carried<n>& tick, int ticks) noexcept {
  int bit = 0;
  while ((ticks >> (bit + 1)) != 0) ++bit;
  Carried<n> out = tick;
  while (--bit >= 0) {
    out = then(out, out);
    if ((ticks >> bit) & 1) out = then(out, tick);
  }
  return out;
}

/// det(w I - E) from sums of principal minors: no cancellation between powers of E.
Polynomial characteristic(const double (&e)[2][2]) noexcept {
  Polynomial p;
  p.degree = 2;
  p.c[0] = e[0][0] * e[1][1] - e[0][1] * e[1][0];
  p.c[1] = -(e[0][0] + e[1][1]);
  p.c[2] = 1.0;
  return p;
}

Polynomial characteristic(const double (&e)[4][4]) noexcept {
  const auto minor2 = [&](int r0, int r1, int c0, int c1) {
    return e[r0][c0] * e[r1][c1] - e[r0][c1] * e[r1][c0];
  };
  // Minors of the upper and lower pair of rows, columns in order 01 02 03 12 13 23.
  double u[6], l[6];
  int k = 0;
  for (int a = 0; a < 4; ++a)
    for (int b = a + 1; b < 4; ++b, ++k) u[k] = minor2(0, 1, a, b), l[k] = minor2(2, 3, a, b);
  Polynomial p;
  p.degree = 4;
  p.c[4] = 1.0;
  p.c[3] = -(e[0][0] + e[1][1] + e[2][2] + e[3][3]);
  p.c[2] = u[0] + minor2(0, 2, 0, 2) + minor2(0, 3, 0, 3) + minor2(1, 2, 1, 2) +
           minor2(1, 3, 1, 3) + l[5];
  const double m012 = u[0] * e[2][2] - u[1] * e[2][1] + u[3] * e[2][0];
  const double m013 = u[0] * e[3][3] - u[2] * e[3][1] + u[4] * e[3][0];
  const double m023 = e[0][0] * l[5] - e[0][2] * l[2] + e[0][3] * l[1];
  const double m123 = e[1][1] * l[5] - e[1][2] * l[4] + e[1][3] * l[3];
  p.c[1] = -(m012 + m013 + m023 + m123);
  p.c[0] = u[0] * l[5] - u[1] * l[4] + u[2] * l[3] + u[3] * l[2] - u[4] * l[1] + u[5] * l[0];
  return p;
}

/// c adj(w I - E) b.
template <int n>
Polynomial numerator(const Carried<n>& site, const double (&c)[n], const Polynomial& den) noexcept {
  double markov[n];
  double x[n];
  std::copy_n(site.b, n, x);
  for (int k = 0; k < n; ++k) {
    markov[k] = 0.0;
    for (int i = 0; i < n; ++i) markov[k] += c[i] * x[i];
    double next[n] = {};
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j) next[i] += site.e[i][j] * x[j];
    std::copy_n(next, n, x);
  }
  Polynomial p;
  p.degree = n - 1;
  for (int power = 0; power < n; ++power)
    for (int k = 0; k <= n - 1 - power; ++k) p.c[power] += den.c[power + 1 + k] * markov[k];
  return p;
}

/// Smallest entry of Routh's first column of p under w = s / (1 - s / 2), each against what was
/// subtracted to get it. Positive: all roots of p inside |1 + w| < 1.
double routh_margin(const Polynomial& p) noexcept {
  const int m = p.degree;
  if (m == 0) return 1.0;
  double r[kMaxDegree + 1] = {};
  for (int k = 0; k <= m; ++k)
    for (int j = 0; j <= m - k; ++j) r[k + j] += p.c[k] * kBinomials.half[m - k][j];
  double sum = 0.0, largest = 0.0;
  for (int k = 0; k <= m; ++k) {
    sum += r[k];
    largest = std::max(largest, std::abs(r[k]));
  }
  if (!(largest > 0.0) || !std::isfinite(largest)) return -1.0;
  const double sign = sum < 0.0 ? -1.0 : 1.0;
  for (int k = 0; k <= m; ++k) r[k] *= sign;
  // s is per packet period and of order one; r[m] and r[0] vanish with a root at z = -1 and z = 1.
  double least = std::min({r[m], r[m - 1], r[0]}) / largest;
  double above[kMaxDegree / 2 + 2] = {}, row[kMaxDegree / 2 + 2] = {};
  int length = 0;
  for (int k = m, i = 0; k >= 0; k -= 2, ++i) {
    above[i] = r[k];
    row[i] = k > 0 ? r[k - 1] : 0.0;
    length = i + 1;
  }
  for (int step = 2; step <= m; ++step) {
    if (row[0] == 0.0) return -1e-300;
    const double f = above[0] / row[0];
    for (int i = 0; i + 1 < length; ++i) {
      const double subtracted = f * row[i + 1], next = above[i + 1] - subtracted;
      if (i == 0) least = std::min(least, next / (std::abs(above[1]) + std::abs(subtracted)));
      above[i] = row[i];
      row[i] = next;
    }
    above[length - 1] = row[length - 1];
    row[length - 1] = 0.0;
  }
  return least;
}

Polynomial without_root_at_one(Polynomial p) noexcept {
  for (int k = 0; k < p.degree; ++k) p.c[k] = p.c[k + 1];
  p.c[p.degree--] = 0.0;
  return p;
}

Polynomial sum(Polynomial a, const Polynomial& b, double factor) noexcept {
  a.degree = std::max(a.degree, b.degree);
  for (int k = 0; k <= b.degree; ++k) a.c[k] += factor * b.c[k];
  return a;
}

struct Ends {
  Polynomial p, q;
};

/// Positions in metres, velocities in metres a packet period: all entries are of order one.
struct Units {
  double T, period;
  int N;
};

struct Pair {
  double k = 0.0, b = 0.0;
};

/// Hand and object of one workstation; a force on the object in, `out` of hand and object out.
Carried<4> hand_and_object(const Units& u, double mh, double mo, Pair own, Pair ground,
                           core::Integrator integrator) noexcept {
  Carried<4> tick{};
  const double step = u.T / u.period, fh = u.period * u.T / mh, fo = u.period * u.T / mo;
  const double xh = 0.5 * u.T * u.T / mh;
  const double xo = (integrator == core::Integrator::kZeroOrderHold       ? 0.5
                     : integrator == core::Integrator::kSemiImplicitEuler ? 1.0
                                                                          : 0.0) *
                    u.T * u.T / mo;
  const double ob = own.b / u.period, gb = ground.b / u.period;
  const double hand[4] = {-own.k, -ob, own.k, ob};
  const double object[4] = {own.k, ob, -own.k - ground.k, -ob - gb};
  for (int c = 0; c < 4; ++c) {
    tick.e[0][c] = xh * hand[c];
    tick.e[1][c] = fh * hand[c];
    tick.e[2][c] = xo * object[c];
    tick.e[3][c] = fo * object[c];
  }
  tick.e[0][1] += step;
  tick.e[2][3] += step;
  tick.b[2] = xo;
  tick.b[3] = fo;
  return carry(tick, u.N);
}

}  // namespace

std::optional<TwoSites> TwoSites::of(const core::Scene& scene, const core::NetworkModel& network) {
  using core::Architecture;
  TwoSites out;
  if (scene.space != core::Space::kAxis || scene.architecture == Architecture::kSingle ||
      scene.users.size() != 2 || scene.objects.size() != 1 || !scene.contact.attached ||
      scene.rates.latency_ticks != 0 ||
      scene.reconstruction.kind != core::ReconstructionKind::kHold)
    return std::nullopt;
  for (const core::UserParameters& user : scene.users) {
    if (user.fingers.size() != 1) return std::nullopt;
    const core::FingerParameters& finger = user.fingers[0];
    if (finger.hand.stiffness != 0.0 || finger.hand.damping != 0.0 || finger.damping != 0.0)
      return std::nullopt;
  }
  for (const core::WallParameters& wall : scene.walls)
    if (!wall.attached || wall.touches_fingers) return std::nullopt;
  for (const int phase : network.phase_ticks)
    if (phase != 0) return std::nullopt;
  const core::PacketSlots slots = scene.packet_slots();
  if (slots.packets != 1) return std::nullopt;
  out.N_ = static_cast<int>(slots.ticks);
  out.T_ = scene.tick();
  out.walls_ = !scene.walls.empty();
  out.central_ = scene.architecture == Architecture::kCentral;
  out.split_ = scene.architecture == Architecture::kDistributedSplit;

  double ticks = 0.0;
  if (out.central_) {
    out.local_ = scene.users[0].local ? 0 : 1;
    out.remote_ = 1 - out.local_;
    if (!scene.users[out.local_].local || scene.users[out.remote_].local) return std::nullopt;
    constexpr int kServer = core::NetworkModel::kServer;
    for (const double t : {network.link[out.remote_][kServer].delay_ticks,
                           network.link[kServer][out.remote_].delay_ticks}) {
      if (std::fmod(t, out.N_) != 0.0) return std::nullopt;
      ticks += t;
    }
  } else {
    for (const double t : {network.link[0][1].delay_ticks, network.link[1][0].delay_ticks}) {
      if (std::fmod(t, out.N_) != 0.0) return std::nullopt;
      ticks += t;
    }
  }
  if (ticks / out.N_ > kMaxDelay) return std::nullopt;
  out.d_ = static_cast<int>(ticks / out.N_);

  for (std::size_t i = 0; i < scene.couplers.size(); ++i) {
    const core::CouplerParameters& c = scene.couplers[i];
    const int user = core::index_of(scene.users, c.user);
    const int copy = out.central_ ? 0 : core::index_of(scene.users, c.copy);
    if (copy < 0 || (user < 0 && !c.user.empty())) return std::nullopt;
    Coupler& place = user < 0 ? out.object_[copy] : out.hand_[copy][user];
    if (place.index >= 0) return std::nullopt;
    place.index = static_cast<int>(i);
  }
  return out;
}

double TwoSites::margin(const core::Scene& scene) const noexcept {
  const Units u{T_, N_ * T_, N_};
  const auto gain = [&](Coupler c) {
    if (c.index < 0) return Pair{};
    const core::Gain& g = scene.couplers[c.index].gain;
    return Pair{g.stiffness, g.damping};
  };
  Pair ground{0.0, -scene.objects[0].compensation};
  for (const core::WallParameters& wall : scene.walls) {
    if (!wall.touches_objects) continue;
    ground.k += wall.gain.stiffness;
    ground.b += wall.gain.damping;
  }
  const double mo = scene.objects[0].mass * (split_ ? 0.5 : 1.0);
  // Translation is kept; so is uniform motion where nothing that is held is older than it seems.
  const auto without_free_motion = [&](Polynomial p, bool drifts) {
    if (walls_) return p;
    p = without_root_at_one(p);
    return drifts && ground.b == 0.0 ? without_root_at_one(p) : p;
  };

  // A hand that nothing holds adds free motions of its own: not of this form, and zero says so.
  const auto none = [](Pair a) { return a.k == 0.0 && a.b == 0.0; };
  if (central_) {
    const Pair k2 = gain(hand_[0][remote_]);
    if (none(k2) || none(gain(hand_[0][local_]))) return 0.0;
    const Carried<4> server =
        hand_and_object(u, scene.users[local_].mass, mo, gain(hand_[0][local_]),
                        {ground.k + k2.k, ground.b + k2.b}, scene.integrator);
    const double out[4] = {0.0, 0.0, k2.k, k2.b / u.period};
    const Polynomial p = characteristic(server.e), q = numerator(server, out, p);
    Carried<2> hand{};
    const double f = u.period / scene.users[remote_].mass * u.period;
    hand.e[0][1] = 1.0;  // free over the whole packet period
    hand.b[0] = 0.5 * f;
    hand.b[1] = f;
    const double sent[2] = {k2.k, k2.b / u.period};
    const Polynomial pr = characteristic(hand.e), qr = numerator(hand, sent, pr);
    const Polynomial whole =
        sum(times_z_to(product(p, pr), d_), product(qr, sum(q, p, -1.0)), -1.0);
    return routh_margin(without_free_motion(whole, N_ == 1));
  }

  Polynomial p[2], q[2];
  Pair own[2], other[2], object[2];
  for (int i = 0; i < 2; ++i) {
    own[i] = gain(hand_[i][i]);
    other[i] = gain(hand_[i][1 - i]);
    object[i] = gain(object_[i]);
  }
  if (none(own[0]) || none(own[1])) return 0.0;
  const auto same = [](Pair a, Pair b) { return a.k == b.k && a.b == b.b; };
  const bool equal = same(own[0], own[1]) && same(other[0], other[1]) &&
                     same(object[0], object[1]) && scene.users[0].mass == scene.users[1].mass;
  for (int i = 0; i < (equal ? 1 : 2); ++i) {
    const Carried<4> site =
        hand_and_object(u, scene.users[i].mass, mo, own[i],
                        {ground.k + other[i].k + object[i].k, ground.b + other[i].b + object[i].b},
                        scene.integrator);
    const Pair h = other[1 - i], o = object[1 - i];  // the couplers at the other end
    const double out[4] = {h.k, h.b / u.period, o.k, o.b / u.period};
    p[i] = characteristic(site.e);
    q[i] = numerator(site, out, p[i]);
  }
  if (equal && d_ % 2 == 0) {
    const Polynomial delayed = times_z_to(p[0], d_ / 2);
    const Polynomial together = sum(delayed, q[0], -1.0), against = sum(delayed, q[0], 1.0);
    return std::min(routh_margin(without_free_motion(together, N_ == 1 && d_ == 0)),
                    routh_margin(against));
  }
  const Polynomial whole = sum(times_z_to(product(p[0], equal ? p[0] : p[1]), d_),
                               product(q[0], equal ? q[0] : q[1]), -1.0);
  return routh_margin(without_free_motion(whole, N_ == 1 && d_ == 0));
}

}  // namespace tandem::analysis
