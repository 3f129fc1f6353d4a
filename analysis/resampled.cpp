#include "analysis/resampled.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "analysis/with_loop.h"
#include "core/simulated_hand.h"

namespace tandem::analysis {

namespace {

using core::Scene;

/// A mass of one workstation.
struct Body {
  bool is_hand = false;
  int user = -1, finger = -1, object = -1;
  int state = 0;  ///< index of its position in the site; velocity follows; delayed forces after all
};

/// A workstation over one tick: x+ = a x + sum_b b_l u_l with the inputs of its links held.
struct Site {
  int user = -1;  ///< whose copies these are; -1: the server
  std::vector<Body> bodies;
  Matrix a;         ///< one tick
  Matrix coupled;   ///< column b: change of the state by 1 N of coupler force on body b
  Matrix external;  ///< column b: by 1 N applied from outside
  int offset = 0;   ///< of its states in the whole

  [[nodiscard]] int body_of_hand(int u, int f) const {
    for (std::size_t i = 0; i < bodies.size(); ++i)
      if (bodies[i].is_hand && bodies[i].user == u && bodies[i].finger == f)
        return static_cast<int>(i);
    return -1;
  }
  [[nodiscard]] int body_of_object(int o) const {
    for (std::size_t i = 0; i < bodies.size(); ++i)
      if (!bodies[i].is_hand && bodies[i].object == o) return static_cast<int>(i);
    return -1;
  }
};

/// One signal from site to site: y = c x_from - sum of the signals in use there, held at the other
/// end, where it acts as a force on one body.
struct Signal {
  int from = 0, to = 0, body = 0;
  std::vector<double> c;
  std::vector<int> subtract;  ///< numbers of signals into `from` (the server's reply)
  int delay = 0;              ///< [ticks]
  int first_past = 0;         ///< index of its value one period ago in the whole state
  int past = 0;               ///< how many past values are states
};

int index(const std::vector<core::UserParameters>& users, const std::string& name) {
  for (std::size_t i = 0; i < users.size(); ++i)
    if (users[i].name == name) return static_cast<int>(i);
  return -1;
}

/// Assembles one site: free bodies, then forces between them.
class SiteBuilder {
 public:
  SiteBuilder(const Scene& scene, Site& site, double mass_share) : scene_(scene), site_(site) {
    const int bodies = static_cast<int>(site.bodies.size());
    delay_ = scene.rates.latency_ticks;
    const int n = bodies * (2 + delay_);
    site.a = Matrix(n, n);
    site.coupled = Matrix(n, bodies);
    site.external = Matrix(n, bodies);
    force_ = Matrix(bodies, n);
    direct_ = Matrix(bodies, n);
    for (int b = 0; b < bodies; ++b) {
      site.bodies[b].state = 2 * b;
      free_body(site.bodies[b], b, mass_share);
    }
  }

  void couple(int hand, int object, const core::Gain& g) {
    const int h = site_.bodies[hand].state, o = site_.bodies[object].state;
    add(force_, hand, h, g, -1.0);
    add(force_, hand, o, g, 1.0);
    add(force_, object, o, g, -1.0);
    add(force_, object, h, g, 1.0);
  }
  /// A coupler to something that is held: only the own end moves.
  void to_held(int body, const core::Gain& g) {
    add(force_, body, site_.bodies[body].state, g, -1.0);
  }
  /// Force at the tick, not delayed with the couplers' forces.
  void direct(int body, double stiffness, double damping) {
    add(direct_, body, site_.bodies[body].state, {stiffness, damping}, -1.0);
  }
  void wall_on_hand(int body, const core::Gain& g) { to_held(body, g); }

  void finish() {
    const int bodies = static_cast<int>(site_.bodies.size()), n = site_.a.rows;
    const Matrix input = site_.external;
    for (int b = 0; b < bodies; ++b) {
      if (delay_ == 0) {
        for (int i = 0; i < n; ++i) {
          for (int j = 0; j < n; ++j) site_.a(i, j) += input(i, b) * (force_(b, j) + direct_(b, j));
          site_.coupled(i, b) = input(i, b);
        }
        continue;
      }
      // Forces in the delay line of this body: first in, delay_ ticks later on the mass.
      const int line = 2 * bodies + b * delay_;
      for (int i = 0; i < n; ++i) {
        site_.a(i, line + delay_ - 1) += input(i, b);
        for (int j = 0; j < n; ++j) site_.a(i, j) += input(i, b) * direct_(b, j);
      }
      for (int j = 0; j < n; ++j) site_.a(line, j) += force_(b, j);
      for (int k = 1; k < delay_; ++k) site_.a(line + k, line + k - 1) += 1.0;
      site_.coupled(line, b) = 1.0;
    }
  }

 private:
  static void add(Matrix& m, int row, int state, const core::Gain& g, double sign) {
    m(row, state) += sign * g.stiffness;
    m(row, state + 1) += sign * g.damping;
  }

  void free_body(const Body& body, int b, double mass_share) {
    const double T = scene_.tick();
    const int x = body.state, v = x + 1;
    Matrix& a = site_.a;
    if (body.is_hand) {
      const core::UserParameters& user = scene_.users[body.user];
      const core::FingerParameters& finger = user.fingers[body.finger];
      const auto s = core::second_order_step(finger.hand.stiffness / user.mass,
                                             (finger.hand.damping + finger.damping) / user.mass, T);
      a(x, x) = s.a00, a(x, v) = s.a01, a(v, x) = s.a10, a(v, v) = s.a11;
      site_.external(x, b) = s.b0 / user.mass;
      site_.external(v, b) = s.b1 / user.mass;
      return;
    }
    const double mass = scene_.objects[body.object].mass * mass_share;
    a(x, x) = a(v, v) = 1.0;
    a(x, v) = T;
    site_.external(v, b) = T / mass;
    switch (scene_.integrator) {
      case core::Integrator::kZeroOrderHold:
        site_.external(x, b) = 0.5 * T * T / mass;
        break;
      case core::Integrator::kSemiImplicitEuler:
        site_.external(x, b) = T * T / mass;
        break;
      case core::Integrator::kExplicitEuler:
        break;
    }
    direct(b, 0.0, -scene_.objects[body.object].compensation);
    for (const core::WallParameters& wall : scene_.walls)
      if (wall.touches_objects) direct(b, wall.gain.stiffness, wall.gain.damping);
  }

  const Scene& scene_;
  Site& site_;
  int delay_ = 0;
  Matrix force_, direct_;
};

Matrix product(const Matrix& a, const Matrix& b) {
  Matrix c(a.rows, b.cols);
  for (int i = 0; i < a.rows; ++i)
    for (int k = 0; k < a.cols; ++k) {
      const double x = a(i, k);
      if (x == 0.0) continue;
      for (int j = 0; j < b.cols; ++j) c(i, j) += x * b(k, j);
    }
  return c;
}

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

/// The whole session: sites, signals between them.
class Session {
 public:
  Session(const Scene& scene, const core::NetworkModel& network)
      : scene_(scene), network_(network), N_(scene.ticks_per_packet()) {
    if (is_central(scene))
      build_central();
    else
      build_distributed();
    place();
  }

  [[nodiscard]] LiftedSystem lift() const {
    LiftedSystem out;
    out.period = N_ * scene_.tick();
    out.transition = Matrix(states_, states_);
    std::vector<Power> whole;
    for (const Site& site : sites_) {
      whole.push_back(power_of(site.a, N_));
      out.scale = std::max(out.scale, whole.back().scale);
    }
    Matrix& m = out.transition;
    for (std::size_t s = 0; s < sites_.size(); ++s) {
      const Site& site = sites_[s];
      const double down = std::exp2(whole[s].scale - out.scale);
      for (int i = 0; i < site.a.rows; ++i)
        for (int j = 0; j < site.a.rows; ++j)
          m(site.offset + i, site.offset + j) = whole[s].power(i, j) * down;
    }
    for (const Signal& l : signals_) act(l, whole[l.to], out.scale, m);
    const double unit = std::exp2(-out.scale);
    for (const Signal& l : signals_) {
      if (l.past == 0) continue;
      const std::vector<double> now = value(l, 0);
      for (int j = 0; j < states_; ++j) m(l.first_past, j) = now[j] * unit;
      for (int k = 1; k < l.past; ++k) m(l.first_past + k, l.first_past + k - 1) = unit;
    }
    symmetry(out);
    ports(out, whole);
    return out;
  }

 private:
  [[nodiscard]] int delay(int from, int to) const {
    return static_cast<int>(std::ceil(network_.link[from][to].delay_ticks));
  }

  void build_central() {
    constexpr int kServer = core::NetworkModel::kServer;
    const bool single = scene_.architecture == core::Architecture::kSingle;
    Site& server = sites_.emplace_back();
    const int users = static_cast<int>(scene_.users.size());
    for (int u = 0; u < users; ++u)
      if (single || scene_.users[u].local) add_hands(server, u);
    add_objects(server);
    for (int u = 0; u < users; ++u) {
      if (single || scene_.users[u].local) continue;
      Site& client = sites_.emplace_back();
      client.user = u;
      add_hands(client, u);
    }
    SiteBuilder center(scene_, sites_[0], 1.0);
    std::vector<SiteBuilder> others;
    for (std::size_t s = 1; s < sites_.size(); ++s) others.emplace_back(scene_, sites_[s], 1.0);
    hand_walls(center, sites_[0]);

    for (const core::CouplerParameters& c : scene_.couplers) {
      const int u = index(scene_.users, c.user), o = core::index_of(scene_.objects, c.object);
      if (u < 0 || o < 0 || (c.gain.stiffness == 0.0 && c.gain.damping == 0.0)) continue;
      const int object = sites_[0].body_of_object(o);
      for (int f = 0; f < static_cast<int>(scene_.users[u].fingers.size()); ++f)
        if (const int hand = sites_[0].body_of_hand(u, f); hand >= 0)
          center.couple(hand, object, c.gain);
        else
          center.to_held(object, c.gain);
    }
    center.finish();
    for (SiteBuilder& b : others) b.finish();

    for (int s = 1; s < static_cast<int>(sites_.size()); ++s) {
      const int u = sites_[s].user;
      for (const core::CouplerParameters& c : scene_.couplers) {
        const int o = core::index_of(scene_.objects, c.object);
        if (c.user != scene_.users[u].name || o < 0) continue;
        if (c.gain.stiffness == 0.0 && c.gain.damping == 0.0) continue;
        const int object = sites_[0].body_of_object(o);
        for (int f = 0; f < static_cast<int>(scene_.users[u].fingers.size()); ++f) {
          const int hand = sites_[s].body_of_hand(u, f);
          Signal up{s, 0, object, row(sites_[s], hand, c.gain), {}, delay(u, kServer)};
          signals_.push_back(up);
          Signal down{0,
                      s,
                      hand,
                      row(sites_[0], object, c.gain),
                      {static_cast<int>(signals_.size()) - 1},
                      delay(kServer, u)};
          signals_.push_back(down);
        }
      }
    }
  }

  void build_distributed() {
    const int users = static_cast<int>(scene_.users.size());
    const bool split = scene_.architecture == core::Architecture::kDistributedSplit;
    for (int u = 0; u < users; ++u) {
      Site& site = sites_.emplace_back();
      site.user = u;
      add_hands(site, u);
      add_objects(site);
    }
    for (int u = 0; u < users; ++u) {
      Site& site = sites_[u];
      SiteBuilder builder(scene_, site, split ? 1.0 / users : 1.0);
      hand_walls(builder, site);
      for (int o = 0; o < static_cast<int>(scene_.objects.size()); ++o) {
        const int object = site.body_of_object(o);
        for (int j = 0; j < users; ++j) {
          const core::Gain hand = hand_gain(u, j, o);
          const bool coupled = hand.stiffness != 0.0 || hand.damping != 0.0;
          for (int f = 0; coupled && f < static_cast<int>(scene_.users[j].fingers.size()); ++f)
            if (j == u)
              builder.couple(site.body_of_hand(u, f), object, hand);
            else
              builder.to_held(object, hand);
          if (j != u) builder.to_held(object, coordination(u, o));
        }
      }
      builder.finish();
    }
    for (int i = 0; i < users; ++i)
      for (int j = 0; j < users; ++j) {
        if (i == j) continue;
        for (int o = 0; o < static_cast<int>(scene_.objects.size()); ++o) {
          std::vector<double> c(sites_[i].a.rows, 0.0);
          add_row(c, sites_[i], sites_[i].body_of_object(o), coordination(j, o));
          for (int f = 0; f < static_cast<int>(scene_.users[i].fingers.size()); ++f)
            add_row(c, sites_[i], sites_[i].body_of_hand(i, f), hand_gain(j, i, o));
          if (std::all_of(c.begin(), c.end(), [](double x) { return x == 0.0; })) continue;
          signals_.push_back({i, j, sites_[j].body_of_object(o), c, {}, delay(i, j)});
        }
      }
  }

  void add_hands(Site& site, int u) const {
    for (int f = 0; f < static_cast<int>(scene_.users[u].fingers.size()); ++f)
      site.bodies.push_back({true, u, f, -1});
  }
  void add_objects(Site& site) const {
    for (int o = 0; o < static_cast<int>(scene_.objects.size()); ++o)
      site.bodies.push_back({false, -1, -1, o});
  }
  void hand_walls(SiteBuilder& builder, const Site& site) const {
    for (const core::WallParameters& wall : scene_.walls)
      for (std::size_t b = 0; wall.touches_fingers && b < site.bodies.size(); ++b)
        if (site.bodies[b].is_hand) builder.wall_on_hand(static_cast<int>(b), wall.gain);
  }

  /// Gain of user j's hand on the copy at user u.
  [[nodiscard]] core::Gain hand_gain(int u, int j, int o) const {
    core::Gain gain;
    for (const core::CouplerParameters& c : scene_.couplers)
      if (!c.user.empty() && c.copy == scene_.users[u].name && c.user == scene_.users[j].name &&
          c.object == scene_.objects[o].name)
        gain = c.gain;
    return gain;
  }
  [[nodiscard]] core::Gain coordination(int u, int o) const {
    core::Gain gain;
    for (const core::CouplerParameters& c : scene_.couplers)
      if (c.user.empty() && c.copy == scene_.users[u].name && c.object == scene_.objects[o].name)
        gain = c.gain;
    return gain;
  }

  static void add_row(std::vector<double>& c, const Site& site, int body, const core::Gain& g) {
    c[site.bodies[body].state] += g.stiffness;
    c[site.bodies[body].state + 1] += g.damping;
  }
  static std::vector<double> row(const Site& site, int body, const core::Gain& g) {
    std::vector<double> c(site.a.rows, 0.0);
    add_row(c, site, body, g);
    return c;
  }

  void place() {
    for (Site& site : sites_) {
      site.offset = states_;
      states_ += site.a.rows;
    }
    for (Signal& l : signals_) {
      const int q = l.delay / N_, r = l.delay % N_;
      l.past = r == 0 ? q : q + 1;
      l.first_past = states_;
      states_ += l.past;
    }
  }

  /// Value of a signal `age` packet periods ago, as a row over the whole state.
  [[nodiscard]] std::vector<double> value(const Signal& l, int age) const {
    std::vector<double> out(states_, 0.0);
    if (age > 0) {
      out[l.first_past + age - 1] = 1.0;
      return out;
    }
    for (std::size_t i = 0; i < l.c.size(); ++i) out[sites_[l.from].offset + i] = l.c[i];
    for (const int other : l.subtract) {
      const Signal& in = signals_[other];
      const std::vector<double> used = value(in, (in.delay + N_ - 1) / N_);
      for (int i = 0; i < states_; ++i) out[i] -= used[i];
    }
    return out;
  }

  /// Adds what a signal does to the site it comes to: the sample before last up to tick r of the
  /// period, the newer one from there on.
  void act(const Signal& l, const Power& whole, double scale, Matrix& m) const {
    const Site& site = sites_[l.to];
    const int n = site.a.rows, q = l.delay / N_, r = l.delay % N_;
    std::vector<double> b(n);
    for (int i = 0; i < n; ++i) b[i] = site.coupled(i, l.body);
    const auto add = [&](const std::vector<double>& effect, double down, int age) {
      const std::vector<double> y = value(l, age);
      for (int i = 0; i < n; ++i)
        for (int j = 0; j < states_; ++j)
          if (y[j] != 0.0) m(site.offset + i, j) += effect[i] * down * y[j];
    };
    if (r == 0) {
      add(multiply(whole.sum, b), std::exp2(whole.scale - scale), q);
      return;
    }
    const Power late = power_of(site.a, N_ - r), early = power_of(site.a, r);
    add(multiply(late.power, multiply(early.sum, b)), std::exp2(late.scale + early.scale - scale),
        q + 1);
    add(multiply(late.sum, b), std::exp2(late.scale - scale), q);
  }

  void symmetry(LiftedSystem& out) const {
    out.velocities.assign(states_, 0.0);
    Symmetry t{"translation x", std::vector<double>(states_, 0.0), 0};
    for (const Site& site : sites_)
      for (const Body& body : site.bodies) {
        t.direction[site.offset + body.state] = 1.0;
        out.velocities[site.offset + body.state + 1] = 1.0;
      }
    for (const Signal& l : signals_) {  // a server's reply comes after what it subtracts
      if (l.past == 0) continue;
      const std::vector<double> y = value(l, 0);
      double sum = 0.0;
      for (int j = 0; j < states_; ++j) sum += y[j] * t.direction[j];
      for (int k = 0; k < l.past; ++k) t.direction[l.first_past + k] = sum;
    }
    t.pivot = static_cast<std::size_t>(sites_[0].offset + sites_[0].bodies[0].state);
    out.symmetries.push_back(std::move(t));
    out.grounded = !scene_.walls.empty();
    for (const auto& user : scene_.users)
      for (const auto& finger : user.fingers)
        out.grounded = out.grounded || finger.hand.stiffness > 0.0;
  }

  void ports(LiftedSystem& out, const std::vector<Power>& whole) const {
    const auto port = [&](int s, int b, const std::string& name) {
      const Site& site = sites_[s];
      std::vector<double> column(site.a.rows);
      for (int i = 0; i < site.a.rows; ++i) column[i] = site.external(i, b);
      const std::vector<double> pushed = multiply(whole[s].sum, column);
      ForcePort p{name, std::vector<double>(states_, 0.0), site.offset + site.bodies[b].state,
                  site.offset + site.bodies[b].state + 1};
      for (int i = 0; i < site.a.rows; ++i) p.push[site.offset + i] = pushed[i];
      out.ports.push_back(std::move(p));
    };
    for (int u = 0; u < static_cast<int>(scene_.users.size()); ++u)
      for (int f = 0; f < static_cast<int>(scene_.users[u].fingers.size()); ++f)
        for (int s = 0; s < static_cast<int>(sites_.size()); ++s)
          if (const int b = sites_[s].body_of_hand(u, f); b >= 0)
            port(s, b, scene_.users[u].name + "." + scene_.users[u].fingers[f].name);
    for (int s = 0; s < static_cast<int>(sites_.size()); ++s)
      for (int o = 0; o < static_cast<int>(scene_.objects.size()); ++o)
        if (const int b = sites_[s].body_of_object(o); b >= 0)
          port(s, b,
               scene_.objects[o].name +
                   (sites_[s].user < 0 ? "" : "@" + scene_.users[sites_[s].user].name));
  }

  const Scene& scene_;
  const core::NetworkModel& network_;
  int N_ = 1, states_ = 0;
  std::vector<Site> sites_;
  std::vector<Signal> signals_;
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
  return {};
}

LiftedSystem resampled_system(const Scene& scene, const core::NetworkModel& network) {
  if (const std::string why = why_not_resampled(scene, network); !why.empty())
    throw std::domain_error(why);
  return Session(scene, network).lift();
}

}  // namespace tandem::analysis
