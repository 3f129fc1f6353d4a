#include "harness/real_sweep.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>

#include <fmt/format.h>

#include "analysis/drag.h"
#include "harness/harness_error.h"
#include "harness/node_plan.h"
#include "harness/session_batches.h"
#include "harness/tasks.h"
#include "harness/virtual_run.h"
#include "scene/load_scene.h"

namespace tandem::harness {
namespace {

constexpr double kPushForce = 0.1;       // [N]
constexpr double kSearchSeconds = 20.0;  // of a session in virtual time: what grows slowly shows
/// Twins judge themselves again at so many times more and less coupling. At 0.9 and 1.1 of the
/// boundary, where sockets are tried, it is not crossed.
constexpr double kNear = 1.09;

/// A node loads only scenes in which every hand has its coupler: the others' do nothing.
[[nodiscard]] core::Scene with_idle_couplers(core::Scene scene, const core::Scene& whole) {
  for (core::CouplerParameters coupler : whole.couplers) {
    if (core::index_of(scene.couplers, coupler.name) >= 0) continue;
    coupler.gain = coupler.tangential = coupler.rotation = {};
    scene.couplers.push_back(coupler);
  }
  return scene;
}

/// The scene with samples held and nothing compensated.
[[nodiscard]] core::Scene held(core::Scene scene) {
  scene.reconstruction.kind = core::ReconstructionKind::kHold;
  for (core::ObjectParameters& object : scene.objects)
    object.compensation = object.compensation_rotation = 0.0;
  return scene;
}

[[nodiscard]] bool is_axis(const core::Scene& scene) {
  return scene.space == core::Space::kAxis && !scene.objects.empty();
}

/// A kicked session again, over the packets that the real one recorded.
[[nodiscard]] VirtualTwin twin_of(const SessionJob& job, const RecordedSession& real) {
  VirtualTwin twin;
  const core::NetworkModel network = replayed_network(real.links);
  const auto at = [&](double factor) {
    const core::Scene scene =
        factor == 1.0 ? job.scene : with_coupling(job.scene, factor * coupling_of(job.scene));
    return run_stability(scene, network, job.seconds);
  };
  const Stability own = at(1.0);
  twin.judged = own.judged;
  twin.stable = own.stable;
  twin.near_boundary = at(kNear).stable != own.stable || at(1.0 / kNear).stable != own.stable;
  return twin;
}

class RealSweep {
 public:
  RealSweep(const Sweep& sweep, const RealOptions& options, const RealProgress& progress)
      : options_(options),
        progress_(progress),
        batches_(options.name, most_sites(sweep), options.at_once, options.most_nodes,
                 options.program) {
    for (std::size_t i = 0; i < sweep.points.size(); ++i) {
      if (!options.part.has(i)) continue;
      numbers_.push_back(i + 1);
      PointResult& result = results_.emplace_back();
      result.point = sweep.points[i];
      result.real = true;
      result.missed_share = 0.0;
    }
  }

  [[nodiscard]] std::vector<PointResult> run() {
    std::vector<SessionJob> first = sessions_as_they_are();
    all_ = static_cast<int>(first.size() + 2 * results_.size());
    for (PointResult& result : results_) guarded(result, [&] { probe(result); });
    batches_.run(first, [&](const SessionJob& job, SessionOutcome outcome) {
      finished(job, outcome, [&](PointResult& r) { as_it_is(job, *outcome.session, r); });
    });
    std::vector<SessionJob> second;
    for (std::size_t i = 0; i < results_.size(); ++i)
      guarded(results_[i], [&] { predict_and_plan(i, second); });
    all_ = static_cast<int>(first.size() + second.size());
    batches_.run(second, [&](const SessionJob& job, SessionOutcome outcome) {
      finished(job, outcome, [&](PointResult& r) { near_boundary(job, *outcome.session, r); });
    });
    say("");
    return std::move(results_);
  }

 private:
  [[nodiscard]] static int most_sites(const Sweep& sweep) {
    int sites = 2;
    for (const SweepPoint& point : sweep.points) sites = std::max(sites, node_count(point.scene));
    return sites;
  }

  void say(const std::string& doing) {
    if (progress_) progress_(done_, all_, doing);
  }

  /// A point for which this throws is marked failed; the others go on.
  template <typename Work>
  static void guarded(PointResult& result, Work&& work) {
    if (result.failed) return;
    try {
      work();
    } catch (const Interrupted&) {
      throw;
    } catch (const std::exception& e) {
      result.failed = true;
      result.log = e.what();
    }
  }

  template <typename Work>
  void finished(const SessionJob& job, const SessionOutcome& outcome, Work&& work) {
    PointResult& result = results_[job.point];
    ++done_;
    result.session_seconds += job.seconds;
    const std::string why = job.name + ": " + outcome.failure;
    if (outcome.session) {
      result.missed_share = std::max(result.missed_share, outcome.session->missed_share);
      guarded(result, [&] { work(result); });
    } else if (job.name == "push" || job.name == "touch" || job.name == "carry") {
      result.log += why + "\n";  // the point has its verdict
    } else {
      guarded(result, [&] { throw HarnessError(why); });
    }
    say(result.point.name + ": " + job.name);
  }

  [[nodiscard]] std::vector<SessionJob> sessions_as_they_are() const {
    std::vector<SessionJob> jobs;
    for (std::size_t i = 0; i < results_.size(); ++i) {
      const SweepPoint& point = results_[i].point;
      const int user = analysis::drag_user(point.scene);
      const auto add = [&](const char* name, core::Scene scene, double seconds) {
        jobs.push_back({i, name, std::move(scene), point.network, seconds, base(i)});
      };
      add("kick", kicked(point.scene), point.seconds);
      if (options_.push && is_axis(point.scene))
        add("push", with_idle_couplers(pushed(point.scene, user, kPushForce), point.scene),
            point.seconds);
      if (options_.touch && is_axis(point.scene))
        add("touch", touched(point.scene, user), kTouchSeconds);
      if (options_.carry) add("carry", carried(point.scene), point.seconds);
    }
    return jobs;
  }

  [[nodiscard]] std::string base(std::size_t point) const {
    return fmt::format("{}/{:03}", options_.folder, numbers_[point]);
  }

  void probe(PointResult& result) {
    for (const Condition& condition : {result.point.network.there, result.point.network.back}) {
      if (!options_.probe) {
        result.seen.emplace_back();
        continue;
      }
      const std::string key = to_text(condition);
      auto known = probed_.find(key);
      if (known == probed_.end()) {
        say("probe: " + key);
        const ProbePlan plan = probe_plan(condition);
        SeenLink link = batches_.network().probe(condition, plan);
        link.expected = expected_sight(condition, plan);
        link.delay_sd = sd_by_spread(link);
        link.set = key;
        known = probed_.emplace(key, link).first;
      }
      result.seen.push_back(known->second);
    }
  }

  void as_it_is(const SessionJob& job, RecordedSession& session, PointResult& result) {
    if (job.name == "kick") {
      result.measures.stability = judge_stability(session.trajectory, kFloorOnSockets);
      result.kick_missed = session.missed_share;
      result.twin = twin_of(job, session);
      if (options_.tries)
        result.largest_coupling = search_largest_coupling(
            result.point.scene, replayed_network(session.links), kSearchSeconds);
      links_[job.point] = session.links;
      note_links(result, session.links);
    } else if (job.name == "push") {
      result.push_missed = session.missed_share;
      const int user = analysis::drag_user(result.point.scene);
      // The other hands are let go and stay behind.
      for (SiteTrajectory& site : session.trajectory.sites)
        if (site.user != result.point.scene.users[user].name) site.fingers = 0;
      if (has_blown_up(session.trajectory)) return;
      const MeasuredDrag drag = measure_drag(session.trajectory, user, kPushForce);
      result.measures.drag = drag.n_s_per_m;
      result.measures.drag_settled = drag.settled;
      const Trajectory twin = run_virtual(pushed(result.point.scene, user, kPushForce),
                                          replayed_network(session.links), job.seconds);
      pushes_[job.point] = {drag, measure_drag(twin, user, kPushForce),
                            measured_network(session.links)};
      result.twin.drag = pushes_[job.point].twin.n_s_per_m;
    } else if (job.name == "touch") {
      measure_touch(std::move(session.trajectory), analysis::drag_user(result.point.scene),
                    result.measures);
    } else {
      measure_carry(job, session.trajectory, result);
    }
  }

  /// Against the same hands on the ideal twin, in virtual time.
  static void measure_carry(const SessionJob& job, Trajectory& session, PointResult& result) {
    if (has_blown_up(session)) return;
    Trajectory twin = run_virtual(ideal_twin(job.scene), {}, job.seconds);
    // The start is not the network's.
    const auto settled = static_cast<std::int64_t>(job.scene.rates.local_hz);
    session.first_slot = twin.first_slot = std::max(session.first_slot, settled);
    const Measures carried = measure(session, &twin);
    result.measures.gap_rms = carried.gap_rms;
    result.measures.gap_999 = carried.gap_999;
    result.measures.sites = carried.sites;
  }

  static void note_links(PointResult& result, const std::vector<MeasuredLink>& links) {
    const SweepPoint& point = result.point;
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
      seen.age_error_ticks = link.age_error_ticks;
      if (link.sent > 0)
        seen.used_share = static_cast<double>(link.used) / static_cast<double>(link.sent);
      result.seen.push_back(seen);
    }
  }

  /// Whether the analysis has this network itself and not one like it on average.
  [[nodiscard]] static bool is_steady(const LinkConditions& network) {
    const auto steady = [](const Condition& c) {
      return c.jitter == 0.0 && c.loss == 0.0 && !c.bursts && !c.outage && !c.recorded &&
             c.reorder == 0.0;
    };
    return steady(network.there) && steady(network.back);
  }

  /// Kick and push together: in what order they came does not matter.
  void judge_by_push(std::size_t i) {
    const auto push = pushes_.find(i);
    if (push == pushes_.end()) return;
    PointResult& result = results_[i];
    const double period = result.point.scene.tick() * result.point.scene.ticks_per_packet();
    if (result.push_missed <= kMostMissed)
      judge_by_drag(result.measures.stability, push->second.real, period);
    Stability of_twin;
    of_twin.judged = result.twin.judged;
    of_twin.stable = result.twin.stable;
    judge_by_drag(of_twin, push->second.twin, period);
    result.twin.stable = of_twin.stable;
  }

  void predict_and_plan(std::size_t i, std::vector<SessionJob>& jobs) {
    judge_by_push(i);
    PointResult& result = results_[i];
    const SweepPoint& point = result.point;
    say(point.name + ": prediction");
    result.prediction = predict(point.scene, measured_network(links_[i]),
                                {.largest_coupling = true, .between_ticks = true});
    result.prediction.exact = is_steady(point.network);
    if (const auto push = pushes_.find(i); push != pushes_.end()) {
      if (std::isfinite(result.prediction.drag))
        result.prediction.drag = predicted_drag(point.scene, push->second.network);
      result.hold_drag = predicted_drag(held(point.scene), push->second.network);
    }
    const double largest = result.prediction.largest_coupling;
    if (!options_.tries || !result.prediction.judged || !std::isfinite(largest) || largest <= 0.0)
      return;
    const core::Scene scene = kicked(point.scene);
    for (const char* factor : {"0.9", "1.1"})
      jobs.push_back({i, factor, with_coupling(scene, std::stod(factor) * largest), point.network,
                      point.seconds, base(i)});
  }

  static void near_boundary(const SessionJob& job, const RecordedSession& session,
                            PointResult& result) {
    BoundaryTry& attempt = job.name == "0.9" ? result.below : result.above;
    attempt.done = true;
    attempt.missed_share = session.missed_share;
    attempt.stability = judge_stability(session.trajectory, kFloorOnSockets);
    const double coupling = coupling_of(job.scene);
    const core::Scene scene = with_coupling(result.point.scene, coupling);
    attempt.ratio = coupling / predicted_coupling(scene, measured_network(session.links));
    attempt.twin = twin_of(job, session);
  }

  RealOptions options_;
  RealProgress progress_;
  SessionBatches batches_;
  std::vector<PointResult> results_;
  std::vector<std::size_t> numbers_;  ///< of the points in the whole sweep, from 1
  std::map<std::string, SeenLink> probed_;
  struct Push {
    MeasuredDrag real, twin;
    core::NetworkModel network;  ///< as measured in it
  };
  std::map<std::size_t, std::vector<MeasuredLink>> links_;
  std::map<std::size_t, Push> pushes_;
  int done_ = 0, all_ = 0;
};

void make_folder(const std::string& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw HarnessError("cannot make folder " + folder + ": " + error.message());
}

}  // namespace

std::vector<PointResult> run_real_sweep(const Sweep& sweep, const RealOptions& options,
                                        const RealProgress& progress) {
  make_folder(options.folder);
  return RealSweep(sweep, options, progress).run();
}

void find_real_boundaries(std::vector<DelayBoundary>& boundaries, const RealOptions& options,
                          double seconds, bool few, const RealProgress& progress) {
  make_folder(options.folder);
  std::vector<SessionJob> jobs;
  int sites = 2;
  std::size_t sessions = 0;
  for (std::size_t i = 0; i < boundaries.size(); ++i) {
    DelayBoundary& boundary = boundaries[i];
    const core::Scene scene = kicked(scene::load_scene(boundary.scene));
    sites = std::max(sites, node_count(scene));
    boundary.tick = scene.tick();
    // Sockets take a tick or two by themselves.
    const int last = std::isfinite(boundary.predicted)
                         ? static_cast<int>(std::lround(boundary.predicted / scene.tick()))
                         : 0;
    for (int d = std::max(0, last - 4); d <= last; ++d) {
      if (few && d != std::max(0, last - 4) && d != last) continue;
      // The last part first, which may have a point less.
      if (!options.part.has(options.part.count - 1 - sessions++ % options.part.count)) continue;
      Condition both;
      both.delay = d * scene.tick();
      jobs.push_back({i,
                      fmt::format("delay_{}_ticks", d),
                      scene,
                      {both, both},
                      seconds,
                      options.folder + "/" + boundary.scene});
    }
  }
  if (jobs.empty()) return;
  SessionBatches batches(options.name, sites, options.at_once, options.most_nodes, options.program);
  int done = 0;
  batches.run(jobs, [&](const SessionJob& job, const SessionOutcome& outcome) {
    DelayBoundary& boundary = boundaries[job.point];
    if (progress) progress(++done, static_cast<int>(jobs.size()), boundary.scene + ": " + job.name);
    if (!outcome.session) {
      boundary.failure += job.name + ": " + outcome.failure + "\n";
      return;
    }
    if (outcome.session->missed_share > kMostMissed) {
      boundary.failure += job.name + ": missed over 1 % of its ticks\n";
      return;
    }
    double ticks = 0.0;
    for (const MeasuredLink& link : outcome.session->links) ticks += link.mean_ticks;
    const double delay = boundary.tick * ticks / static_cast<double>(outcome.session->links.size());
    const Stability verdict = judge_stability(outcome.session->trajectory, kFloorOnSockets);
    if (!verdict.judged) return;
    if (verdict.stable && !(boundary.real_stable > delay)) boundary.real_stable = delay;
    if (!verdict.stable && !(boundary.real_not_stable < delay)) boundary.real_not_stable = delay;
  });
}

}  // namespace tandem::harness
