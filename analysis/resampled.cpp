#include "analysis/resampled.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "analysis/matrix_power.h"
#include "analysis/workstations.h"

namespace tandem::analysis {

namespace {

using core::Scene;

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
    for (const Workstation& site : w_.sites) {
      whole.push_back(power_of(site.a, w_.ticks));
      out.scale = std::max(out.scale, whole.back().scale);
    }
    Matrix& m = out.transition;
    for (std::size_t s = 0; s < w_.sites.size(); ++s) {
      const Workstation& site = w_.sites[s];
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
    symmetries(out);
    ports(out, whole);
    return out;
  }

 private:
  /// Adds what a signal does to the site it comes to: the sample before last up to tick r of the
  /// period, the newer one from there on.
  void act(const Signal& l, const Power& whole, double scale, Matrix& m) const {
    const Workstation& site = w_.sites[l.to];
    const int n = site.a.rows, q = l.delay / w_.ticks, r = l.delay % w_.ticks;
    const std::vector<double> b = multiply(site.coupled, l.push);
    const auto add = [&](const std::vector<double>& effect, double down, int age) {
      const std::vector<double> y = w_.value(l, age);
      for (int i = 0; i < n; ++i)
        for (int j = 0; j < w_.states; ++j)
          if (y[j] != 0.0) m(site.offset + i, j) += effect[i] * down * y[j];
    };
    if (l.by_age) {
      for (const bool newer : {false, true}) {
        if (!newer && r == 0) continue;
        std::vector<double> effect(n, 0.0);
        const int from = newer ? r : 0, to = newer ? w_.ticks : r;
        for (int tick = from; tick < w_.ticks; ++tick) {
          effect = multiply(site.a, effect);
          for (int i = 0; tick < to && i < n; ++i)
            effect[i] += b[i] * w_.reckoned_age(l, tick) * scene_.tick();
        }
        add(effect, std::exp2(-scale), newer ? q : q + 1);
      }
      return;
    }
    if (r == 0) {
      add(multiply(whole.sum, b), std::exp2(whole.scale - scale), q);
      return;
    }
    const Power late = power_of(site.a, w_.ticks - r), early = power_of(site.a, r);
    add(multiply(late.power, multiply(early.sum, b)), std::exp2(late.scale + early.scale - scale),
        q + 1);
    add(multiply(late.sum, b), std::exp2(late.scale - scale), q);
  }

  /// How far a coordinate goes when everything turns about the origin by one radian.
  [[nodiscard]] double turned(const Coordinate& c) const {
    if (c.axis == 2) return 1.0;
    const core::Vec3& p = c.is_hand() ? scene_.users[c.user].fingers[c.finger].position
                                      : scene_.objects[c.object].position;
    return c.axis == 0 ? -p.y : p.x;
  }

  void symmetries(LiftedSystem& out) const {
    out.velocities.assign(w_.states, 0.0);
    const bool plane = scene_.space == core::Space::kPlane;
    for (const int axis : plane ? std::vector<int>{2, 0, 1} : std::vector<int>{0}) {
      Symmetry t{axis == 2   ? "rotation"
                 : axis == 0 ? "translation x"
                             : "translation y",
                 std::vector<double>(w_.states, 0.0), static_cast<std::size_t>(w_.states)};
      for (const Workstation& site : w_.sites)
        for (std::size_t i = 0; i < site.coordinates.size(); ++i) {
          const Coordinate& c = site.coordinates[i];
          const std::size_t at = site.offset + 2 * i;
          if (c.axis != 2) out.velocities[at + 1] = 1.0;
          t.direction[at] = axis == 2 ? turned(c) : c.axis == axis ? 1.0 : 0.0;
          if (c.axis == axis) t.pivot = std::min(t.pivot, at);
        }
      for (const Signal& l : w_.signals) {  // a server's reply comes after what it adds
        if (l.past == 0) continue;
        const std::vector<double> y = w_.value(l, 0);
        double sum = 0.0;
        for (int j = 0; j < w_.states; ++j) sum += y[j] * t.direction[j];
        for (int k = 0; k < l.past; ++k) t.direction[l.first_past + k] = sum;
      }
      out.symmetries.push_back(std::move(t));
    }
    out.grounded = !scene_.walls.empty();
    for (const auto& user : scene_.users)
      for (const auto& finger : user.fingers)
        out.grounded = out.grounded || finger.hand.stiffness > 0.0;
  }

  void ports(LiftedSystem& out, const std::vector<Power>& whole) const {
    const auto port = [&](std::size_t s, int at, const std::string& name) {
      const Workstation& site = w_.sites[s];
      const Coordinate& first = site.coordinates[at];
      for (std::size_t i = at; i < site.coordinates.size(); ++i) {
        const Coordinate& c = site.coordinates[i];
        if (c.user != first.user || c.finger != first.finger || c.object != first.object) break;
        std::vector<double> unit(site.coordinates.size(), 0.0);
        unit[i] = 1.0;
        const std::vector<double> pushed = multiply(whole[s].sum, multiply(site.external, unit));
        const int x = site.offset + 2 * static_cast<int>(i);
        ForcePort p{name, std::vector<double>(w_.states, 0.0), x, x + 1};
        for (int k = 0; k < site.a.rows; ++k) p.push[site.offset + k] = pushed[k];
        out.ports.push_back(std::move(p));
      }
    };
    for (int u = 0; u < static_cast<int>(scene_.users.size()); ++u)
      for (int f = 0; f < static_cast<int>(scene_.users[u].fingers.size()); ++f)
        for (std::size_t s = 0; s < w_.sites.size(); ++s)
          if (const int at = w_.sites[s].of_finger(u, f); at >= 0)
            port(s, at, scene_.users[u].name + "." + scene_.users[u].fingers[f].name);
    for (std::size_t s = 0; s < w_.sites.size(); ++s)
      for (int o = 0; o < static_cast<int>(scene_.objects.size()); ++o)
        if (const int at = w_.sites[s].of_object(o); at >= 0)
          port(s, at,
               scene_.objects[o].name +
                   (w_.sites[s].user < 0 ? "" : "@" + scene_.users[w_.sites[s].user].name));
  }

  const Scene& scene_;
  const Workstations w_;
};

/// Whether every sample is younger than the extrapolation's horizon while it is used.
bool within_horizon(const Scene& scene, const core::NetworkModel& network) {
  double latest = 0.0;
  for (const auto& row : network.link)
    for (const auto& link : row)
      latest = std::max(latest, std::ceil(link.delay_ticks) + link.age_error_ticks);
  const double oldest = latest + scene.ticks_per_packet() - 1.0;
  return oldest * scene.tick() <= scene.reconstruction.horizon;
}

}  // namespace

std::string why_not_resampled(const Scene& scene, const core::NetworkModel& network) {
  if (scene.space == core::Space::kSpace) return "only axis and planar scenes are resampled";
  if (scene.reconstruction.kind != core::ReconstructionKind::kHold &&
      !within_horizon(scene, network))
    return "extrapolation ends within a packet period";
  if (!scene.contact.attached) return "contacts may open";
  if (scene.integrator == core::Integrator::kExactCoupler)
    return "object and coupler are integrated together";
  for (const auto& wall : scene.walls)
    if (!wall.attached || scene.space != core::Space::kAxis) return "walls may be left";
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

LiftedSystem lifted_system(const Scene& scene, const core::NetworkModel& network) {
  return why_not_resampled(scene, network).empty() ? resampled_system(scene, network)
                                                   : measured_system(scene, network);
}

}  // namespace tandem::analysis
