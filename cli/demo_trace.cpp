#include "cli/demo_trace.h"

#include <algorithm>
#include <cmath>

#include "analysis/with_loop.h"
#include "cli/recorded_ticks.h"
#include "cli/replayed_site.h"
#include "core/target_path.h"
#include "core/with_world.h"
#include "scene/load_scene.h"

namespace tandem::cli {
namespace {

using Sample = DemoTrace::Sample;

[[nodiscard]] core::Vec3 force_of(double w) { return core::to_vec3(w); }
[[nodiscard]] core::Vec3 force_of(const core::PlaneWrench& w) { return core::to_vec3(w.force); }
[[nodiscard]] core::Vec3 force_of(const core::SpaceWrench& w) { return w.force; }
[[nodiscard]] double angle_of(const core::PlaneBody& b) { return b.angle; }
template <typename Body>
[[nodiscard]] double angle_of(const Body&) {
  return 0.0;
}

template <typename Body>
[[nodiscard]] Sample sample_of(const Body& body, const core::Vec3& force) {
  return {true, core::to_vec3(body.p), core::to_vec3(body.v), force, angle_of(body)};
}

template <typename World>
[[nodiscard]] Sample sample_of(const distributed::ReplicaLaw<World>& law) {
  return sample_of(law.object(0), force_of(law.own_wrench(0)));
}
template <typename World>
[[nodiscard]] Sample sample_of(const central::ServerLaw<World>& law) {
  core::Vec3 force{0.0};
  for (int u = 0; u < law.user_count(); ++u) force += force_of(law.user_wrench(u, 0));
  return sample_of(law.object(0), force);
}
template <typename World>
[[nodiscard]] Sample sample_of(const central::ClientLaw<World>& law) {
  return sample_of(law.held().objects[0], core::Vec3{0.0});
}

[[nodiscard]] std::size_t slot_count(const core::Scene& scene, double seconds) {
  return static_cast<std::size_t>(std::llround(seconds * scene.rates.local_hz));
}

template <typename Site>
void trace(recording::RecordingReader& reader, Site&& site, DemoTrace& out) {
  RecordedTicks ticks(reader);
  while (ticks.next()) {
    (void)site.step(ticks.tick(), ticks.packets());
    const auto slot = static_cast<std::size_t>(ticks.tick().slot);
    if (slot < out.slots.size()) out.slots[slot] = sample_of(site.law());
  }
  Sample last = out.slots.empty() ? Sample{} : out.slots.front();
  for (Sample& sample : out.slots) {
    if (sample.ran) last = sample;
    const bool ran = sample.ran;
    sample = last;
    sample.ran = ran;
  }
}

/// All copies' forces along the carry, less ground friction on the moving object.
[[nodiscard]] double net_force(const core::ObjectParameters& object, double gravity,
                               const core::Vec3& direction,
                               const std::vector<const DemoTrace*>& traces, std::size_t slot) {
  core::Vec3 force{0.0}, velocity{0.0};
  for (const DemoTrace* t : traces) {
    force += t->slots[slot].force;
    velocity += t->slots[slot].velocity / static_cast<double>(traces.size());
  }
  const double speed = glm::length(velocity);
  if (speed > 0.0) force -= velocity * (object.ground_friction * object.mass * gravity / speed);
  return glm::dot(force, direction);
}

[[nodiscard]] double along(const std::vector<const DemoTrace*>& traces, std::size_t slot,
                           const core::Vec3& direction, bool velocity) {
  double sum = 0.0;
  for (const DemoTrace* t : traces)
    sum += glm::dot(velocity ? t->slots[slot].velocity : t->slots[slot].position, direction);
  return sum / static_cast<double>(traces.size());
}

[[nodiscard]] double inertial_force(const core::Scene& scene, const core::Vec3& direction,
                                    const std::vector<const DemoTrace*>& traces, std::size_t slot) {
  const auto N = static_cast<std::size_t>(scene.ticks_per_packet());
  const std::size_t last = traces.front()->slots.size() - 1;
  const std::size_t a = slot > N ? slot - N : 0, b = std::min(slot + N, last);
  if (a == b) return 0.0;
  return scene.objects.front().mass *
         (along(traces, b, direction, true) - along(traces, a, direction, true)) /
         (static_cast<double>(b - a) * scene.tick());
}

[[nodiscard]] double gap(const std::vector<const DemoTrace*>& traces, std::size_t slot) {
  double widest = 0.0;
  for (const DemoTrace* t : traces)
    widest = std::max(widest,
                      glm::length(t->slots[slot].position - traces.front()->slots[slot].position));
  return widest;
}

}  // namespace

DemoTrace trace_recording(const std::string& file, double seconds) {
  recording::RecordingReader reader(file);
  const core::Scene scene = scene::load_scene_text(reader.header().scene_text, "scene in " + file);
  const std::string user = reader.header().user;
  DemoTrace out;
  out.slots.resize(slot_count(scene, seconds));
  core::with_world(scene, [&]<typename World>(World) {
    if (!analysis::is_central(scene))
      trace(reader, ReplayedReplica<World>(scene, user), out);
    else if (user == "server")
      trace(reader, ReplayedServer<World>(scene, user), out);
    else
      trace(reader, ReplayedClient<World>(scene, user), out);
  });
  return out;
}

std::vector<DemoTrace> trace_in_virtual_time(const core::Scene& scene, double seconds) {
  core::LinkModelParameters link;
  link.delay_ticks = 1.0;
  core::NetworkModel network;
  network.set_all(link);
  const bool central = analysis::is_central(scene);
  std::vector<DemoTrace> traces(central ? 1 : scene.users.size());
  for (DemoTrace& t : traces) t.slots.reserve(slot_count(scene, seconds));
  analysis::with_loop(scene, network, [&](auto& loop) {
    for (std::size_t k = 0; k < slot_count(scene, seconds); ++k) {
      loop.tick();
      for (std::size_t i = 0; i < traces.size(); ++i) {
        core::Vec3 force{0.0};
        for (int u = 0; u < loop.user_count(); ++u)
          if (central || u == static_cast<int>(i)) force += force_of(loop.user_wrench(u, 0));
        traces[i].slots.push_back(sample_of(loop.object(static_cast<int>(i), 0), force));
      }
    }
  });
  return traces;
}

Command scripted_command(const core::Scene& scene, double seconds) {
  const core::Vec3 direction = script_times(scene).direction;
  Command command(slot_count(scene, seconds), 0.0);
  int fingers = 0;
  for (const core::UserParameters& user : scene.users)
    for (const core::FingerParameters& finger : user.fingers) {
      core::TargetPath<core::Vec3> path(finger.intent, finger.position);
      ++fingers;
      for (std::size_t k = 0; k < command.size(); ++k)
        command[k] += glm::dot(
            path.at(static_cast<double>(k) * scene.tick()).position - finger.position, direction);
    }
  for (double& c : command) c /= fingers;
  return command;
}

DemoFigures demo_figures(const core::Scene& scene, const ScriptTimes& times,
                         const std::vector<const DemoTrace*>& traces, const Command& command) {
  DemoFigures figures;
  const std::size_t slots = std::min(command.size(), traces.front()->slots.size());
  if (slots == 0 || scene.objects.empty()) return figures;
  const auto slot_of = [&](double t) {
    return std::min(slots - 1, static_cast<std::size_t>(std::llround(t * scene.rates.local_hz)));
  };
  const std::size_t first = slot_of(times.carry_start), last = slot_of(times.carry_end);
  const std::size_t settled = first + (last - first) / 4;
  constexpr double kMoving = 0.005;  // [m/s]
  double low = 1e30, high = -1e30, command_low = 1e30, command_high = -1e30;
  double net = 0.0, inertial = 0.0;
  int moving = 0;
  for (std::size_t k = first; k < last; ++k) {
    const double x = along(traces, k, times.direction, false);
    low = std::min(low, x), high = std::max(high, x);
    command_low = std::min(command_low, command[k]);
    command_high = std::max(command_high, command[k]);
    figures.gap_in_carry_max = std::max(figures.gap_in_carry_max, gap(traces, k));
    if (k < settled || std::abs(along(traces, k, times.direction, true)) < kMoving) continue;
    const double f = net_force(scene.objects.front(), scene.gravity, times.direction, traces, k);
    const double ma = inertial_force(scene, times.direction, traces, k);
    net += f * f;
    inertial += ma * ma;
    ++moving;
  }
  if (last > first) {
    figures.travel_measured = high - low;
    figures.travel_commanded = command_high - command_low;
  }
  // Of an object that nobody moved there is none: 0 / 0.
  figures.net_force_rms = std::sqrt(net / moving);
  figures.inertial_force_rms = std::sqrt(inertial / moving);
  figures.gap_after_release = gap(traces, slots - 1);
  return figures;
}

analysis::Table demo_table(const core::Scene& scene, const ScriptTimes& times,
                           const std::vector<const DemoTrace*>& traces,
                           const std::vector<std::string>& names, const Command& command) {
  analysis::Table table;
  table.columns = {"t_s", "commanded_m", "net_force_N", "inertial_force_N", "gap_m"};
  for (const std::string& name : names)
    for (const char* column : {"_x_m", "_y_m", "_z_m", "_angle_rad", "_hands_along_N"})
      table.columns.push_back(name + column);
  const auto step = static_cast<std::size_t>(scene.ticks_per_packet());
  const std::size_t slots = std::min(command.size(), traces.front()->slots.size());
  for (std::size_t k = 0; k < slots; k += step) {
    std::vector<double> row{
        static_cast<double>(k) * scene.tick(), command[k],
        net_force(scene.objects.front(), scene.gravity, times.direction, traces, k),
        inertial_force(scene, times.direction, traces, k), gap(traces, k)};
    for (const DemoTrace* t : traces) {
      const Sample& s = t->slots[k];
      row.insert(row.end(), {s.position.x, s.position.y, s.position.z, s.angle,
                             glm::dot(s.force, times.direction)});
    }
    table.rows.push_back(std::move(row));
  }
  return table;
}

}  // namespace tandem::cli
