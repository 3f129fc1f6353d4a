#include "analysis/workstations.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "analysis/with_loop.h"
#include "core/simulated_hand.h"

namespace tandem::analysis {

namespace {

using core::Scene;

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

/// Builds the sites and the signals between them.
class Builder {
 public:
  Builder(const Scene& scene, const core::NetworkModel& network)
      : scene_(scene), network_(network) {
    out_.ticks = static_cast<int>(scene.packet_slots().ticks);
    out_.tick = scene.tick();
    if (is_central(scene))
      build_central();
    else
      build_distributed();
    place();
  }
  [[nodiscard]] Workstations take() { return std::move(out_); }

 private:
  [[nodiscard]] int delay(int from, int to) const {
    return static_cast<int>(std::ceil(network_.link[from][to].delay_ticks));
  }

  void build_central() {
    constexpr int kServer = core::NetworkModel::kServer;
    const bool single = scene_.architecture == core::Architecture::kSingle;
    Site& server = out_.sites.emplace_back();
    const int users = static_cast<int>(scene_.users.size());
    for (int u = 0; u < users; ++u)
      if (single || scene_.users[u].local) add_hands(server, u);
    add_objects(server);
    for (int u = 0; u < users; ++u) {
      if (single || scene_.users[u].local) continue;
      Site& client = out_.sites.emplace_back();
      client.user = u;
      add_hands(client, u);
    }
    SiteBuilder center(scene_, out_.sites[0], 1.0);
    std::vector<SiteBuilder> others;
    for (std::size_t s = 1; s < out_.sites.size(); ++s)
      others.emplace_back(scene_, out_.sites[s], 1.0);
    hand_walls(center, out_.sites[0]);

    for (const core::CouplerParameters& c : scene_.couplers) {
      const int u = index(scene_.users, c.user), o = core::index_of(scene_.objects, c.object);
      if (u < 0 || o < 0 || (c.gain.stiffness == 0.0 && c.gain.damping == 0.0)) continue;
      const int object = out_.sites[0].body_of_object(o);
      for (int f = 0; f < static_cast<int>(scene_.users[u].fingers.size()); ++f)
        if (const int hand = out_.sites[0].body_of_hand(u, f); hand >= 0)
          center.couple(hand, object, c.gain);
        else
          center.to_held(object, c.gain);
    }
    center.finish();
    for (SiteBuilder& b : others) b.finish();

    for (int s = 1; s < static_cast<int>(out_.sites.size()); ++s) {
      const int u = out_.sites[s].user;
      for (const core::CouplerParameters& c : scene_.couplers) {
        const int o = core::index_of(scene_.objects, c.object);
        if (c.user != scene_.users[u].name || o < 0) continue;
        if (c.gain.stiffness == 0.0 && c.gain.damping == 0.0) continue;
        const int object = out_.sites[0].body_of_object(o);
        for (int f = 0; f < static_cast<int>(scene_.users[u].fingers.size()); ++f) {
          const int hand = out_.sites[s].body_of_hand(u, f);
          Signal up{s, 0, object, row(out_.sites[s], hand, c.gain), {}, delay(u, kServer)};
          out_.signals.push_back(up);
          Signal down{0,
                      s,
                      hand,
                      row(out_.sites[0], object, c.gain),
                      {static_cast<int>(out_.signals.size()) - 1},
                      delay(kServer, u)};
          out_.signals.push_back(down);
        }
      }
    }
  }

  void build_distributed() {
    const int users = static_cast<int>(scene_.users.size());
    const bool split = scene_.architecture == core::Architecture::kDistributedSplit;
    for (int u = 0; u < users; ++u) {
      Site& site = out_.sites.emplace_back();
      site.user = u;
      add_hands(site, u);
      add_objects(site);
    }
    for (int u = 0; u < users; ++u) {
      Site& site = out_.sites[u];
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
          std::vector<double> c(out_.sites[i].a.rows, 0.0);
          add_row(c, out_.sites[i], out_.sites[i].body_of_object(o), coordination(j, o));
          for (int f = 0; f < static_cast<int>(scene_.users[i].fingers.size()); ++f)
            add_row(c, out_.sites[i], out_.sites[i].body_of_hand(i, f), hand_gain(j, i, o));
          if (std::all_of(c.begin(), c.end(), [](double x) { return x == 0.0; })) continue;
          out_.signals.push_back({i, j, out_.sites[j].body_of_object(o), c, {}, delay(i, j)});
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
    for (Site& site : out_.sites) {
      site.offset = out_.states;
      out_.states += site.a.rows;
    }
    for (Signal& l : out_.signals) {
      const int q = l.delay / out_.ticks, r = l.delay % out_.ticks;
      l.past = r == 0 ? q : q + 1;
      l.first_past = out_.states;
      out_.states += l.past;
    }
  }

  const Scene& scene_;
  const core::NetworkModel& network_;
  Workstations out_;
};

}  // namespace

std::vector<double> Workstations::value(const Signal& l, int age) const {
  std::vector<double> out(states, 0.0);
  if (age > 0) {
    out[l.first_past + age - 1] = 1.0;
    return out;
  }
  for (std::size_t i = 0; i < l.c.size(); ++i) out[sites[l.from].offset + i] = l.c[i];
  for (const int other : l.subtract) {
    const Signal& in = signals[other];
    const std::vector<double> used = value(in, (in.delay + ticks - 1) / ticks);
    for (int i = 0; i < states; ++i) out[i] -= used[i];
  }
  return out;
}

Workstations workstations_of(const Scene& scene, const core::NetworkModel& network) {
  return Builder(scene, network).take();
}

}  // namespace tandem::analysis
