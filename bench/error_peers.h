#pragma once

#include <string>
#include <vector>

#include "bench/error_run.h"

namespace tandem::bench {

/// A program beside `tandem` that runs one engine; it never links into this one.
struct Peer {
  std::string name;
  std::string command;  ///< program and first arguments, already quoted for the shell
  std::string missing;  ///< why it cannot be run, and what to install; empty: it can
};

struct PeerRun {
  std::string setting;
  int hz = 0;
  ErrorRun run;
};

/// Box2D, Bullet and ODE as programs beside this one, MuJoCo in `python` (a program's name).
[[nodiscard]] std::vector<Peer> find_peers(const std::string& python);

/// All settings and rates of one point. Throws std::runtime_error with what the program said.
[[nodiscard]] std::vector<PeerRun> run_peer(const Peer& peer, int point);

}  // namespace tandem::bench
