#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "core/realtime.h"
#include "core/rigid.h"
#include "core/view_tap.h"
#include "devices/pointer_feed.h"
#include "node/stability_guard.h"

namespace tandem::node {

/// Who moves the fingers of this node's users.
struct HandOptions {
  bool recorded = false;  ///< false: the scene's simulated hands and devices
  std::string file;       ///< recorded: what to play
  std::string columns;    ///< recorded: which column drives what; see devices/column_mapping.h
  devices::PointerFeed* pointer = nullptr;  ///< set: a pointer leads all fingers
  /// Where devices are in the scene, by their name there. Simulated hands and pointers are in the
  /// scene's frame already and take none.
  std::map<std::string, core::Rigid> frames{};
  std::optional<double> after;  ///< recorded: added to the scene's script from this time on [s]
};

/// What every node can be told, whatever its role.
struct NodeOptions {
  std::string bind = "0.0.0.0:0";  ///< own "ADDRESS:PORT"
  double seconds = 0.0;            ///< run this long; 0: until stopped
  std::int64_t start_ns = 0;  ///< when slot 0 is due on this computer's monotonic clock; 0: soon
  std::string record_file;    ///< empty: nothing is recorded
  HandOptions hands;
  core::RealtimeRequest realtime;
  GuardMaker guard;                 ///< watches the delay against a prediction; empty: nothing does
  core::ViewTap* window = nullptr;  ///< set: the force loop leaves its ticks here for a window
  std::optional<std::int64_t> spin_ns;  ///< not given: what suits the grant
  bool without_silence = false;         ///< runs a scene in which a dead peer's force stays on
  double status_every = 0.0;  ///< [s] between status lines; 0: live on a terminal, else every 5 s
  bool quiet = false;         ///< no status at all
  std::string program_version;
  std::string git_revision;
};

}  // namespace tandem::node
