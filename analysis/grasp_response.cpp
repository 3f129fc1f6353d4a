#include "analysis/grasp_response.h"

#include <algorithm>
#include <stdexcept>

#include "analysis/matrix_power.h"

namespace tandem::analysis {

namespace {

const Symmetry& symmetry(const LiftedSystem& system, const std::string& name) {
  for (const Symmetry& s : system.symmetries)
    if (s.name == name) return s;
  throw std::domain_error("no free motion: " + name + " is not kept");
}

std::vector<GraspAxis> empty_axes(const LiftedSystem& system, const core::Scene& scene,
                                  int object) {
  if (system.grounded)
    throw std::domain_error("no free motion: something holds the scene to the ground");
  std::vector<GraspAxis> axes;
  const auto add = [&](const char* name, std::vector<double> rigid) {
    const std::vector<double> none(system.states(), 0.0);
    axes.push_back({name, none, none, none, std::move(rigid)});
  };
  const std::vector<double>& x = symmetry(system, "translation x").direction;
  add("x", x);
  if (scene.space == core::Space::kAxis) return axes;
  const std::vector<double>& y = symmetry(system, "translation y").direction;
  add("y", y);
  // About the object's centre instead of the origin.
  std::vector<double> turn = symmetry(system, "rotation").direction;
  const core::Vec3& centre = scene.objects[object].position;
  for (std::size_t i = 0; i < turn.size(); ++i) turn[i] += centre.y * x[i] - centre.x * y[i];
  add("rotation", std::move(turn));
  return axes;
}

void add_share(GraspAxis& axis, const ForcePort& port, double share) {
  for (std::size_t i = 0; i < axis.push.size(); ++i) axis.push[i] += share * port.push[i];
  axis.position[port.position] += share;
  axis.velocity[port.velocity] += share;
}

int components(const core::Scene& scene) { return scene.space == core::Space::kAxis ? 1 : 2; }

int finger_ports(const core::Scene& scene, std::size_t users) {
  std::size_t fingers = 0;
  for (std::size_t u = 0; u < users; ++u) fingers += scene.users[u].fingers.size();
  return static_cast<int>(fingers) * components(scene);
}

/// States that the axes reach or that reach them: what is apart makes the solve singular.
std::vector<int> reached(const LiftedSystem& system, const std::vector<GraspAxis>& axes) {
  const int n = system.states();
  std::vector<char> seen(n, 0);
  std::vector<int> kept;
  for (const GraspAxis& axis : axes)
    for (int i = 0; i < n; ++i)
      if ((axis.position[i] != 0.0 || axis.velocity[i] != 0.0) && seen[i] == 0) {
        seen[i] = 1;
        kept.push_back(i);
      }
  for (std::size_t at = 0; at < kept.size(); ++at)
    for (int j = 0; j < n; ++j)
      if (seen[j] == 0 &&
          (system.transition(kept[at], j) != 0.0 || system.transition(j, kept[at]) != 0.0)) {
        seen[j] = 1;
        kept.push_back(j);
      }
  return kept;
}

Matrix inverse(const Matrix& a) {
  Matrix out(a.cols, a.rows);
  for (int j = 0; j < a.rows; ++j) {
    std::vector<double> unit(a.rows, 0.0);
    unit[j] = 1.0;
    const std::vector<double> x = solve(a, unit);
    for (int i = 0; i < a.cols; ++i) out(i, j) = x[i];
  }
  return out;
}

}  // namespace

std::vector<GraspAxis> grasp_axes(const LiftedSystem& system, const core::Scene& scene, int user,
                                  int object) {
  std::vector<GraspAxis> axes = empty_axes(system, scene, object);
  const auto& fingers = scene.users[user].fingers;
  const int first = finger_ports(scene, user), width = components(scene);
  const double count = static_cast<double>(fingers.size());
  double arms = 0.0;
  for (const auto& f : fingers) {
    const core::Vec3 arm = f.position - scene.objects[object].position;
    arms += arm.x * arm.x + arm.y * arm.y;
  }
  if (axes.size() == 3 && !(arms > 0.0))
    throw std::domain_error("user " + scene.users[user].name +
                            ": every finger is at the object's centre and cannot turn it");
  for (std::size_t f = 0; f < fingers.size(); ++f) {
    const int at = first + static_cast<int>(f) * width;
    for (int c = 0; c < width; ++c) add_share(axes[c], system.ports.at(at + c), 1.0 / count);
    if (width == 1) continue;
    const core::Vec3 arm = fingers[f].position - scene.objects[object].position;
    add_share(axes[2], system.ports.at(at), -arm.y / arms);
    add_share(axes[2], system.ports.at(at + 1), arm.x / arms);
  }
  return axes;
}

std::vector<GraspAxis> object_axes(const LiftedSystem& system, const core::Scene& scene,
                                   int object) {
  std::vector<GraspAxis> axes = empty_axes(system, scene, object);
  const int width = static_cast<int>(axes.size());
  const int objects = static_cast<int>(scene.objects.size());
  const int first = finger_ports(scene, scene.users.size());
  for (int at = first + object * width; at < static_cast<int>(system.ports.size());
       at += objects * width)
    for (int c = 0; c < width; ++c) {
      const ForcePort& port = system.ports[at + c];
      for (std::size_t i = 0; i < port.push.size(); ++i) axes[c].push[i] += port.push[i];
      if (at != first + object * width) continue;  // felt at the first copy
      axes[c].position[port.position] = 1.0;
      axes[c].velocity[port.velocity] = 1.0;
    }
  return axes;
}

FeltMotion felt_motion(const LiftedSystem& system, const std::vector<GraspAxis>& axes) {
  const std::vector<int> kept = reached(system, axes);
  const int n = static_cast<int>(kept.size()), k = static_cast<int>(axes.size());
  // Unknowns: states and forces. Equations: the states, and no motion beside the rigid one.
  Matrix a(n + k, n + k);
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j)
      a(i, j) = system.transition(kept[i], kept[j]) - (i == j ? 1.0 : 0.0);
    for (int c = 0; c < k; ++c) {
      a(i, n + c) = axes[c].push[kept[i]];
      a(n + c, i) = axes[c].position[kept[i]];
    }
  }
  const double T = system.period;
  FeltMotion out;
  out.mean_damping = Matrix(k, k);
  Matrix uniform(k, k), changing(k, k), inertia(k, k);  // sampled velocities; inertia to the mean
  for (int r = 0; r < k; ++r) {
    std::vector<double> right(n + k, 0.0);
    for (int i = 0; i < n; ++i) right[i] = T * axes[r].rigid[kept[i]];
    const std::vector<double> steady = solve(a, right);
    // x = q r + v X1 + a X2 at constant acceleration: (M - I) X2 + B m = T X1 + T^2/2 r.
    for (int i = 0; i < n; ++i) right[i] = T * steady[i] + 0.5 * T * T * axes[r].rigid[kept[i]];
    const std::vector<double> speeding = solve(a, right);
    for (int c = 0; c < k; ++c) {
      out.mean_damping(c, r) = steady[n + c];
      inertia(c, r) = speeding[n + c];
      for (int i = 0; i < n; ++i) {
        uniform(c, r) += axes[c].velocity[kept[i]] * steady[i];
        changing(c, r) += axes[c].velocity[kept[i]] * speeding[i];
      }
    }
  }
  // Sampled V = uniform v + changing a; F = damping v + inertia a, by V and dV/dt.
  const Matrix to_mean = inverse(uniform);
  out.sampled_damping = product(out.mean_damping, to_mean);
  const Matrix lag = product(out.sampled_damping, changing);
  for (int i = 0; i < k; ++i)
    for (int j = 0; j < k; ++j) inertia(i, j) -= lag(i, j);
  out.inertia = product(inertia, to_mean);
  return out;
}

std::complex<double> admittance(const LiftedSystem& system, const GraspAxis& axis, double omega,
                                bool of_position) {
  const auto x =
      solve_shifted(system.transition, std::polar(1.0, omega * system.period), axis.push);
  const std::vector<double>& row = of_position ? axis.position : axis.velocity;
  std::complex<double> sum = 0.0;
  for (std::size_t i = 0; i < row.size(); ++i) sum += row[i] * x[i];
  return sum;
}

}  // namespace tandem::analysis
