#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "core/scene.h"
#include "core/vec.h"

namespace tandem::harness {

inline constexpr double kNotMeasured = std::numeric_limits<double>::quiet_NaN();

/// One tick of one workstation, as a recording has it (core::TickRecord) and as a loop shows it.
struct SiteSample {
  std::int64_t slot = 0;
  std::array<core::Vec3, core::kMaxFingers> hand{};   ///< position of each finger [m]
  std::array<core::Vec3, core::kMaxFingers> force{};  ///< on each finger, as commanded [N]
  core::Vec3 object{0.0};       ///< centre of this site's copy of the first object [m]
  double angle = 0.0;           ///< its rotation (plane), else 0 [rad]
  double network_energy = 0.0;  ///< given to this site by its network port so far [J]
};

/// One workstation over a session; slots rise, with gaps where ticks were missed.
struct SiteTrajectory {
  std::string user;
  int fingers = 0;
  bool has_object = false;  ///< a central client sees the object through the server only
  bool has_network_energy = false;
  std::vector<SiteSample> samples;
  std::int64_t packets_sent = 0, packets_accepted = 0, bytes_sent = 0;
};

/// A session, real or virtual, in the form that measures are taken from. Slots of all sites are
/// those of one clock (real runs: shifted by the session's estimate).
struct Trajectory {
  double tick = 1.0 / 1024.0;  ///< [s]
  int ticks_per_packet = 8;
  std::vector<SiteTrajectory> sites;  ///< by user; the object of a central session is at the server
  std::int64_t first_slot = 0;        ///< measures are taken from here: all have joined
};

/// Stable or not, by a written rule. The envelope e(w) is the largest |deviation| in each of
/// kWindows equal windows of the run: gap between copies and between every hand and the object,
/// about their mean in the window. Unstable if any value leaves kBound or is not a number, or if
/// the envelope of the second half, fitted by least squares of log e over time where e is above
/// kFloor, grows by more than kGrowth a second, and by more than 10 % in all. Forced motion and
/// noise of the network have a bounded envelope, whose fit is flat; instability is exponential, so
/// a run that is long enough leaves no doubt; how long is in `doubling_time`.
struct Stability {
  bool stable = true;
  std::string reason;                       ///< why not
  double growth_per_s = kNotMeasured;       ///< factor of the envelope a second
  double growth_per_packet = kNotMeasured;  ///< the same a packet period
  double doubling_time = std::numeric_limits<double>::infinity();  ///< [s]
};

inline constexpr int kWindows = 16;
inline constexpr double kBound = 10.0;   ///< [m]
inline constexpr double kFloor = 1e-12;  ///< [m], below it there is only rounding
inline constexpr double kGrowth = 1.02;  ///< a second

struct SiteMeasures {
  double packets_per_s = kNotMeasured, bytes_per_s = kNotMeasured;  ///< sent
  double force_rms = kNotMeasured;                                  ///< on the first finger [N]
  double force_error = kNotMeasured;                                ///< RMS against the twin [N]
  double force_error_weber = kNotMeasured;   ///< the same of |error| / max(|F twin|, 0.5 N)
  double network_energy = kNotMeasured;      ///< largest net energy that the port gave so far [J]
  double network_energy_end = kNotMeasured;  ///< at the end [J]
};

/// Measures of one session (methods, section 4).
struct Measures {
  Stability stability;
  double gap_rms = kNotMeasured;             ///< widest distance of two copies' centres, RMS [m]
  double gap_999 = kNotMeasured;             ///< the same, 99.9 % [m]
  double drag = kNotMeasured;                ///< F / v under a constant force [N s/m]; own session
  double rendered_stiffness = kNotMeasured;  ///< force over displacement, other hand held [N/m]
  double motion_to_force = kNotMeasured;     ///< hand moves until the other's force changes [s]
  std::vector<SiteMeasures> sites;
};

[[nodiscard]] Stability judge_stability(const Trajectory& session);

/// Gap, energy, packets, force RMS, and against `twin` (nullptr: not measured) the force error:
/// the same session with the same hand input where the network takes no time and loses nothing.
[[nodiscard]] Measures measure(const Trajectory& session, const Trajectory* twin = nullptr);

/// Drag of a session in which a constant `force` pushed one hand of `site`: its mean velocity over
/// whole packet periods in the last quarter. Also gives whether it had settled (the velocity of the
/// quarter before differs by less than 1 %).
struct MeasuredDrag {
  double n_s_per_m = kNotMeasured;
  bool settled = false;
};
[[nodiscard]] MeasuredDrag measure_drag(const Trajectory& session, int site, double force);

/// Force over displacement of `site`'s first finger, by least squares over the last half of the
/// run, about its means: a hand that moves slowly against another that is held [N/m].
[[nodiscard]] double measure_stiffness(const Trajectory& session, int site);

/// From the first slot where `mover`'s hand is further than `motion` [m] from where it was at
/// first_slot, to the first where the force on `feeler`'s hand differs from its mean before by more
/// than `force` [N]. Resolution is a tick [s]; not a number if it never does.
[[nodiscard]] double motion_to_force(const Trajectory& session, int mover, int feeler,
                                     double motion, double force);

}  // namespace tandem::harness
