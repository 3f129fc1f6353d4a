#pragma once

#include <stdexcept>
#include <string>
#include <vector>

#include "core/scene.h"
#include "harness/condition.h"

namespace tandem::harness {

/// What is wrong with a sweep, in words for people.
class SweepError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// One session of a sweep: a scene with its edits done, what the network does to it, how long.
struct SweepPoint {
  std::string name;          ///< unique in the sweep: "distributed/hold/delay=5 ms"
  std::string architecture;  ///< "central", "distributed", "split", or a scene's name
  std::string style;         ///< "hold", "compensated", "extrapolate", or "" where a file sets it
  std::string knob;          ///< what is swept: "delay"
  double value = 0.0;        ///< its value in `unit` of the sweep
  std::string label;         ///< the value for people: "5 ms", "outage 100 ms"
  std::string scene_name;    ///< shipped scene or file it came from
  std::vector<std::string> edits;  ///< PATH=VALUE done to it
  core::Scene scene;               ///< edited and validated; the only truth
  LinkConditions network;
  double seconds = 5.0;  ///< measured, after the session has joined
};

struct Sweep {
  std::string name, title;
  std::string knob, unit;  ///< of the horizontal axis
  std::vector<SweepPoint> points;
};

struct SweepOptions {
  bool quick = false;    ///< a few points only
  double seconds = 0.0;  ///< of every point; 0: the sweep's own
};

/// Names of the built-in sweeps: thesis, rate, delay, jitter, loss, users, conditions.
[[nodiscard]] const std::vector<std::string>& built_in_sweeps();

/// A built-in sweep by name or a sweep file (harness/sweep.proto, protobuf text). Throws SweepError
/// or scene::SceneError: unknown names, impossible combinations, with what there is.
[[nodiscard]] Sweep load_sweep(const std::string& name_or_file, const SweepOptions& options = {});

/// The axis scenes, in every style, over one recorded network: `recorded` holds the fields of that
/// message of harness/sweep.proto, round_trips: "FILE". Throws SweepError.
[[nodiscard]] Sweep recorded_sweep(const std::string& recorded, const SweepOptions& options = {});

/// The point's scene as a scene file, for nodes.
[[nodiscard]] std::string scene_text(const SweepPoint& point);

}  // namespace tandem::harness
