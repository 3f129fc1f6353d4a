#include "analysis/workstations.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "analysis/with_loop.h"

namespace tandem::analysis {

namespace {

using core::Scene;

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
  [[nodiscard]] double age_error(int from, int to) const {
    return network_.link[from][to].age_error_ticks;
  }
  [[nodiscard]] int users() const { return static_cast<int>(scene_.users.size()); }
  [[nodiscard]] int objects() const { return static_cast<int>(scene_.objects.size()); }
  [[nodiscard]] int fingers(int u) const {
    return static_cast<int>(scene_.users[u].fingers.size());
  }
  [[nodiscard]] bool extrapolates() const {
    return scene_.reconstruction.kind == core::ReconstructionKind::kExtrapolate;
  }

  void build_central() {
    const bool single = scene_.architecture == core::Architecture::kSingle;
    const auto at_server = [&](int u) { return single || scene_.users[u].local; };
    out_.sites.emplace_back();
    for (int u = 0; u < users(); ++u)
      if (at_server(u)) out_.sites[0].add_hand(scene_, u);
    out_.sites[0].add_objects(scene_);
    for (int u = 0; u < users(); ++u) {
      if (at_server(u)) continue;
      Workstation& client = out_.sites.emplace_back();
      client.user = u;
      client.add_hand(scene_, u);
    }
    std::vector<WorkstationBuilder> builders;
    for (Workstation& site : out_.sites) builders.emplace_back(scene_, site, 1.0);
    hand_walls(builders[0], out_.sites[0]);
    for_each_grasp([&](const core::CouplerParameters&, int u, int f, int o, const Spring& s) {
      const Workstation& server = out_.sites[0];
      builders[0].spring(server.ends(s, server.of_finger(u, f), server.of_object(o)), s.gain);
    });
    for (WorkstationBuilder& b : builders) b.finish();
    for_each_grasp([&](const core::CouplerParameters&, int u, int f, int o, const Spring& s) {
      if (at_server(u)) return;
      int site = 1;
      while (out_.sites[site].user != u) ++site;
      exchange(site, u, f, o, s);
    });
  }

  /// A remote finger's spring: its end goes up, pushes the object, and the force comes back.
  void exchange(int site, int u, int f, int o, const Spring& s) {
    constexpr int kServer = core::NetworkModel::kServer;
    const auto finger = out_.sites[site].ends(s, out_.sites[site].of_finger(u, f), -1);
    const auto object = out_.sites[0].ends(s, -1, out_.sites[0].of_object(o));
    const int up_delay = delay(u, kServer);
    const int replied = (up_delay + out_.ticks - 1) / out_.ticks * out_.ticks;
    const double error = age_error(u, kServer);
    const double used = std::max(0.0, replied + error);  // age of what it replies to [ticks]
    Signal down{0, site, minus(finger), row(out_.sites[0], object, s.gain), {}, delay(kServer, u)};
    for (const bool by_age : {false, true}) {
      if (by_age && !extrapolates()) continue;
      Signal up{site, 0,        minus(object), row(out_.sites[site], finger, s.gain, by_age),
                {},   up_delay, by_age,        error};
      down.add.emplace_back(static_cast<int>(out_.signals.size()),
                            by_age ? used * scene_.tick() : 1.0);
      out_.signals.push_back(std::move(up));
    }
    out_.signals.push_back(std::move(down));
  }

  void build_distributed() {
    const bool split = scene_.architecture == core::Architecture::kDistributedSplit;
    for (int u = 0; u < users(); ++u) {
      Workstation& site = out_.sites.emplace_back();
      site.user = u;
      site.add_hand(scene_, u);
      site.add_objects(scene_);
    }
    for (int u = 0; u < users(); ++u) {
      Workstation& site = out_.sites[u];
      WorkstationBuilder builder(scene_, site, split ? 1.0 / users() : 1.0);
      hand_walls(builder, site);
      for_each_grasp([&](const core::CouplerParameters& c, int j, int f, int o, const Spring& s) {
        if (c.copy == scene_.users[u].name)
          builder.spring(site.ends(s, j == u ? site.of_finger(u, f) : -1, site.of_object(o)),
                         s.gain);
      });
      for_each_coordination(u, [&](int o, const Spring& s) {
        for (int j = 0; j < users(); ++j)
          if (j != u) builder.spring(site.ends(s, -1, site.of_object(o)), s.gain);
      });
      builder.finish();
    }
    for (int i = 0; i < users(); ++i)
      for (int j = 0; j < users(); ++j)
        if (i != j) send(i, j);
  }

  /// What user i's fingers and copies do to the copies at j: one signal a coordinate of each copy.
  void send(int i, int j) {
    const Workstation &from = out_.sites[i], &to = out_.sites[j];
    const std::size_t m = to.coordinates.size();
    std::vector<std::vector<double>> held(m), aged(m);
    const auto collect = [&](const Spring& s, const std::vector<double>& there,
                             const std::vector<double>& here) {
      for (std::size_t a = 0; a < m; ++a) {
        if (here[a] == 0.0) continue;
        for (const bool by_age : {false, true}) {
          std::vector<double>& c = (by_age ? aged : held)[a];
          const std::vector<double> add = row(from, there, s.gain, by_age);
          c.resize(add.size(), 0.0);
          for (std::size_t k = 0; k < c.size(); ++k) c[k] -= here[a] * add[k];
        }
      }
    };
    for_each_coordination(j, [&](int o, const Spring& s) {
      collect(s, minus(from.ends(s, -1, from.of_object(o))), to.ends(s, -1, to.of_object(o)));
    });
    for_each_grasp([&](const core::CouplerParameters& c, int u, int f, int o, const Spring& s) {
      if (u == i && c.copy == scene_.users[j].name)
        collect(s, from.ends(s, from.of_finger(i, f), -1), to.ends(s, -1, to.of_object(o)));
    });
    for (std::size_t a = 0; a < m; ++a)
      for (const bool by_age : {false, true}) {
        std::vector<double>& c = (by_age ? aged : held)[a];
        if (by_age && !extrapolates()) continue;
        if (std::all_of(c.begin(), c.end(), [](double x) { return x == 0.0; })) continue;
        std::vector<double> push(m, 0.0);
        push[a] = 1.0;
        out_.signals.push_back(
            {i, j, std::move(push), std::move(c), {}, delay(i, j), by_age, age_error(i, j)});
      }
  }

  void hand_walls(WorkstationBuilder& builder, const Workstation& site) const {
    if (scene_.space != core::Space::kAxis) return;
    for (const core::WallParameters& wall : scene_.walls)
      for (std::size_t i = 0; wall.touches_fingers && i < site.coordinates.size(); ++i)
        if (site.coordinates[i].is_hand()) builder.to_ground(static_cast<int>(i), wall.gain);
  }

  /// use(coupler, user, finger, object, spring) for every spring of every hand's coupler.
  template <typename Use>
  void for_each_grasp(Use&& use) const {
    for (const core::CouplerParameters& c : scene_.couplers) {
      const int u = c.user.empty() ? -1 : core::index_of(scene_.users, c.user);
      const int o = core::index_of(scene_.objects, c.object);
      if (u < 0 || o < 0) continue;
      for (int f = 0; f < fingers(u); ++f)
        for (const Spring& s : grasp_springs(scene_, c, u, f, o)) use(c, u, f, o, s);
    }
  }
  /// use(object, spring) for every spring that holds the copies at u to the others.
  template <typename Use>
  void for_each_coordination(int u, Use&& use) const {
    for (const core::CouplerParameters& c : scene_.couplers) {
      const int o = core::index_of(scene_.objects, c.object);
      if (!c.user.empty() || c.copy != scene_.users[u].name || o < 0) continue;
      for (const Spring& s : coordination_springs(scene_, c)) use(o, s);
    }
  }

  /// Force of a spring from its ends at `site`; `by_age`: how it grows with the age of the sample.
  static std::vector<double> row(const Workstation& site, const std::vector<double>& ends,
                                 const core::Gain& g, bool by_age = false) {
    std::vector<double> c(site.a.rows, 0.0);
    for (std::size_t i = 0; i < ends.size(); ++i) {
      if (!by_age) c[2 * i] = g.stiffness * ends[i];
      c[2 * i + 1] = (by_age ? g.stiffness : g.damping) * ends[i];
    }
    return c;
  }
  static std::vector<double> minus(std::vector<double> x) {
    for (double& v : x) v = -v;
    return x;
  }

  void place() {
    for (Workstation& site : out_.sites) {
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
  for (const auto& [other, factor_of_other] : l.add) {
    const Signal& in = signals[other];
    const std::vector<double> used = value(in, (in.delay + ticks - 1) / ticks);
    for (int i = 0; i < states; ++i) out[i] += factor_of_other * used[i];
  }
  return out;
}

Workstations workstations_of(const Scene& scene, const core::NetworkModel& network) {
  return Builder(scene, network).take();
}

}  // namespace tandem::analysis
