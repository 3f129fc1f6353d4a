#include "analysis/lifted.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "analysis/linearised_grasp.h"

namespace tandem::analysis {

namespace {

/// A simple eigenvalue one is found to some 1e-15; the smallest drag looked for moves it by 5e-13.
constexpr double kDrift = 1e-13;
/// Several ones side by side spoil each other; whether they are ones is asked of the motion itself.
constexpr double kDrifts = 1e-9;
/// The same in a map found by finite differences, which knows drag and drift apart no better.
constexpr double kDriftMeasured = 1e-6;

/// Whether the map is one of finite differences: its symmetries were asked for on the loop.
bool by_differences(const LiftedSystem& system) { return system.tolerance >= 1e-6; }

/// Everything moving at one metre (or radian) a second, (M - I) s = T_t t, if there is such a
/// motion. Bodies may trail each other: what is held is old. `pivots`: of all common motions, which
/// are free in s and taken as zero.
std::vector<double> uniform_motion(const Matrix& m, const std::vector<double>& t, double period,
                                   const std::vector<std::size_t>& pivots) {
  const int n = m.rows;
  std::vector<int> unknown;
  for (int j = 0; j < n; ++j)
    if (std::find(pivots.begin(), pivots.end(), static_cast<std::size_t>(j)) == pivots.end())
      unknown.push_back(j);
  Matrix a(n, static_cast<int>(unknown.size()));
  std::vector<double> right(n), s(n, 0.0);
  for (int i = 0; i < n; ++i) {
    right[i] = period * t[i];
    for (int c = 0; c < a.cols; ++c) a(i, c) = m(i, unknown[c]) - (i == unknown[c] ? 1.0 : 0.0);
  }
  const std::vector<double> x = solve(a, right);
  for (int c = 0; c < a.cols; ++c) s[unknown[c]] = x[c];
  return s;
}

/// Whether the map keeps uniform motion s, which there is no drag in. `scale`: how large each state
/// is in any of the uniform motions; what is zero in this one is so but for rounding of that, which
/// is `tolerance`.
bool keeps_uniform_motion(const Matrix& m, const std::vector<double>& t, double period,
                          const std::vector<double>& s, const std::vector<double>& scale,
                          double tolerance) {
  const int n = m.rows;
  // A row is kept if its residual is rounding beside what was added up in it, or beside that of
  // all it goes to: a force in flight is zero here, but for rounding of its own.
  std::vector<double> residual(n), size(n);
  for (int i = 0; i < n; ++i) {
    size[i] = scale[i];
    residual[i] = -s[i] - period * t[i];
    for (int j = 0; j < n; ++j) {
      size[i] += std::abs(m(i, j)) * scale[j];
      residual[i] += m(i, j) * s[j];
    }
  }
  for (bool changed = true; changed;) {
    changed = false;
    for (int i = 0; i < n; ++i) {
      double least = std::numeric_limits<double>::infinity();
      for (int k = 0; k < n; ++k)
        if (m(k, i) != 0.0) least = std::min(least, size[k] / std::abs(m(k, i)));
      if (!(least > 2.0 * size[i])) continue;
      size[i] = least;
      changed = true;
    }
  }
  for (int i = 0; i < n; ++i)
    if (!(std::abs(residual[i]) <= tolerance * size[i])) return false;
  return true;
}

/// Eliminates direction `t` (t[pivot] = 1), which the map keeps: R = M - t M[pivot,:], row and
/// column pivot dropped. Exact zero patterns stay.
void eliminate(Matrix& m, const std::vector<double>& t, int pivot) {
  Matrix r(m.rows - 1, m.cols - 1);
  for (int i = 0, ri = 0; i < m.rows; ++i) {
    if (i == pivot) continue;
    for (int j = 0, rj = 0; j < m.cols; ++j) {
      if (j == pivot) continue;
      r(ri, rj++) = m(i, j) - t[i] * m(pivot, j);
    }
    ++ri;
  }
  m = std::move(r);
}

/// A vector after elimination of `t`: its share of t taken off, entry `pivot` dropped.
void eliminate_from(std::vector<double>& x, const std::vector<double>& t, int pivot) {
  const double amount = x[pivot];
  for (std::size_t i = 0; i < x.size(); ++i) x[i] -= amount * t[i];
  x.erase(x.begin() + pivot);
}

/// Rounding of powers leaves more than the last digit of a row where a scene is stiff; a law that
/// breaks the symmetry moves velocities by its stiffness.
bool keeps(const Matrix& m, const std::vector<double>& t, double tolerance, double period) {
  const std::vector<double> after = multiply(m, t);
  double largest = 1.0 / period;
  for (const double x : m.values) largest = std::max(largest, std::abs(x));
  for (int i = 0; i < m.rows; ++i)
    if (!(std::abs(after[i] - t[i]) <= tolerance * largest)) return false;
  return true;
}

/// Number of the piece each state belongs to; pieces do not feel each other.
std::vector<int> pieces(const Matrix& m, int& count) {
  std::vector<int> piece(m.rows, -1);
  count = 0;
  for (int start = 0; start < m.rows; ++start) {
    if (piece[start] >= 0) continue;
    std::vector<int> stack{start};
    piece[start] = count;
    while (!stack.empty()) {
      const int i = stack.back();
      stack.pop_back();
      for (int j = 0; j < m.rows; ++j)
        if (piece[j] < 0 && (m(i, j) != 0.0 || m(j, i) != 0.0)) {
          piece[j] = count;
          stack.push_back(j);
        }
    }
    ++count;
  }
  return piece;
}

struct Part {
  Matrix m;
  std::vector<Symmetry> symmetries;
  std::vector<double> velocities;
  std::vector<Symmetry> eliminated;  ///< in this order, each as it was when its turn came
  std::vector<int> kept;             ///< which of `symmetries` they are
};

Part part_of(const LiftedSystem& system, const std::vector<int>& piece, int which) {
  std::vector<int> kept;
  for (int i = 0; i < system.states(); ++i)
    if (piece[i] == which) kept.push_back(i);
  const int n = static_cast<int>(kept.size());
  Part part{Matrix(n, n), {}, {}, {}, {}};
  for (int i = 0; i < n; ++i) {
    part.velocities.push_back(system.velocities[kept[i]]);
    for (int j = 0; j < n; ++j) part.m(i, j) = system.transition(kept[i], kept[j]);
  }
  for (const Symmetry& s : system.symmetries) {
    Symmetry local{s.name, {}, static_cast<std::size_t>(n)};
    for (int i = 0; i < n; ++i) {
      local.direction.push_back(s.direction[kept[i]]);
      // The pivot is a state with entry one: where a position is, not a held force.
      if (local.pivot == static_cast<std::size_t>(n) && s.direction[kept[i]] == 1.0)
        local.pivot = static_cast<std::size_t>(i);
    }
    if (kept.end() != std::find(kept.begin(), kept.end(), static_cast<int>(s.pivot)))
      local.pivot = static_cast<std::size_t>(
          std::find(kept.begin(), kept.end(), static_cast<int>(s.pivot)) - kept.begin());
    if (local.pivot < static_cast<std::size_t>(n)) part.symmetries.push_back(std::move(local));
  }
  return part;
}

void deflate(const LiftedSystem& system, Part& part, std::vector<std::string>& removed) {
  // A map by finite differences has been asked already which motions it keeps.
  const bool demanded = !by_differences(system);
  for (std::size_t k = 0; k < part.symmetries.size(); ++k) {
    const Symmetry s = part.symmetries[k];
    const int pivot = static_cast<int>(s.pivot);
    if (!keeps(part.m, s.direction, system.tolerance, system.period)) {
      if (system.grounded || !demanded) continue;
      throw std::domain_error(
          "the scene has no spring to the ground, yet moving everything alike does not move "
          "everything alike: a coupler breaks translation invariance");
    }
    eliminate(part.m, s.direction, pivot);
    part.eliminated.push_back(s);
    part.kept.push_back(static_cast<int>(k));
    removed.push_back(s.name);
    for (std::size_t other = k + 1; other < part.symmetries.size(); ++other) {
      Symmetry& o = part.symmetries[other];
      eliminate_from(o.direction, s.direction, pivot);
      if (o.pivot > s.pivot) --o.pivot;
    }
  }
}

/// Takes out the second one of each double eigenvalue one, where there is one.
bool deflate_uniform_motions(const LiftedSystem& system, const Part& whole, Part& part,
                             std::vector<std::string>& removed) {
  std::vector<std::size_t> pivots;
  for (const int k : part.kept) pivots.push_back(whole.symmetries[k].pivot);
  std::vector<std::vector<double>> motions;
  std::vector<double> scale(whole.m.rows, 0.0);
  for (const int k : part.kept) {
    motions.push_back(
        uniform_motion(whole.m, whole.symmetries[k].direction, system.period, pivots));
    for (int i = 0; i < whole.m.rows; ++i)
      scale[i] = std::max(scale[i], std::abs(motions.back()[i]));
  }
  bool any = false;
  for (std::size_t i = 0; i < motions.size(); ++i) {
    const Symmetry& t = whole.symmetries[part.kept[i]];
    std::vector<double> s = motions[i];
    if (!keeps_uniform_motion(whole.m, t.direction, system.period, s, scale,
                              by_differences(system) ? kDriftMeasured : 1e-12))
      continue;
    for (const Symmetry& e : part.eliminated)
      eliminate_from(s, e.direction, static_cast<int>(e.pivot));
    const auto largest = std::max_element(
        s.begin(), s.end(), [](double x, double y) { return std::abs(x) < std::abs(y); });
    const auto at = static_cast<std::size_t>(largest - s.begin());
    const double amount = *largest;
    for (double& x : s) x /= amount;
    eliminate(part.m, s, static_cast<int>(at));
    removed.push_back("uniform motion" +
                      (whole.symmetries.size() == 1 ? std::string() : " (" + t.name + ")"));
    part.eliminated.push_back({removed.back(), std::move(s), at});
    any = true;
  }
  return any;
}

}  // namespace

bool has_spring_to_ground(const core::Scene& scene) {
  if (!scene.walls.empty()) return true;
  for (const auto& user : scene.users)
    for (const auto& finger : user.fingers)
      if (finger.hand.stiffness > 0.0) return true;
  return false;
}

LinearScene linear_scene(const core::Scene& given) {
  LinearScene out{given, {}};
  core::Scene& scene = out.scene;
  const auto assume = [&](bool changed, const char* what) {
    if (changed) out.assumptions.emplace_back(what);
  };
  if (scene.space == core::Space::kPlane) {
    scene = linearised_at_grasp(scene);
    assume(!given.contact.attached, "fingers attached to the object where they first touch it");
    assume(!given.walls.empty(), "no walls: the grasp is judged in free motion");
    bool held = false;
    for (const auto& user : given.users)
      for (const auto& finger : user.fingers)
        held = held || finger.hand.stiffness > 0.0 || finger.hand.damping > 0.0 ||
               finger.damping > 0.0;
    assume(held, "fingers are free masses: no muscle holds or damps them");
  }
  if (scene.space == core::Space::kAxis) {
    assume(!scene.contact.attached, "fingers attached to the object: contact never opens");
    scene.contact = {};
    scene.contact.attached = true;
    bool opened = false;
    for (auto& wall : scene.walls) {
      opened = opened || !wall.attached;
      wall.attached = true;
    }
    assume(opened, "walls attached, forces held: what touches them never lifts off");
  }
  // Asked of the scene as it was given: a grasp has lost all this already.
  bool friction = false, device = false, intent = false;
  for (const auto& object : given.objects)
    friction = friction || object.ground_friction > 0.0 || object.ground_friction_rotation > 0.0;
  for (const auto& d : given.devices)
    device = device || d.encoder_step > 0.0 || d.friction > 0.0 || d.velocity_cutoff_hz > 0.0 ||
             d.max_force > 0.0 || d.max_slew > 0.0;
  for (const auto& user : given.users)
    for (const auto& finger : user.fingers)
      intent = intent || !finger.intent.path.empty() || !finger.intent.path_sines.empty() ||
               !finger.intent.force_sines.empty() || finger.intent.force != core::Vec3(0.0);
  for (auto& object : scene.objects) object.ground_friction = object.ground_friction_rotation = 0.0;
  for (auto& d : scene.devices)
    d.encoder_step = d.friction = d.velocity_cutoff_hz = d.max_force = d.max_slew = 0.0;
  for (auto& user : scene.users)
    for (auto& finger : user.fingers) finger.intent = {};
  assume(friction, "no friction between objects and the ground");
  assume(device, "ideal devices: no encoder step, friction, filter or force limit");
  assume(intent, "hands without intent of their own");
  assume(given.silence.has_value(), "packets keep coming: no fading");
  scene.silence.reset();
  return out;
}

Judgement judge(const LiftedSystem& system) {
  Judgement out;
  if (!all_finite(system.transition)) {
    out.radius = out.log2_radius = std::numeric_limits<double>::infinity();
    return out;
  }
  int count = 0;
  const std::vector<int> piece = pieces(system.transition, count);
  out.parts = 0;
  for (int p = 0; p < count; ++p) {
    Part part = part_of(system, piece, p);
    // A state that nothing drives and that drives nothing: a sample overwritten at once.
    if (part.m.rows == 1 && part.m(0, 0) == 0.0 && part.velocities[0] == 0.0) continue;
    ++out.parts;
    if (system.scale != 0.0) {  // far outside anyway
      const auto found = eigenvalues(part.m);
      out.eigenvalues.insert(out.eigenvalues.end(), found.begin(), found.end());
      continue;
    }
    const Part whole = part;
    const std::size_t before = out.removed.size();
    deflate(system, part, out.removed);
    auto found = eigenvalues(part.m);
    const double near = by_differences(system)  ? kDriftMeasured
                        : part.kept.size() == 1 ? kDrift
                                                : kDrifts;
    const bool drifts = out.removed.size() > before &&
                        std::any_of(found.begin(), found.end(),
                                    [&](const auto& z) { return std::abs(z - 1.0) < near; });
    if (drifts && deflate_uniform_motions(system, whole, part, out.removed))
      found = eigenvalues(part.m);
    out.eigenvalues.insert(out.eigenvalues.end(), found.begin(), found.end());
  }
  std::stable_sort(out.eigenvalues.begin(), out.eigenvalues.end(),
                   [](const auto& a, const auto& b) { return std::abs(a) > std::abs(b); });
  const double largest = out.eigenvalues.empty() ? 0.0 : std::abs(out.eigenvalues.front());
  out.log2_radius = (std::log2(largest) + system.scale) / system.packets;
  out.radius = system.scale == 0.0 && system.packets == 1 ? largest : std::exp2(out.log2_radius);
  return out;
}

}  // namespace tandem::analysis
