#include "analysis/workstation.h"

#include "core/plane_world.h"
#include "core/simulated_hand.h"

namespace tandem::analysis {

namespace {

bool none(const core::Gain& g) { return g.stiffness == 0.0 && g.damping == 0.0; }

}  // namespace

std::vector<Spring> grasp_springs(const core::Scene& scene, const core::CouplerParameters& coupler,
                                  int user, int finger, int object) {
  std::vector<Spring> out;
  if (scene.space == core::Space::kAxis) {
    if (!none(coupler.gain)) out.push_back({coupler.gain, {1.0, 0.0, 0.0}, {-1.0, 0.0, 0.0}});
    return out;
  }
  const core::UserParameters& u = scene.users[user];
  const core::ObjectParameters& o = scene.objects[object];
  const auto grasp = core::PlaneWorld::grasp(scene, coupler, u.fingers[finger], o, u.mass, true);
  const core::PlacedBody body(core::PlaneWorld::initial_body(o));
  const core::Vec2 arm = body.to_world(grasp.attached.anchor_B);
  const core::Vec2 n = body.to_world(grasp.attached.normal_B), t{-n.y, n.x};
  for (const auto& [gain, line] :
       {std::pair{grasp.gains.normal, n}, std::pair{grasp.gains.tangential, t}})
    if (!none(gain))
      out.push_back({gain, {line.x, line.y, 0.0}, {-line.x, -line.y, -core::cross(arm, line)}});
  return out;
}

std::vector<Spring> coordination_springs(const core::Scene& scene,
                                         const core::CouplerParameters& coupler) {
  std::vector<Spring> out;
  const int axes = scene.space == core::Space::kAxis ? 1 : 3;
  for (int i = 0; i < axes; ++i) {
    Spring s{i == 2 ? coupler.rotation : coupler.gain, {}, {}};
    s.object[i] = 1.0;
    if (!none(s.gain)) out.push_back(s);
  }
  return out;
}

void Workstation::add_hand(const core::Scene& scene, int user_index) {
  const int axes = scene.space == core::Space::kAxis ? 1 : 2;
  for (int f = 0; f < static_cast<int>(scene.users[user_index].fingers.size()); ++f)
    for (int i = 0; i < axes; ++i) coordinates.push_back({user_index, f, -1, i});
}

void Workstation::add_objects(const core::Scene& scene) {
  const int axes = scene.space == core::Space::kAxis ? 1 : 3;
  for (int o = 0; o < static_cast<int>(scene.objects.size()); ++o)
    for (int i = 0; i < axes; ++i) coordinates.push_back({-1, -1, o, i});
}

int Workstation::of_finger(int user_index, int finger) const {
  for (std::size_t i = 0; i < coordinates.size(); ++i)
    if (coordinates[i].user == user_index && coordinates[i].finger == finger)
      return static_cast<int>(i);
  return -1;
}

int Workstation::of_object(int object) const {
  for (std::size_t i = 0; i < coordinates.size(); ++i)
    if (!coordinates[i].is_hand() && coordinates[i].object == object) return static_cast<int>(i);
  return -1;
}

std::vector<double> Workstation::ends(const Spring& s, int finger_at, int object_at) const {
  std::vector<double> w(coordinates.size(), 0.0);
  const auto put = [&](int at, const std::array<double, 3>& weights) {
    if (at < 0) return;
    const Coordinate& first = coordinates[at];
    for (std::size_t i = at; i < w.size(); ++i) {
      const Coordinate& c = coordinates[i];
      if (c.user != first.user || c.finger != first.finger || c.object != first.object) break;
      w[i] = weights[c.axis];
    }
  };
  put(finger_at, s.finger);
  put(object_at, s.object);
  return w;
}

WorkstationBuilder::WorkstationBuilder(const core::Scene& scene, Workstation& site,
                                       double mass_share)
    : scene_(scene), site_(site), delay_(scene.rates.latency_ticks) {
  const int m = static_cast<int>(site.coordinates.size());
  const int n = m * (2 + delay_);
  site.a = Matrix(n, n);
  site.coupled = Matrix(n, m);
  site.external = Matrix(n, m);
  force_ = Matrix(m, n);
  direct_ = Matrix(m, n);
  for (int i = 0; i < m; ++i) free_mass(i, mass_share);
}

void WorkstationBuilder::spring(const std::vector<double>& ends, const core::Gain& gain) {
  for (std::size_t i = 0; i < ends.size(); ++i) {
    if (ends[i] == 0.0) continue;
    for (std::size_t j = 0; j < ends.size(); ++j) {
      const double w = ends[i] * ends[j];
      const int row = static_cast<int>(i), x = 2 * static_cast<int>(j);
      force_(row, x) -= w * gain.stiffness;
      force_(row, x + 1) -= w * gain.damping;
    }
  }
}

void WorkstationBuilder::to_ground(int coordinate, const core::Gain& gain) {
  force_(coordinate, 2 * coordinate) -= gain.stiffness;
  force_(coordinate, 2 * coordinate + 1) -= gain.damping;
}

void WorkstationBuilder::direct(int coordinate, double stiffness, double damping) {
  direct_(coordinate, 2 * coordinate) -= stiffness;
  direct_(coordinate, 2 * coordinate + 1) -= damping;
}

void WorkstationBuilder::finish() {
  const int m = static_cast<int>(site_.coordinates.size()), n = site_.a.rows;
  const Matrix& input = site_.external;
  for (int b = 0; b < m; ++b) {
    if (delay_ == 0) {
      for (int i = 0; i < n; ++i) {
        if (input(i, b) == 0.0) continue;
        for (int j = 0; j < n; ++j) site_.a(i, j) += input(i, b) * (force_(b, j) + direct_(b, j));
        site_.coupled(i, b) = input(i, b);
      }
      continue;
    }
    // Forces in the delay line of this coordinate: first in, delay_ ticks later on the mass.
    const int line = 2 * m + b * delay_;
    for (int i = 0; i < n; ++i) {
      if (input(i, b) == 0.0) continue;
      site_.a(i, line + delay_ - 1) += input(i, b);
      for (int j = 0; j < n; ++j) site_.a(i, j) += input(i, b) * direct_(b, j);
    }
    for (int j = 0; j < n; ++j) site_.a(line, j) += force_(b, j);
    for (int k = 1; k < delay_; ++k) site_.a(line + k, line + k - 1) += 1.0;
    site_.coupled(line, b) = 1.0;
  }
}

void WorkstationBuilder::free_mass(int i, double mass_share) {
  const double T = scene_.tick();
  const Coordinate& c = site_.coordinates[i];
  const int x = 2 * i, v = x + 1;
  Matrix& a = site_.a;
  if (c.is_hand()) {
    const core::UserParameters& user = scene_.users[c.user];
    const core::FingerParameters& finger = user.fingers[c.finger];
    const auto s = core::second_order_step(finger.hand.stiffness / user.mass,
                                           (finger.hand.damping + finger.damping) / user.mass, T);
    a(x, x) = s.a00, a(x, v) = s.a01, a(v, x) = s.a10, a(v, v) = s.a11;
    site_.external(x, i) = s.b0 / user.mass;
    site_.external(v, i) = s.b1 / user.mass;
    return;
  }
  const core::ObjectParameters& object = scene_.objects[c.object];
  // On an axis the inertia is not asked for.
  const auto body = core::plane_body_parameters(object, scene_.gravity, mass_share);
  const double inverse = c.axis == 2 ? body.inverse_inertia : body.inverse_mass;
  a(x, x) = a(v, v) = 1.0;
  a(x, v) = T;
  site_.external(v, i) = T * inverse;
  switch (scene_.integrator) {
    case core::Integrator::kZeroOrderHold:
    case core::Integrator::kExactCoupler:  // refused by why_not_resampled
      site_.external(x, i) = 0.5 * T * T * inverse;
      break;
    case core::Integrator::kSemiImplicitEuler:
      site_.external(x, i) = T * T * inverse;
      break;
    case core::Integrator::kExplicitEuler:
      break;
  }
  direct(i, 0.0, c.axis == 2 ? -object.compensation_rotation : -object.compensation);
  if (scene_.space != core::Space::kAxis) return;
  for (const core::WallParameters& wall : scene_.walls)
    if (wall.touches_objects) direct(i, wall.gain.stiffness, wall.gain.damping);
}

}  // namespace tandem::analysis
