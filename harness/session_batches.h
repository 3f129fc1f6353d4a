#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "harness/real_network.h"
#include "harness/recorded_session.h"

namespace tandem::harness {

/// One session to run on sockets, whose nodes leave their files at BASE_....
struct SessionJob {
  std::size_t point = 0;  ///< of the sweep
  std::string name;       ///< "kick", "push", "carry", "0.9", "1.1"
  core::Scene scene;
  LinkConditions network;
  double seconds = 5.0;
  std::string base;
};

/// What became of it; `failure` says why there is no session.
struct SessionOutcome {
  std::optional<RecordedSession> session;
  std::string failure;
  bool unread = false;  ///< all nodes ended well, but a recording is missing or empty
};

/// Runs sessions several at a time, each in a network of its own: with one processor a session of
/// two nodes leaves most of it idle.
class SessionBatches {
 public:
  /// `at_once` networks of `sites` sites are made, NAME-a, NAME-b, ...; more force loops than
  /// `most_nodes` are not started at the same time. Throws HarnessError.
  SessionBatches(const std::string& name, int sites, int at_once, int most_nodes,
                 const NodeProgram& program);

  /// `done(job, outcome)` after each. One that missed too many of its ticks (kMostMissed) runs
  /// again at the end, and the better of the two counts. Throws HarnessError for what concerns the
  /// networks themselves, and Interrupted.
  void run(const std::vector<SessionJob>& jobs,
           const std::function<void(const SessionJob&, SessionOutcome)>& done);

  /// For probes, while no session runs.
  [[nodiscard]] RealNetwork& network() { return *networks_.front(); }
  /// Of all that was run so far [s].
  [[nodiscard]] double session_seconds() const { return session_seconds_; }

 private:
  void run_once(const std::vector<SessionJob>& jobs,
                const std::function<void(const SessionJob&, SessionOutcome)>& done);
  std::vector<SessionOutcome> run_batch(const std::vector<Assignment>& assignments);

  std::vector<std::unique_ptr<RealNetwork>> networks_;
  int most_nodes_;
  double lead_per_node_;      ///< from the start of the first to slot 0, as this machine needs [s]
  double least_lead_ = 0.02;  ///< a shorter one was seen to be too short [s]
  double session_seconds_ = 0.0;
};

/// The scene as nodes run it: a finger whose device is not limited gets one with the largest force
/// there is, because a node drives no device without a limit.
[[nodiscard]] core::Scene with_limited_devices(core::Scene scene);

}  // namespace tandem::harness
