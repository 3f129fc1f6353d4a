#include "analysis/compensate.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "analysis/drag.h"
#include "analysis/grasp_response.h"
#include "analysis/resampled.h"
#include "analysis/stability.h"

namespace tandem::analysis {

namespace {

core::NetworkModel undelayed(core::NetworkModel network) {
  for (auto& row : network.link)
    for (auto& link : row) link.delay_ticks = 0.0;
  return network;
}

core::Scene simplified(core::Scene scene) {
  std::erase_if(scene.couplers, [](const core::CouplerParameters& c) { return !c.user.empty(); });
  return scene;
}

std::vector<double> diagonal(const Matrix& m) {
  std::vector<double> out;
  for (int i = 0; i < m.rows; ++i) out.push_back(m(i, i));
  return out;
}

/// Every user alone, then all together: what must be stable.
struct Holding {
  std::string who;
  core::Scene scene;
};
std::vector<Holding> cases_of(const core::Scene& scene) {
  std::vector<Holding> out;
  if (scene.users.size() > 1)
    for (const auto& user : scene.users)
      out.push_back({"user " + user.name + " alone", with_one_hand(scene, user.name)});
  out.push_back(
      {scene.users.size() > 1 ? "all users together" : "user " + scene.users[0].name, scene});
  return out;
}

/// Largest c with the scene stable for all compensation in [0, c).
double cancels(const core::Scene& scene, const core::NetworkModel& network,
               const std::string& field, double guess) {
  StabilityJudge judge(scene, network);
  const Knob knob(scene, field);
  IntervalOptions options;
  options.samples = 60;
  for (double top = guess; top < 1e3 * guess; top *= 3.0) {
    const auto stable = stable_intervals(judge, scene, knob, 0.0, top, options);
    if (stable.empty() || stable.front().low > 0.0) return 0.0;
    if (stable.front().high < top) return stable.front().high;
  }
  return std::numeric_limits<double>::infinity();
}

/// Whether slow rigid motion of one user alone costs work whichever way it goes, v . D v > 0: then
/// no hand that holds some axes straight is driven along the others. By Sylvester's minors.
bool dissipates(const core::Scene& scene, const core::NetworkModel& network, int user) {
  const core::Scene alone = with_one_hand(scene, scene.users[user].name);
  const LiftedSystem system = lifted_system(alone, network);
  const Matrix d = felt_motion(system, grasp_axes(system, alone, user, 0)).mean_damping;
  const auto s = [&](int i, int j) { return 0.5 * (d(i, j) + d(j, i)); };
  const double two = s(0, 0) * s(1, 1) - s(0, 1) * s(0, 1);
  const double three = s(2, 2) * two - s(0, 2) * (s(0, 2) * s(1, 1) - s(0, 1) * s(1, 2)) -
                       s(1, 2) * (s(1, 2) * s(0, 0) - s(0, 1) * s(0, 2));
  return s(0, 0) > 0.0 && two > 0.0 && three > 0.0;
}

/// Largest compensation below `most` that leaves every slow motion dissipative.
double bears_slow_motion(core::Scene scene, const core::NetworkModel& network, int user,
                         const Knob& knob, double most) {
  const auto good = [&](double c) {
    knob.set(scene, c);
    return dissipates(scene, network, user);
  };
  if (!good(0.0)) return 0.0;
  double low = 0.0, high = most;
  if (!std::isfinite(most) || good(most)) return most;
  for (int i = 0; i < 40; ++i) (good(0.5 * (low + high)) ? low : high) = 0.5 * (low + high);
  return low;
}

/// Compensation that leaves no drag along `axis` when the force acts on the copies themselves
/// (Fig 6.3). By secants on the direct solve: the model need not be stable for that.
double cancels_simplified(const core::Scene& scene, const core::NetworkModel& network,
                          const Knob& knob, int axis) {
  core::Scene model = simplified(scene);
  const auto drag = [&](double c) {
    knob.set(model, c);
    const LiftedSystem system = lifted_system(model, network);
    return felt_motion(system, object_axes(system, model, 0)).mean_damping(axis, axis);
  };
  double a = 0.0, fa = drag(a);
  if (!(fa > 1e-12)) return 0.0;
  double b = 0.5 * fa, fb = drag(b);
  for (int i = 0; i < 30 && fb != fa && std::abs(b - a) > 1e-13 * b; ++i) {
    const double next = b - fb * (b - a) / (fb - fa);
    a = b, fa = fb;
    b = next, fb = drag(b);
  }
  return b;
}

/// Drag of one user alone along every axis.
std::vector<double> drag_alone(const core::Scene& scene, const core::NetworkModel& network,
                               int user) {
  const core::Scene alone = with_one_hand(scene, scene.users[user].name);
  const LiftedSystem system = lifted_system(alone, network);
  return diagonal(felt_motion(system, grasp_axes(system, alone, user, 0)).mean_damping);
}

/// Factor by which the numbers of a field may grow in every case.
double factor(const std::vector<Holding>& cases, const core::NetworkModel& network,
              const char* field, bool& open) {
  constexpr double kFactors = 20.0;
  double least = kFactors;
  for (const Holding& c : cases) {
    StabilityJudge judge(c.scene, network);
    const Knob knob(c.scene, field);
    IntervalOptions options;
    options.samples = 40;
    options.tolerance = 1e-9;
    const auto stable = stable_intervals(judge, c.scene, knob, 1.0, kFactors, options);
    least = std::min(least, stable.empty() || stable.front().low > 1.0 ? 1.0 : stable.front().high);
  }
  open = least == kFactors;
  return least;
}

std::optional<int> delay_left(const std::vector<Holding>& cases, const core::NetworkModel& network,
                              int ticks_per_packet) {
  const int last = 10 * ticks_per_packet;
  for (int more = 1; more <= last; ++more) {
    core::NetworkModel later = network;
    constexpr int kServer = core::NetworkModel::kServer;
    for (int i = 0; i <= core::kMaxUsers; ++i)
      for (int j = 0; j <= core::kMaxUsers; ++j)
        if ((i < j && j != kServer) || i == kServer) later.link[i][j].delay_ticks += more;
    for (const Holding& c : cases)
      if (!judge(lifted_system(c.scene, later)).stable()) return more - 1;
  }
  return std::nullopt;
}

}  // namespace

core::Scene with_one_object(core::Scene scene, int object) {
  const core::ObjectParameters kept = scene.objects.at(object);
  scene.objects = {kept};
  std::erase_if(scene.couplers,
                [&](const core::CouplerParameters& c) { return c.object != kept.name; });
  return scene;
}

core::Scene compensated(core::Scene scene, int object, const std::vector<Compensator>& found) {
  scene.objects[object].compensation = found.front().value;
  if (found.size() > 1) scene.objects[object].compensation_rotation = found[1].value;
  return scene;
}

LoopReport report_loop(const core::Scene& whole, const core::NetworkModel& network, int object) {
  const core::Scene scene = with_one_object(whole, object);
  const std::vector<Holding> cases = cases_of(scene);
  LoopReport out;
  for (const Holding& c : cases) {
    const double radius = judge(lifted_system(c.scene, network)).radius;
    if (&c == &cases.back()) out.radius = radius;
    out.radius_alone = std::max(out.radius_alone, radius);
  }
  if (cases.size() > 1) {
    out.radius_alone = 0.0;
    for (std::size_t i = 0; i + 1 < cases.size(); ++i)
      out.radius_alone =
          std::max(out.radius_alone, judge(lifted_system(cases[i].scene, network)).radius);
  }
  for (std::size_t u = 0; u < scene.users.size(); ++u)
    out.drag.push_back(drag_alone(scene, network, static_cast<int>(u)));
  if (!out.stable()) {
    out.delay_ticks = 0;
    out.stiffness_factor = out.damping_factor = 1.0;
    return out;
  }
  out.stiffness_factor = factor(cases, network, "coupler.*.stiffness", out.stiffness_open);
  out.damping_factor = factor(cases, network, "coupler.*.damping", out.damping_open);
  out.delay_ticks = delay_left(cases, network, scene.most_ticks_per_packet());
  return out;
}

std::vector<Compensator> compensators(const core::Scene& whole, const core::NetworkModel& network,
                                      int object, double leave) {
  core::Scene scene = with_one_object(whole, object);
  core::ObjectParameters& o = scene.objects[0];
  o.compensation = o.compensation_rotation = 0.0;
  const core::NetworkModel still = undelayed(network);
  for (const core::NetworkModel* n : {&still, &network})
    for (const Holding& c : cases_of(scene))
      if (!judge(lifted_system(c.scene, *n)).stable())
        throw std::domain_error("object " + o.name + ": unstable without compensation (" + c.who +
                                (n == &still ? ", no delay" : "") +
                                "); lower a gain first, see tandem analyze stability");
  std::vector<double> most;
  for (std::size_t u = 0; u < scene.users.size(); ++u) {
    const auto drag = drag_alone(scene, network, static_cast<int>(u));
    most.resize(drag.size(), 0.0);
    for (std::size_t i = 0; i < drag.size(); ++i) most[i] = std::max(most[i], drag[i]);
  }
  std::vector<Compensator> out;
  for (const bool turn : {false, true}) {
    if (turn && most.size() < 3) break;
    Compensator c;
    c.field = "object." + o.name + (turn ? ".compensation_rotation" : ".compensation");
    const double guess = std::max(
        1e-6,
        2.0 * (turn ? most[2]
                    : *std::max_element(most.begin(), most.begin() + (most.size() > 2 ? 2 : 1))));
    c.cancels_now = c.cancels_undelayed = std::numeric_limits<double>::infinity();
    double least = std::numeric_limits<double>::infinity();
    const auto bound = [&](double value, const std::string& who) {
      if (value < least) least = value, c.bound_by = who;
    };
    for (const Holding& one : cases_of(scene)) {
      const double early = cancels(one.scene, still, c.field, guess);
      const double now = cancels(one.scene, network, c.field, guess);
      c.cancels_undelayed = std::min(c.cancels_undelayed, early);
      c.cancels_now = std::min(c.cancels_now, now);
      bound(early, one.who + ", no delay");
      bound(now, one.who + ", this delay");
    }
    for (std::size_t u = 0; most.size() == 3 && u < scene.users.size(); ++u) {
      const Knob knob(scene, c.field);
      const int user = static_cast<int>(u);
      const std::string who = "user " + scene.users[u].name + " alone, some axes held straight, ";
      const double early = bears_slow_motion(scene, still, user, knob, c.cancels_undelayed);
      const double now = bears_slow_motion(scene, network, user, knob, c.cancels_now);
      c.cancels_undelayed = std::min(c.cancels_undelayed, early);
      c.cancels_now = std::min(c.cancels_now, now);
      bound(early, who + "no delay");
      bound(now, who + "this delay");
    }
    c.simplified_undelayed = cancels_simplified(scene, still, Knob(scene, c.field), turn ? 2 : 0);
    if (turn) bound(c.simplified_undelayed, "the simplified model, no delay");
    // Rounding of a zero drag is no compensator.
    for (double* x : {&least, &c.cancels_now, &c.cancels_undelayed})
      if (*x < 1e-9) *x = 0.0;
    c.value = (1.0 - leave) * least;
    if (!std::isfinite(c.value)) c.value = 0.0;
    out.push_back(c);
    (turn ? o.compensation_rotation : o.compensation) = c.value;
  }
  return out;
}

}  // namespace tandem::analysis
