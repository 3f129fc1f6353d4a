#include "analysis/figures.h"

#include <cmath>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "analysis/closed_forms.h"
#include "analysis/drag.h"
#include "analysis/fast_response.h"
#include "analysis/resampled.h"
#include "analysis/response.h"

namespace tandem::analysis {

namespace {

using core::Scene;

/// Chapter 5: b = 10 N s/m for all couplers.
std::vector<std::string> all_damped(const std::vector<std::string>& couplers) {
  std::vector<std::string> out;
  for (const std::string& name : couplers) out.push_back("coupler." + name + ".damping=10");
  return out;
}

const char* const kOwn = "coupler.k11.stiffness,coupler.k22.stiffness";
const char* const kOther = "coupler.k12.stiffness,coupler.k21.stiffness";
const char* const kBetween = "coupler.ko1.stiffness,coupler.ko2.stiffness";

MapPlan copies_plan(const std::string& figure, std::pair<const char*, const char*> fixed,
                    const std::string& value) {
  MapPlan plan;
  plan.figure = figure;
  plan.scene = "axis_distributed";
  plan.sets = all_damped({"k11", "k22", "k12", "k21", "ko1", "ko2"});
  for (const char* name : {fixed.first, fixed.second})
    plan.sets.push_back("coupler." + std::string(name) + ".stiffness=" + value);
  return plan;
}

core::NetworkModel links(const Scene& scene, double round_trip) {
  core::NetworkModel network;
  network.set_round_trip(round_trip, scene.ticks_per_packet());
  return network;
}

/// One hand alone over the frequencies.
std::vector<std::complex<double>> felt(const Scene& scene, int user, double round_trip,
                                       const std::vector<double>& omega, bool position, bool fast) {
  const Scene alone = with_one_hand(scene, scene.users[user].name);
  const core::NetworkModel network = links(alone, round_trip);
  std::vector<std::complex<double>> out;
  if (fast) {
    const FastResponse response(alone, network, user);
    for (const double w : omega) out.push_back(response(w, position));
    return out;
  }
  const LiftedSystem system = resampled_system(alone, network);
  const Response response(system, system.ports.at(static_cast<std::size_t>(user)));
  for (const double w : omega) out.push_back(response(w, position));
  return out;
}

/// Fig 6.3: no hand couplers, force on the object or on both copies.
double simplified(Scene scene, double round_trip) {
  std::erase_if(scene.couplers, [](const auto& c) { return !c.user.empty(); });
  const LiftedSystem system = resampled_system(scene, links(scene, round_trip));
  // Ports: one finger a user, then the copies of the object, of which central scenes have one.
  const std::size_t users = scene.users.size();
  ForcePort all = system.ports.at(users);
  for (std::size_t i = users + 1; i < system.ports.size(); ++i) all = joined(all, system.ports[i]);
  return free_motion(system, all).sampled_damping;
}

void check_axis(const Scene& scene, core::Architecture architecture) {
  if (scene.space != core::Space::kAxis || scene.architecture != architecture ||
      scene.users.size() != 2 || scene.objects.size() != 1)
    throw std::domain_error(
        scene.name + ": chapter 6 needs a " +
        (architecture == core::Architecture::kCentral ? "central" : "distributed") +
        " axis scene with two users and one object");
}

}  // namespace

MapPlan map_plan(const std::string& figure) {
  MapPlan plan;
  if (figure == "5.1") {
    plan = {figure,
            "axis_central",
            all_damped({"k1", "k2"}),
            "coupler.k1.stiffness",
            "coupler.k2.stiffness",
            "k1, local user [N/m]",
            "k2, remote user [N/m]",
            {0.0, 25000.0, 100},
            {0.0, 4000.0, 100}};
  } else if (figure == "5.2") {
    plan = copies_plan(figure, {"ko1", "ko2"}, "1000");
    plan.x_field = kOther, plan.x_label = "k12 = k21 [N/m]", plan.across = {0.0, 6000.0, 100};
    plan.y_field = kOwn, plan.y_label = "k11 = k22 [N/m]", plan.up = {0.0, 25000.0, 100};
  } else if (figure == "5.3") {
    plan = copies_plan(figure, {"k12", "k21"}, "300");
    plan.x_field = kOwn, plan.x_label = "k11 = k22 [N/m]", plan.across = {0.0, 25000.0, 100};
    plan.y_field = kBetween, plan.y_label = "ko1 = ko2 [N/m]", plan.up = {0.0, 6000.0, 100};
  } else if (figure == "5.4") {
    plan = copies_plan(figure, {"k11", "k22"}, "2000");
    plan.x_field = kBetween, plan.x_label = "ko1 = ko2 [N/m]", plan.across = {0.0, 6000.0, 100};
    plan.y_field = kOther, plan.y_label = "k12 = k21 [N/m]", plan.up = {0.0, 6000.0, 100};
  } else {
    throw std::invalid_argument("no map is figure " + figure + "; there are 5.1, 5.2, 5.3, 5.4");
  }
  return plan;
}

Region region(const MapPlan& plan, const Scene& scene, double round_trip, int threads,
              const std::function<bool(int, int)>& progress) {
  const Knob x(scene, plan.x_field), y(scene, plan.y_field);
  StabilityJudge judge(scene, links(scene, round_trip));
  Region out;
  out.round_trip = round_trip;
  out.road = judge.road();
  out.map = stability_map(judge, scene, x, plan.across, y, plan.up, threads, progress);
  Axis across = plan.across, up = plan.up;
  across.count = up.count = 16;
  out.boundary = stability_boundary(judge, scene, x, across, y, up, 3);
  return out;
}

ResponseFigure response_figure(const std::string& figure, const ResponseSettings& s) {
  if (figure != "6.2" && figure != "6.4" && figure != "6.5")
    throw std::invalid_argument("no frequency response is figure " + figure +
                                "; there are 6.2, 6.4, 6.5");
  check_axis(s.central, core::Architecture::kCentral);
  check_axis(s.distributed, core::Architecture::kDistributed);
  const bool position = figure == "6.5";
  ResponseFigure out{figure, position ? "X/F [m/N]" : "V/F [m/(N s)]", {}, {}};
  const double nyquist =
      std::numbers::pi / (s.distributed.ticks_per_packet() * s.distributed.tick());
  constexpr double kFrom = 0.1;
  const double to = 0.97 * nyquist;
  if (!(to > kFrom)) throw std::domain_error("half the packet rate is below 0.1 rad/s");
  for (int i = 0; i < s.points; ++i)
    out.omega.push_back(kFrom * std::pow(to / kFrom, s.points == 1 ? 0.0 : i / (s.points - 1.0)));

  Scene central = s.central, distributed = s.distributed;
  if (position) {
    core::WallParameters wall;
    wall.name = "wall";
    wall.normal = core::Vec3(-1.0, 0.0, 0.0);
    wall.gain = s.wall;
    wall.attached = true;
    central.walls = distributed.walls = {wall};
  }
  Curve ideal{position ? "ideal: mass at the wall" : "ideal: pure mass", 0.0, false, {}};
  const double mass = distributed.objects[0].mass;
  for (const double w : out.omega)
    ideal.values.push_back(position ? mass_at_wall(mass, s.wall, w) : mass_admittance(mass, w));
  out.curves.push_back(std::move(ideal));

  const int remote = drag_user(central), local = 1 - remote;
  if (figure != "6.4") {
    // No network in this user's loop: force held over the tick, all packets at once.
    Scene near = central;
    near.rates.packet_hz = near.rates.local_hz;
    out.curves.push_back({"centralized, local user", 0.0, false,
                          felt(near, local, 0.0, out.omega, position, false)});
  }
  for (const double d : s.round_trips) {
    if (figure != "6.4")
      out.curves.push_back({"centralized, remote user", d, true,
                            felt(central, remote, d, out.omega, position, s.fast)});
    out.curves.push_back({figure == "6.4" ? "distributed, not compensated" : "distributed", d, true,
                          felt(distributed, 0, d, out.omega, position, s.fast)});
    if (figure == "6.4") {
      Scene given_back = distributed;
      given_back.objects[0].compensation = s.compensation;
      out.curves.push_back({"distributed, compensated", d, true,
                            felt(given_back, 0, d, out.omega, position, s.fast)});
    }
  }
  return out;
}

double drag_alone(const Scene& scene, int user, double round_trip) {
  const Scene alone = with_one_hand(scene, scene.users[user].name);
  const LiftedSystem system = resampled_system(alone, links(alone, round_trip));
  return free_motion(system, system.ports.at(static_cast<std::size_t>(user))).sampled_damping;
}

std::vector<Table62Row> table_6_2(const Scene& central, const Scene& distributed,
                                  const Scene& table_8_2, double round_trip) {
  check_axis(central, core::Architecture::kCentral);
  check_axis(distributed, core::Architecture::kDistributed);
  Scene two_ticks = central;
  two_ticks.rates.packet_hz = 0.5 * central.rates.local_hz;
  Scene experiment = distributed;
  for (core::CouplerParameters& c : experiment.couplers) {
    const int i = core::index_of(table_8_2.couplers, c.name);
    if (i < 0) throw std::domain_error(table_8_2.name + " has no coupler " + c.name);
    c.gain = table_8_2.couplers[static_cast<std::size_t>(i)].gain;
  }
  const int remote = drag_user(central);
  const std::string gains = "normal gains of " + table_8_2.name + " (Table 8.2)";
  return {{"centralized, original", 0.04, drag_alone(central, remote, round_trip),
           drag_alone(two_ticks, remote, round_trip), "N = 2 as in (B.10)"},
          {"centralized, simplified", 0.0, simplified(central, round_trip),
           simplified(central, round_trip), "as in the caption"},
          {"distributed, original", 2.1, drag_alone(distributed, 0, round_trip),
           drag_alone(experiment, 0, round_trip), gains},
          {"distributed, simplified", 1.4, simplified(distributed, round_trip),
           simplified(experiment, round_trip), gains}};
}

}  // namespace tandem::analysis
