#include "harness/session_batches.h"

#include <algorithm>

#include <fmt/format.h>

#include "core/clock.h"
#include "harness/guest.h"
#include "harness/node_plan.h"

namespace tandem::harness {
namespace {

constexpr double kLateStart = 0.1;  // [s] the kick comes later
constexpr double kMostLead = 3.0;   // [s] a node
constexpr double kToReady = 0.1;    // [s] a node: from "joined" to the first tick, recording opened
constexpr double kMostForce = 1e4;  // [N] what a scene may say

/// How long after slot 0 the last node began [s]. One that was not ready before the end recorded
/// nothing, or was heard by nobody.
[[nodiscard]] double late_start(const SessionOutcome& outcome) {
  double late = 0.0;
  if (!outcome.session) return outcome.unread ? 2.0 : 0.0;
  const Trajectory& t = outcome.session->trajectory;
  for (const SiteTrajectory& site : t.sites)
    late = std::max(late, static_cast<double>(site.samples.front().slot) * t.tick);
  return late;
}

/// A machine that took the processor away: neither the analysis nor virtual time has that.
[[nodiscard]] bool missed_too_many(const SessionOutcome& outcome) {
  return outcome.session && outcome.session->missed_share > kMostMissed;
}

[[nodiscard]] SessionOutcome read(const RealSession& session, const core::Scene& scene) {
  SessionOutcome outcome;
  outcome.failure = session.failure;
  if (!outcome.failure.empty()) return outcome;
  try {
    outcome.session = read_session(session, scene, packet_bytes(scene));
  } catch (const std::exception& e) {
    outcome.failure = e.what();
    outcome.unread = true;
  }
  return outcome;
}

}  // namespace

SessionBatches::SessionBatches(const std::string& name, int sites, int at_once, int most_nodes,
                               const NodeProgram& program)
    : most_nodes_(most_nodes), lead_per_node_(inside_guest() ? 1.0 : 0.2) {
  for (int i = 0; i < std::max(1, at_once); ++i)
    networks_.push_back(std::make_unique<RealNetwork>(
        fmt::format("{}-{}", name, static_cast<char>('a' + i)), sites, program));
}

std::vector<SessionOutcome> SessionBatches::run_batch(const std::vector<Assignment>& assignments) {
  int nodes = 0;
  for (const Assignment& a : assignments) nodes += node_count(a.request.scene);
  constexpr double kSpare = 0.4;  // [s]
  const std::int64_t begin_ns = core::MonotonicClock().now_ns();
  const std::vector<RealSession> sessions =
      run_sessions(assignments, kSpare + lead_per_node_ * nodes);
  // How long it took, for the next ones: slowly less, at once more.
  double took = 0.0;
  for (const RealSession& session : sessions)
    took = session.ready_ns == 0
               ? 1e9
               : std::max(took, 1e-9 * static_cast<double>(session.ready_ns - begin_ns));
  if (took < 1e9) {
    const double needed = took / nodes + kToReady;
    lead_per_node_ = std::clamp(std::max(needed, 0.5 * (lead_per_node_ + needed)), least_lead_,
                                std::max(least_lead_, kMostLead));
  }
  std::vector<SessionOutcome> outcomes;
  for (std::size_t i = 0; i < sessions.size(); ++i) {
    session_seconds_ += assignments[i].request.seconds;
    outcomes.push_back(read(sessions[i], assignments[i].request.scene));
  }
  return outcomes;
}

void SessionBatches::run(const std::vector<SessionJob>& jobs,
                         const std::function<void(const SessionJob&, SessionOutcome)>& done) {
  std::vector<SessionJob> again;
  std::vector<SessionOutcome> before;
  run_once(jobs, [&](const SessionJob& job, SessionOutcome outcome) {
    if (!missed_too_many(outcome)) return done(job, std::move(outcome));
    again.push_back(job);
    before.push_back(std::move(outcome));
  });
  std::size_t i = 0;
  run_once(again, [&](const SessionJob& job, SessionOutcome outcome) {
    SessionOutcome& first = before[i++];
    const bool better =
        outcome.session && outcome.session->missed_share < first.session->missed_share;
    done(job, std::move(better ? outcome : first));
  });
}

void SessionBatches::run_once(const std::vector<SessionJob>& jobs,
                              const std::function<void(const SessionJob&, SessionOutcome)>& done) {
  for (std::size_t first = 0; first < jobs.size();) {
    std::vector<Assignment> assignments;
    int nodes = 0;
    std::size_t next = first;
    for (; next < jobs.size() && assignments.size() < networks_.size(); ++next) {
      const SessionJob& job = jobs[next];
      nodes += node_count(job.scene);
      if (nodes > most_nodes_ && !assignments.empty()) break;
      assignments.push_back({networks_[assignments.size()].get(),
                             {.scene = with_limited_devices(job.scene),
                              .network = job.network,
                              .seconds = job.seconds,
                              .base = job.base + "_" + job.name}});
    }
    std::vector<SessionOutcome> outcomes;
    // A node that was not ready in time missed what the hands do at the start: once more, with more
    // time.
    const auto late = [](const SessionOutcome& outcome) {
      return late_start(outcome) > kLateStart;
    };
    const double lead = lead_per_node_;
    outcomes = run_batch(assignments);
    if (std::any_of(outcomes.begin(), outcomes.end(), late)) {
      // What was too short once is not tried again.
      least_lead_ = std::min(lead + kToReady, kMostLead);
      lead_per_node_ = std::min(2.0 * lead + kToReady, kMostLead);
      outcomes = run_batch(assignments);
    }
    for (SessionOutcome& outcome : outcomes) {
      if (outcome.session && late_start(outcome) > kLateStart)
        outcome.failure = "its nodes were not ready in time", outcome.session.reset();
      done(jobs[first++], std::move(outcome));
    }
  }
}

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

}  // namespace tandem::harness
