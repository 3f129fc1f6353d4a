#include "analysis/resampled.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "analysis/workstations.h"

namespace tandem::analysis {

namespace {

using core::Scene;

Matrix identity(int n) {
  Matrix m(n, n);
  for (int i = 0; i < n; ++i) m(i, i) = 1.0;
  return m;
}

/// A^n and I + A + ... + A^(n-1), both times 2^-scale, by doubling.
struct Power {
  Matrix power, sum;
  double scale = 0.0;
};

void shrink(Power& p) {
  double largest = 0.0;
  for (const Matrix* m : {&p.power, &p.sum})
    for (const double x : m->values) largest = std::max(largest, std::abs(x));
  if (!(largest > 1e120) || !std::isfinite(largest)) return;
  const int e = std::ilogb(largest);
  for (Matrix* m : {&p.power, &p.sum})
    for (double& x : m->values) x = std::ldexp(x, -e);
  p.scale += e;
}

Power power_of(const Matrix& a, int n) {
  const Matrix one = identity(a.rows);
  Power p{one, Matrix(a.rows, a.rows), 0.0};
  for (int bit = 30; bit >= 0; --bit) {
    const auto grow = [&](const Matrix& m, const Matrix& s, const Power& old) {
      // from (A^k, S_k) with A^j, S_j: A^(j+k), S_k + A^k S_j
      return Power{product(old.power, m),
                   [&] {
                     Matrix t = product(old.power, s);
                     // S_k is held at old.scale, S_j unscaled when j = 1.
                     for (std::size_t i = 0; i < t.values.size(); ++i)
                       t.values[i] += old.sum.values[i];
                     return t;
                   }(),
                   old.scale};
    };
    if (p.scale == 0.0 && (n >> bit) > 1) {
      p = grow(p.power, p.sum, p);
    } else if ((n >> bit) > 1) {
      // 2^-s A^k times 2^-s A^k carries 2^-2s; the single sum is 2^s too small beside it.
      Power next{product(p.power, p.power), product(p.power, p.sum), 2.0 * p.scale};
      for (std::size_t i = 0; i < next.sum.values.size(); ++i)
        next.sum.values[i] += std::ldexp(p.sum.values[i], -static_cast<int>(p.scale));
      p = next;
    }
    if ((n >> bit) & 1) p = grow(a, one, p);
    shrink(p);
  }
  return p;
}

/// Joins the workstations of a session to its map over a packet period.
class Session {
 public:
  Session(const Scene& scene, const core::NetworkModel& network)
      : scene_(scene), w_(workstations_of(scene, network)) {}

  [[nodiscard]] LiftedSystem lift() const {
    LiftedSystem out;
    out.period = w_.ticks * scene_.tick();
    out.transition = Matrix(w_.states, w_.states);
    std::vector<Power> whole;
    for (const Site& site : w_.sites) {
      whole.push_back(power_of(site.a, w_.ticks));
      out.scale = std::max(out.scale, whole.back().scale);
    }
    Matrix& m = out.transition;
    for (std::size_t s = 0; s < w_.sites.size(); ++s) {
      const Site& site = w_.sites[s];
      const double down = std::exp2(whole[s].scale - out.scale);
      for (int i = 0; i < site.a.rows; ++i)
        for (int j = 0; j < site.a.rows; ++j)
          m(site.offset + i, site.offset + j) = whole[s].power(i, j) * down;
    }
    for (const Signal& l : w_.signals) act(l, whole[l.to], out.scale, m);
    const double unit = std::exp2(-out.scale);
    for (const Signal& l : w_.signals) {
      if (l.past == 0) continue;
      const std::vector<double> now = w_.value(l, 0);
      for (int j = 0; j < w_.states; ++j) m(l.first_past, j) = now[j] * unit;
      for (int k = 1; k < l.past; ++k) m(l.first_past + k, l.first_past + k - 1) = unit;
    }
    symmetry(out);
    ports(out, whole);
    return out;
  }

 private:
  /// Adds what a signal does to the site it comes to: the sample before last up to tick r of the
  /// period, the newer one from there on.
  void act(const Signal& l, const Power& whole, double scale, Matrix& m) const {
    const Site& site = w_.sites[l.to];
    const int n = site.a.rows, q = l.delay / w_.ticks, r = l.delay % w_.ticks;
    std::vector<double> b(n);
    for (int i = 0; i < n; ++i) b[i] = site.coupled(i, l.body);
    const auto add = [&](const std::vector<double>& effect, double down, int age) {
      const std::vector<double> y = w_.value(l, age);
      for (int i = 0; i < n; ++i)
        for (int j = 0; j < w_.states; ++j)
          if (y[j] != 0.0) m(site.offset + i, j) += effect[i] * down * y[j];
    };
    if (r == 0) {
      add(multiply(whole.sum, b), std::exp2(whole.scale - scale), q);
      return;
    }
    const Power late = power_of(site.a, w_.ticks - r), early = power_of(site.a, r);
    add(multiply(late.power, multiply(early.sum, b)), std::exp2(late.scale + early.scale - scale),
        q + 1);
    add(multiply(late.sum, b), std::exp2(late.scale - scale), q);
  }

  void symmetry(LiftedSystem& out) const {
    out.velocities.assign(w_.states, 0.0);
    Symmetry t{"translation x", std::vector<double>(w_.states, 0.0), 0};
    for (const Site& site : w_.sites)
      for (const Body& body : site.bodies) {
        t.direction[site.offset + body.state] = 1.0;
        out.velocities[site.offset + body.state + 1] = 1.0;
      }
    for (const Signal& l : w_.signals) {  // a server's reply comes after what it subtracts
      if (l.past == 0) continue;
      const std::vector<double> y = w_.value(l, 0);
      double sum = 0.0;
      for (int j = 0; j < w_.states; ++j) sum += y[j] * t.direction[j];
      for (int k = 0; k < l.past; ++k) t.direction[l.first_past + k] = sum;
    }
    t.pivot = static_cast<std::size_t>(w_.sites[0].offset + w_.sites[0].bodies[0].state);
    out.symmetries.push_back(std::move(t));
    out.grounded = !scene_.walls.empty();
    for (const auto& user : scene_.users)
      for (const auto& finger : user.fingers)
        out.grounded = out.grounded || finger.hand.stiffness > 0.0;
  }

  void ports(LiftedSystem& out, const std::vector<Power>& whole) const {
    const auto port = [&](int s, int b, const std::string& name) {
      const Site& site = w_.sites[s];
      std::vector<double> column(site.a.rows);
      for (int i = 0; i < site.a.rows; ++i) column[i] = site.external(i, b);
      const std::vector<double> pushed = multiply(whole[s].sum, column);
      ForcePort p{name, std::vector<double>(w_.states, 0.0), site.offset + site.bodies[b].state,
                  site.offset + site.bodies[b].state + 1};
      for (int i = 0; i < site.a.rows; ++i) p.push[site.offset + i] = pushed[i];
      out.ports.push_back(std::move(p));
    };
    for (int u = 0; u < static_cast<int>(scene_.users.size()); ++u)
      for (int f = 0; f < static_cast<int>(scene_.users[u].fingers.size()); ++f)
        for (int s = 0; s < static_cast<int>(w_.sites.size()); ++s)
          if (const int b = w_.sites[s].body_of_hand(u, f); b >= 0)
            port(s, b, scene_.users[u].name + "." + scene_.users[u].fingers[f].name);
    for (int s = 0; s < static_cast<int>(w_.sites.size()); ++s)
      for (int o = 0; o < static_cast<int>(scene_.objects.size()); ++o)
        if (const int b = w_.sites[s].body_of_object(o); b >= 0)
          port(s, b,
               scene_.objects[o].name +
                   (w_.sites[s].user < 0 ? "" : "@" + scene_.users[w_.sites[s].user].name));
  }

  const Scene& scene_;
  const Workstations w_;
};

}  // namespace

std::string why_not_resampled(const Scene& scene, const core::NetworkModel& network) {
  if (scene.space != core::Space::kAxis) return "only axis scenes are resampled";
  if (scene.reconstruction.kind != core::ReconstructionKind::kHold)
    return "extrapolated samples change within a packet period";
  if (!scene.contact.attached) return "contacts may open";
  for (const auto& wall : scene.walls)
    if (!wall.attached) return "walls may be left";
  const bool central = scene.architecture == core::Architecture::kCentral;
  for (const auto& wall : scene.walls)
    if (central && wall.touches_fingers) return "a wall at the server touches a remote finger";
  if (central && scene.rates.latency_ticks > 0) return "computation delay inside a server's reply";
  for (const int phase : network.phase_ticks)
    if (phase != 0) return "packets leave at different phases";
  if (scene.packet_slots().packets != 1) return "packet periods differ in ticks";
  return {};
}

LiftedSystem resampled_system(const Scene& scene, const core::NetworkModel& network) {
  if (const std::string why = why_not_resampled(scene, network); !why.empty())
    throw std::domain_error(why);
  return Session(scene, network).lift();
}

}  // namespace tandem::analysis
