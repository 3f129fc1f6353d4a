#include "harness/real_sweep.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>

#include <fmt/format.h>

#include "analysis/drag.h"
#include "harness/harness_error.h"
#include "harness/node_plan.h"
#include "harness/real_network.h"
#include "harness/recorded_session.h"
#include "harness/tasks.h"
#include "harness/virtual_run.h"

namespace tandem::harness {
namespace {

using SteadyClock = std::chrono::steady_clock;

constexpr double kLateStart = 0.1;  // [s] the kick comes later
constexpr double kMostTime = 6.0;   // [s]
constexpr double kPushForce = 0.1;  // [N]
constexpr double kMostForce = 1e4;  // [N] what a scene may say

/// What a session is for.
struct Task {
  std::string name;
  core::Scene scene;
  double seconds = 5.0;
};

/// What became of it; `failure` says why there is no session.
struct Outcome {
  std::optional<RecordedSession> session;
  std::string failure;
};

/// A node loads only scenes in which every hand has its coupler: the others' do nothing.
[[nodiscard]] core::Scene with_idle_couplers(core::Scene scene, const core::Scene& whole) {
  for (core::CouplerParameters coupler : whole.couplers) {
    if (core::index_of(scene.couplers, coupler.name) >= 0) continue;
    coupler.gain = coupler.tangential = coupler.rotation = {};
    scene.couplers.push_back(coupler);
  }
  return scene;
}

class RealSweep {
 public:
  RealSweep(const Sweep& sweep, const RealOptions& options) : options_(options) {
    int sites = 2;
    for (const SweepPoint& point : sweep.points) sites = std::max(sites, node_count(point.scene));
    for (int i = 0; i < std::max(1, options.at_once); ++i)
      networks_.push_back(std::make_unique<RealNetwork>(
          fmt::format("{}-{}", options.name, static_cast<char>('a' + i)), sites, options.program));
  }

  [[nodiscard]] PointResult run(const SweepPoint& point, int number,
                                const std::function<void(const std::string&)>& doing) {
    const auto begin = SteadyClock::now();
    PointResult result;
    result.point = point;
    result.real = true;
    base_ = fmt::format("{}/{:03}", options_.folder, number + 1);
    try {
      doing("probe");
      probe(point, result);
      doing("session");
      const std::vector<MeasuredLink> links = run_sessions_as_they_are(point, result);
      doing("prediction");
      result.prediction = predict(point.scene, measured_network(links));
      result.prediction.exact = is_steady(point.network);
      note_links(links, point, result);
      doing("0.9 and 1.1 of the largest stable coupling");
      try_boundary(point, result);
    } catch (const Interrupted&) {
      throw;
    } catch (const std::exception& e) {
      result.failed = true;
      result.log = e.what();
    }
    result.wall_seconds = std::chrono::duration<double>(SteadyClock::now() - begin).count();
    return result;
  }

 private:
  /// Runs tasks of one point, as many at once as may be; in their order.
  std::vector<Outcome> run_tasks(const std::vector<Task>& tasks, const SweepPoint& point,
                                 PointResult& result) {
    const int nodes = std::max(1, node_count(point.scene));
    const auto together = static_cast<std::size_t>(
        std::clamp(options_.most_nodes / nodes, 1, static_cast<int>(networks_.size())));
    std::vector<Outcome> outcomes;
    for (std::size_t first = 0; first < tasks.size(); first += together) {
      std::vector<Assignment> assignments;
      for (std::size_t i = first; i < std::min(first + together, tasks.size()); ++i)
        assignments.push_back({networks_[i - first].get(),
                               {.scene = with_limited_devices(tasks[i].scene),
                                .network = point.network,
                                .seconds = tasks[i].seconds,
                                .base = base_ + "_" + tasks[i].name}});
      std::vector<Outcome> batch = run_batch(assignments, result);
      // A node that was not ready in time missed what the hands do at the start: once more, with
      // more time, from now on.
      if (const double late = late_start(batch); late > kLateStart && more_time_ < kMostTime) {
        more_time_ = std::min(more_time_ + late + 0.3, kMostTime);
        batch = run_batch(assignments, result);
      }
      for (Outcome& outcome : batch) {
        if (outcome.session && late_start({outcome}) > kLateStart)
          outcome.failure = "its nodes were not ready in time", outcome.session.reset();
        outcomes.push_back(std::move(outcome));
      }
    }
    return outcomes;
  }

  std::vector<Outcome> run_batch(const std::vector<Assignment>& assignments, PointResult& result) {
    const std::vector<RealSession> sessions = run_sessions(assignments, more_time_);
    std::vector<Outcome> outcomes;
    for (std::size_t i = 0; i < sessions.size(); ++i) {
      result.session_seconds += assignments[i].request.seconds;
      outcomes.push_back(read(sessions[i], assignments[i].request.scene));
    }
    return outcomes;
  }

  /// How long after slot 0 the last node began [s].
  [[nodiscard]] static double late_start(const std::vector<Outcome>& outcomes) {
    double late = 0.0;
    for (const Outcome& outcome : outcomes) {
      if (!outcome.session) continue;
      const Trajectory& t = outcome.session->trajectory;
      for (const SiteTrajectory& site : t.sites)
        late = std::max(late, static_cast<double>(site.samples.front().slot) * t.tick);
    }
    return late;
  }

  [[nodiscard]] static Outcome read(const RealSession& session, const core::Scene& scene) {
    Outcome outcome;
    outcome.failure = session.failure;
    if (!outcome.failure.empty()) return outcome;
    try {
      outcome.session = read_session(session, scene, packet_bytes(scene));
    } catch (const std::exception& e) {
      outcome.failure = e.what();
    }
    return outcome;
  }

  static void must_have_run(const Task& task, const Outcome& outcome) {
    if (!outcome.session) throw HarnessError(task.name + ": " + outcome.failure);
  }

  void probe(const SweepPoint& point, PointResult& result) {
    const auto direction = [&](const Condition& condition) {
      const auto key = to_text(condition);
      auto known = probed_.find(key);
      if (known == probed_.end())
        known = probed_.emplace(key, networks_[0]->probe(condition, {})).first;
      return known->second;
    };
    const SeenDirection there = direction(point.network.there),
                        back = direction(point.network.back);
    for (const SeenDirection& seen : {there, back}) {
      SeenLink& link = result.seen.emplace_back();
      link.delay_p50 = seen.delay_p50;
      link.delay_sd = seen.delay_sd;
      link.sent = seen.sent;
      link.lost = seen.lost;
      link.loss = seen.sent > 0 ? static_cast<double>(seen.lost) / static_cast<double>(seen.sent)
                                : kNotMeasured;
    }
  }

  /// The sessions of the point as it is; returns how their samples came over.
  std::vector<MeasuredLink> run_sessions_as_they_are(const SweepPoint& point, PointResult& result) {
    const bool axis = point.scene.space == core::Space::kAxis && !point.scene.objects.empty();
    std::vector<Task> tasks{{"kick", kicked(point.scene), point.seconds}};
    const int user = axis ? analysis::drag_user(point.scene) : 0;
    if (options_.push && axis)
      tasks.push_back({"push",
                       with_idle_couplers(pushed(point.scene, user, kPushForce), point.scene),
                       point.seconds});
    if (options_.carry) tasks.push_back({"carry", carried(point.scene), point.seconds});
    std::vector<Outcome> outcomes = run_tasks(tasks, point, result);
    must_have_run(tasks[0], outcomes[0]);
    for (std::size_t i = 1; i < tasks.size(); ++i) {
      if (!outcomes[i].session) {
        result.log += tasks[i].name + ": " + outcomes[i].failure + "\n";
        continue;
      }
      Trajectory& session = outcomes[i].session->trajectory;
      if (tasks[i].name == "push") {
        const MeasuredDrag drag = measure_drag(session, user, kPushForce);
        result.measures.drag = drag.n_s_per_m;
        result.measures.drag_settled = drag.settled;
      } else {
        measure_carry(tasks[i], session, result);
      }
    }
    result.measures.stability = judge_stability(outcomes[0].session->trajectory);
    return outcomes[0].session->links;
  }

  /// Against the same hands on the ideal twin, in virtual time.
  static void measure_carry(const Task& task, Trajectory& session, PointResult& result) {
    Trajectory twin = run_virtual(ideal_twin(task.scene), {}, task.seconds);
    // The start is not the network's.
    const auto settled = static_cast<std::int64_t>(task.scene.rates.local_hz);
    session.first_slot = twin.first_slot = std::max(session.first_slot, settled);
    const Stability stability = result.measures.stability;
    const double drag = result.measures.drag;
    const bool drag_settled = result.measures.drag_settled;
    result.measures = measure(session, &twin);
    result.measures.stability = stability;
    result.measures.drag = drag;
    result.measures.drag_settled = drag_settled;
  }

  static void note_links(const std::vector<MeasuredLink>& links, const SweepPoint& point,
                         PointResult& result) {
    double ages = 0.0;
    for (const MeasuredLink& link : links) ages += link.mean_age * point.scene.tick();
    if (!links.empty()) result.mean_age = ages / static_cast<double>(links.size());
    const std::vector<SeenLink> probed = result.seen;
    result.seen.clear();
    for (const MeasuredLink& link : links) {
      const bool there = link.from == core::NetworkModel::kServer ||
                         (link.to != core::NetworkModel::kServer && link.from < link.to);
      SeenLink seen = probed.at(there ? 0 : 1);
      seen.from = link.from_name;
      seen.to = link.to_name;
      seen.set = to_text(there ? point.network.there : point.network.back);
      seen.delay_ticks = link.mean_ticks;
      seen.phase_ticks = link.phase_ticks;
      result.seen.push_back(seen);
    }
  }

  void try_boundary(const SweepPoint& point, PointResult& result) {
    const double largest = result.prediction.largest_coupling;
    if (!result.prediction.judged || !std::isfinite(largest) || largest <= 0.0) return;
    const core::Scene scene = kicked(point.scene);
    const std::vector<Task> tasks{{"0.9", with_coupling(scene, 0.9 * largest), point.seconds},
                                  {"1.1", with_coupling(scene, 1.1 * largest), point.seconds}};
    const std::vector<Outcome> outcomes = run_tasks(tasks, point, result);
    for (std::size_t i = 0; i < tasks.size(); ++i) must_have_run(tasks[i], outcomes[i]);
    result.tried_below = result.tried_above = true;
    result.below = judge_stability(outcomes[0].session->trajectory);
    result.above = judge_stability(outcomes[1].session->trajectory);
  }

  /// Whether the analysis has this network itself and not one like it on average.
  [[nodiscard]] static bool is_steady(const LinkConditions& network) {
    const auto steady = [](const Condition& c) {
      return c.jitter == 0.0 && c.loss == 0.0 && !c.bursts && !c.outage && !c.recorded &&
             c.reorder == 0.0 && c.duplicate == 0.0;
    };
    return steady(network.there) && steady(network.back);
  }

  RealOptions options_;
  std::vector<std::unique_ptr<RealNetwork>> networks_;
  std::map<std::string, SeenDirection> probed_;
  std::string base_;
  double more_time_ = 0.0;  ///< until slot 0, as this machine turned out to need
};

}  // namespace

core::Scene with_limited_devices(core::Scene scene) {
  for (core::UserParameters& user : scene.users)
    for (core::FingerParameters& finger : user.fingers) {
      int device = core::index_of(scene.devices, finger.device);
      if (device < 0) {
        finger.device = fmt::format("harness_{}_{}", user.name, finger.name);
        device = static_cast<int>(scene.devices.size());
        scene.devices.emplace_back().name = finger.device;
      }
      if (scene.devices[device].max_force <= 0.0) scene.devices[device].max_force = kMostForce;
    }
  return scene;
}

std::vector<PointResult> run_real_sweep(
    const Sweep& sweep, const RealOptions& options,
    const std::function<void(int, int, const std::string&)>& progress) {
  std::error_code error;
  std::filesystem::create_directories(options.folder, error);
  if (error) throw HarnessError("cannot make folder " + options.folder + ": " + error.message());
  RealSweep runner(sweep, options);
  std::vector<PointResult> results;
  const int all = static_cast<int>(sweep.points.size());
  for (const SweepPoint& point : sweep.points) {
    const int done = static_cast<int>(results.size());
    results.push_back(runner.run(point, done, [&](const std::string& what) {
      if (progress) progress(done, all, point.name + ": " + what);
    }));
  }
  if (progress) progress(all, all, "");
  return results;
}

}  // namespace tandem::harness
