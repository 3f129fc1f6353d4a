// The extension module tandem._core: a thin skin over scene/, the loops and analysis/. What users
// see, with type hints and docstrings, is python/tandem/__init__.py.
#include <complex>
#include <limits>
#include <pybind11/complex.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include "analysis/boundary.h"
#include "analysis/drag.h"
#include "analysis/linearised_grasp.h"
#include "analysis/resampled.h"
#include "analysis/response.h"
#include "analysis/stability.h"
#include "python/trajectory.h"
#include "scene/load_scene.h"

namespace py = pybind11;

namespace tandem::python {
namespace {

using Shape = std::vector<py::ssize_t>;

template <typename T>
py::array_t<T> array(const std::vector<T>& values, const Shape& shape) {
  py::array_t<T> out(shape);
  std::copy(values.begin(), values.end(), out.mutable_data());
  return out;
}

/// False, and the exception set, once the user pressed Ctrl-C.
bool go_on() {
  const py::gil_scoped_acquire gil;
  return PyErr_CheckSignals() == 0;
}

void rethrow_interrupt() {
  if (PyErr_Occurred() != nullptr) throw py::error_already_set();
}

core::NetworkModel round_trip(const core::Scene& scene, double delay_packets) {
  if (!(delay_packets >= 0.0) || delay_packets > 60.0)
    throw std::invalid_argument("delay_packets is " + scene::number_text(delay_packets) +
                                "; allowed: 0 to 60 packet periods");
  core::NetworkModel network;
  network.set_round_trip(delay_packets, scene.ticks_per_packet());
  return network;
}

struct LinkOptions {
  double delay = 0.0, jitter = 0.0, loss = 0.0;
  std::uint64_t seed = 1;
};

core::NetworkModel network_of(const core::Scene& scene, double delay_packets,
                              const LinkOptions& o) {
  const double room = 60.0 / scene.rates.packet_hz;
  if (!(o.delay >= 0.0 && o.jitter >= 0.0) || o.delay + 2.0 * o.jitter > room)
    throw std::invalid_argument("link_delay " + scene::number_text(o.delay) + " s and jitter " +
                                scene::number_text(o.jitter) +
                                " s must be 0 or more, and delay and twice the jitter at most " +
                                scene::number_text(room) + " s");
  if (!(o.loss >= 0.0 && o.loss <= 1.0))
    throw std::invalid_argument("loss is " + scene::number_text(o.loss) + "; allowed: 0 to 1");
  core::LinkModelParameters link;
  link.delay_ticks = o.delay * scene.rates.local_hz;
  link.jitter_ticks = o.jitter * scene.rates.local_hz;
  if (o.jitter > 0.0) link.jitter = core::JitterKind::kNormal;
  link.loss = o.loss;
  link.seed = o.seed;
  core::NetworkModel network = round_trip(scene, 0.0);
  network.set_all(link);
  if (delay_packets > 0.0) {
    const core::NetworkModel steady = round_trip(scene, delay_packets);
    for (std::size_t i = 0; i < steady.link.size(); ++i)
      for (std::size_t j = 0; j < steady.link.size(); ++j)
        network.link[i][j].delay_ticks += steady.link[i][j].delay_ticks;
  }
  return network;
}

py::dict simulate(const core::Scene& scene, double seconds, double delay_packets, double link_delay,
                  double jitter, double loss, std::uint64_t seed, int every) {
  if (!(seconds > 0.0) || seconds > 1e6)
    throw std::invalid_argument("seconds is " + scene::number_text(seconds) +
                                "; allowed: more than 0 up to 1000000");
  if (every < 1) throw std::invalid_argument("every must be 1 tick or more");
  constexpr double kMaxRows = 5e7;
  if (seconds * scene.rates.local_hz / every > kMaxRows)
    throw std::invalid_argument("more than 5e7 rows: give a larger `every`, or fewer seconds");
  const core::NetworkModel network =
      network_of(scene, delay_packets, {link_delay, jitter, loss, seed});
  Trajectory t;
  {
    const py::gil_scoped_release release;
    t = run_session(scene, network, seconds, every, go_on);
  }
  rethrow_interrupt();
  const auto rows = static_cast<py::ssize_t>(t.time.size());
  const auto size = [](std::size_t n) { return static_cast<py::ssize_t>(n); };
  py::dict out;
  out["time"] = array(t.time, {rows});
  out["poses"] = array(t.poses, {rows, size(t.users), size(t.objects), size(t.pose_width)});
  out["positions"] = array(t.positions, {rows, size(t.fingers.size()), size(t.components)});
  out["forces"] = array(t.forces, {rows, size(t.fingers.size()), size(t.components)});
  out["fingers"] = t.fingers;
  out["packets_sent"] = t.sent;
  out["packets_accepted"] = t.accepted;
  return out;
}

analysis::LiftedSystem lift(const core::Scene& scene, double delay_packets,
                            const std::string& road) {
  const core::Scene linear = analysis::linear_scene(scene).scene;
  const core::NetworkModel network = round_trip(scene, delay_packets);
  if (road == "measured") return analysis::measured_system(linear, network);
  if (road == "resampled") return analysis::resampled_system(linear, network);
  if (road != "auto")
    throw std::invalid_argument("road is '" + road + "'; allowed: auto, measured, resampled");
  return analysis::why_not_resampled(linear, network).empty()
             ? analysis::resampled_system(linear, network)
             : analysis::measured_system(linear, network);
}

py::dict judge(const core::Scene& scene, double delay_packets, const std::string& road) {
  const analysis::LiftedSystem system = lift(scene, delay_packets, road);
  const analysis::Judgement judged = analysis::judge(system);
  py::dict out;
  out["radius"] = judged.radius;
  out["eigenvalues"] =
      array(judged.eigenvalues, {static_cast<py::ssize_t>(judged.eigenvalues.size())});
  out["removed"] = judged.removed;
  out["assumptions"] = analysis::linear_scene(scene).assumptions;
  return out;
}

py::array_t<double> transition(const core::Scene& scene, double delay_packets,
                               const std::string& road) {
  const analysis::LiftedSystem system = lift(scene, delay_packets, road);
  std::vector<double> values = system.transition.values;
  for (double& v : values) v = std::ldexp(v, static_cast<int>(system.scale));
  return array(values, {system.states(), system.states()});
}

core::Scene hands_on(const core::Scene& scene, const std::string& user, bool alone) {
  if (core::index_of(scene.users, user) < 0)
    throw std::invalid_argument("no user '" + user + "' in scene " + scene.name);
  return alone ? analysis::with_one_hand(scene, user) : scene;
}

std::string first_finger(const core::Scene& scene, const std::string& user) {
  const int index = core::index_of(scene.users, user);
  return user + "." + scene.users[static_cast<std::size_t>(index)].fingers[0].name;
}

py::dict free_motion(const core::Scene& scene, const std::string& user, double delay_packets,
                     bool alone) {
  const analysis::LiftedSystem system = lift(hands_on(scene, user, alone), delay_packets, "auto");
  const auto m =
      analysis::free_motion(system, analysis::port_named(system, first_finger(scene, user)));
  py::dict out;
  out["damping"] = m.mean_damping;
  out["sampled_damping"] = m.sampled_damping;
  out["inertia"] = m.inertia;
  return out;
}

py::array_t<std::complex<double>> admittance(const core::Scene& scene, const std::string& user,
                                             const std::vector<double>& omega, double delay_packets,
                                             bool alone, bool of_position) {
  const analysis::LiftedSystem system = lift(hands_on(scene, user, alone), delay_packets, "auto");
  const analysis::ForcePort& port = analysis::port_named(system, first_finger(scene, user));
  std::vector<std::complex<double>> out;
  for (const double w : omega) out.push_back(analysis::admittance(system, port, w, of_position));
  return array(out, {static_cast<py::ssize_t>(out.size())});
}

using Range = std::pair<double, double>;

void demand_range(const char* name, const Range& range) {
  if (!(range.first >= 0.0) || !(range.first < range.second) || !(range.second < 1e12))
    throw std::invalid_argument(std::string(name) + " is (" + scene::number_text(range.first) +
                                ", " + scene::number_text(range.second) +
                                "); it must go up, from 0 or more to less than 1e12");
}

py::array_t<bool> stability_map(const core::Scene& scene, const std::string& x,
                                const Range& x_range, const std::string& y, const Range& y_range,
                                const std::pair<int, int>& shape, double delay_packets,
                                int threads) {
  demand_range("x_range", x_range);
  demand_range("y_range", y_range);
  if (shape.first < 1 || shape.second < 1 || shape.first > 20000 || shape.second > 20000)
    throw std::invalid_argument("shape must be (rows, columns), each 1 to 20000");
  const core::Scene linear = analysis::linear_scene(scene).scene;
  const analysis::StabilityJudge judge(linear, round_trip(scene, delay_packets));
  const analysis::Knob along(linear, x), up(linear, y);
  const analysis::Axis across{x_range.first, x_range.second, shape.second};
  const analysis::Axis upward{y_range.first, y_range.second, shape.first};
  analysis::StabilityMap map;
  try {
    const py::gil_scoped_release release;
    analysis::ThreadedRunner runner(threads, [](std::int64_t, std::int64_t) { return go_on(); });
    map = analysis::stability_map(judge, linear, along, across, up, upward, runner);
  } catch (const std::runtime_error&) {
    rethrow_interrupt();
    throw;
  }
  py::array_t<bool> out({shape.first, shape.second});
  std::copy(map.stable.begin(), map.stable.end(), out.mutable_data());
  return out;
}

py::array_t<double> stability_boundary(const core::Scene& scene, const std::string& x,
                                       const Range& x_range, const std::string& y,
                                       const Range& y_range, int cells, double tolerance,
                                       double delay_packets) {
  demand_range("x_range", x_range);
  demand_range("y_range", y_range);
  if (cells < 1 || cells > 2000) throw std::invalid_argument("cells must be 1 to 2000");
  const core::Scene linear = analysis::linear_scene(scene).scene;
  const analysis::StabilityJudge judge(linear, round_trip(scene, delay_packets));
  const analysis::Knob along(linear, x), up(linear, y);
  std::vector<analysis::Segment> segments;
  {
    const py::gil_scoped_release release;
    analysis::ThreadedRunner alone;
    analysis::BoundaryOptions options;
    options.tolerance = tolerance;
    segments =
        analysis::stability_boundary(judge, linear, along, {x_range.first, x_range.second, cells},
                                     up, {y_range.first, y_range.second, cells}, alone, options)
            .segments;
  }
  std::vector<double> ends;
  for (const analysis::Segment& s : segments) ends.insert(ends.end(), {s.x0, s.y0, s.x1, s.y1});
  return array(ends, {static_cast<py::ssize_t>(segments.size()), 2, 2});
}

py::array_t<double> stable_intervals(const core::Scene& scene, const std::string& field,
                                     const Range& range, double delay_packets) {
  demand_range("range", range);
  const core::Scene linear = analysis::linear_scene(scene).scene;
  analysis::StabilityJudge judge(linear, round_trip(scene, delay_packets));
  const analysis::Knob knob(linear, field);
  std::vector<double> ends;
  for (const auto& i : analysis::stable_intervals(judge, linear, knob, range.first, range.second))
    ends.insert(ends.end(), {i.low, i.high});
  return array(ends, {static_cast<py::ssize_t>(ends.size() / 2), 2});
}

const char* name_of(core::Space space) {
  return space == core::Space::kAxis ? "axis" : space == core::Space::kPlane ? "plane" : "space";
}

const char* name_of(core::Architecture a) {
  switch (a) {
    case core::Architecture::kSingle:
      return "single";
    case core::Architecture::kCentral:
      return "central";
    case core::Architecture::kDistributed:
      return "distributed";
    case core::Architecture::kDistributedSplit:
      return "distributed_split";
  }
  return "";
}

}  // namespace
}  // namespace tandem::python

PYBIND11_MODULE(_core, m) {
  using namespace tandem;
  using namespace tandem::python;
  py::register_exception<scene::SceneError>(m, "SceneError", PyExc_ValueError);
  py::class_<core::Scene>(m, "Scene")
      .def_readonly("name", &core::Scene::name)
      .def_readonly("description", &core::Scene::description)
      .def_property_readonly("text", [](const core::Scene& s) { return scene::to_text(s); })
      .def_property_readonly("hash", [](const core::Scene& s) { return scene::shared_hash(s); })
      .def_property_readonly("space", [](const core::Scene& s) { return name_of(s.space); })
      .def_property_readonly("architecture",
                             [](const core::Scene& s) { return name_of(s.architecture); })
      .def_property_readonly("users",
                             [](const core::Scene& s) {
                               std::vector<std::string> names;
                               for (const auto& user : s.users) names.push_back(user.name);
                               return names;
                             })
      .def_property_readonly("tick", &core::Scene::tick)
      .def_property_readonly("packet_period",
                             [](const core::Scene& s) { return 1.0 / s.rates.packet_hz; });
  m.def("load", [](const std::string& name, const std::vector<std::string>& sets) {
    return scene::load_scene(name, sets);
  });
  m.def("parse", [](const std::string& text, const std::string& origin,
                    const std::vector<std::string>& sets) {
    return scene::load_scene_text(text, origin, sets);
  });
  m.def("scene_names", &scene::scene_names);
  m.def("linearised", [](const core::Scene& s) { return analysis::linear_scene(s).scene; });
  m.def("simulate", &simulate);
  m.def("judge", &judge);
  m.def("transition", &transition);
  m.def("free_motion", &free_motion);
  m.def("admittance", &admittance);
  m.def("stability_map", &stability_map);
  m.def("stability_boundary", &stability_boundary);
  m.def("stable_intervals", &stable_intervals);
}
