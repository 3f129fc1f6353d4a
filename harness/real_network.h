#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/scene.h"
#include "harness/child.h"
#include "harness/condition.h"
#include "harness/namespaces.h"
#include "harness/point_result.h"

namespace tandem::harness {

/// One process of a session that has run.
struct RealNode {
  std::string name;       ///< "server", "client 2", "replica 1"
  std::string user;       ///< "server" for a server
  std::string recording;  ///< its file
  std::string said;
  int exit_status = 0;
  nlohmann::ordered_json report;  ///< what it wrote with --json; null: nothing
};

struct RealSession {
  std::vector<RealNode> nodes;
  std::string failure;  ///< why it did not end well, with what the node said; empty: it did
  std::int64_t start_ns = 0;
  std::int64_t ready_ns = 0;  ///< when its last node had joined; 0: one did not say so
};

/// A session to run on sockets.
struct SessionRequest {
  core::Scene scene;
  LinkConditions network;
  double seconds = 5.0;
  std::string base;  ///< files are BASE.scene, BASE_user_1.h5, BASE_user_1.json, ...
};

/// What runs as a node: this program, by its file or, where that is slow (user-mode Linux), as a
/// fork of ours that goes through the same main with the same words.
struct NodeProgram {
  std::string file;
  Main main = nullptr;
};

/// Workstations on this machine with netem between them; see Namespaces. Made once for many
/// sessions. For one thread.
class RealNetwork {
 public:
  /// `program`: the tandem that is started as nodes. Throws HarnessError.
  RealNetwork(const std::string& name, int sites, NodeProgram program);

  RealNetwork(const RealNetwork&) = delete;
  RealNetwork& operator=(const RealNetwork&) = delete;

  /// What `tandem probe` saw of a condition on the way from site 0 to site 1, the way back clear:
  /// delay is the round trip less that of a clear network; a rate is seen from two sizes of
  /// datagram. Outages and recorded networks are played while it runs.
  [[nodiscard]] SeenLink probe(const Condition& condition, const ProbePlan& plan);

 private:
  friend class RunningSession;
  [[nodiscard]] nlohmann::json probe_once(const ProbePlan& plan, int bytes,
                                          const Condition* played = nullptr);

  Namespaces spaces_;
  NodeProgram program_;
  double clear_p50_ = -1.0;
};

/// Runs a session on each of the networks, all at the same time: puts the conditions on all ways
/// out, starts the nodes together, plays what changes, and waits for their end. A node that dies
/// ends its session; that, and a run that takes far too long, is in `failure` and is no exception.
/// Throws HarnessError for what concerns the network itself and when interrupted.
struct Assignment {
  RealNetwork* network = nullptr;
  SessionRequest request;
};
/// `lead`: time that nodes have until slot 0 is due [s], beside that of the packets of their
/// handshake.
[[nodiscard]] std::vector<RealSession> run_sessions(const std::vector<Assignment>& assignments,
                                                    double lead);

/// The condition on a site's way out: `there` leads from lower to higher users and from a server,
/// `back` the other way; with more than two sites both are the same.
[[nodiscard]] const Condition& way_out(const LinkConditions& network, int site);

}  // namespace tandem::harness
