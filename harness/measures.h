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

/// Stable or not, by a written rule. The run is cut into kWindows equal windows; the envelope e(w)
/// is the widest range (largest less smallest) that any distance takes in window w: every hand from
/// its object, every copy from the first user's, coordinate by coordinate. Forced motion, jitter
/// and loss keep it bounded; instability is exponential. Not stable if
/// - a distance leaves kBound or is no number, or
/// - log e, fitted by least squares over the second half where e is above kFloor (on sockets also
///   above kFloorOnSockets of the widest), rises by more than kGrowth a second and by more than
///   kRise over the half, or
/// - the last quarter's widest is more than kSwell times that of the first two windows that moved:
///   what has grown until a saturation holds it, or
/// - on sockets, a hand that moves freely speeds up (judge_by_drag).
/// What grows slower than kGrowth a second, or than kRise over half the run, is called stable: so
/// near to the boundary the verdict means nothing, and there points count as near it.
struct Stability {
  bool judged = false;  ///< false: too short, or nothing moved
  bool stable = true;
  std::string reason;                       ///< why not
  double growth_per_s = kNotMeasured;       ///< factor of the envelope a second
  double growth_per_packet = kNotMeasured;  ///< the same a packet period
};

inline constexpr int kWindows = 16;
inline constexpr double kBound = 1.0;    ///< [m]
inline constexpr double kFloor = 1e-11;  ///< [m]; below it rounding of metres shows
/// Of the widest range of the run: on sockets the age of a sample is known to about 0.2 ms (what
/// hands it from the force loop to the link does not count), and extrapolation turns that, with
/// what the hands still drift, into a murmur that never dies: 6e-7 of the kick was seen.
inline constexpr double kFloorOnSockets = 1e-5;
inline constexpr double kGrowth = 1.02;  ///< factor a second
inline constexpr double kRise = 1.1;     ///< factor over the second half
inline constexpr double kSwell = 5.0;    ///< last quarter over start

/// Takes the distances as they come and judges at the end; nothing is stored but ranges.
class StabilityMeter {
 public:
  /// A run of `seconds` from the first add; `packet_period` for growth_per_packet [s]; what is
  /// below the share `floor` of the widest range of all tells nothing, like what is below kFloor.
  StabilityMeter(double seconds, double packet_period, double floor = 0.0);
  /// One distance (numbered by the caller, always alike) at `time` from the start [m].
  void add(double time, int which, double distance);
  /// True once nothing can change the verdict: a run may stop early.
  [[nodiscard]] bool left_bounds() const { return left_; }
  [[nodiscard]] Stability judge() const;

 private:
  struct Range {
    double low = 1e300, high = -1e300;
  };
  double seconds_, period_, floor_;
  std::vector<std::array<Range, kWindows>> ranges_;  ///< by distance
  bool left_ = false;
  double left_at_ = 0.0;
};

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
  double gap_rms = kNotMeasured;  ///< widest distance of two copies' centres, RMS [m]
  double gap_999 = kNotMeasured;  ///< the same, 99.9 % [m]
  double drag = kNotMeasured;     ///< F / v under a constant force [N s/m]; own session
  bool drag_settled = false;
  double rendered_stiffness = kNotMeasured;  ///< force over displacement, other hand held [N/m]
  double motion_to_force = kNotMeasured;     ///< hand moves until the other's force changes [s]
  std::vector<SiteMeasures> sites;
};

/// `floor` as in StabilityMeter; of sessions on sockets kFloorOnSockets.
[[nodiscard]] Stability judge_stability(const Trajectory& session, double floor = 0.0);

/// Such a session has no force error, gap, drag or stiffness worth a number.
[[nodiscard]] bool has_blown_up(const Trajectory& session);

/// Gap, energy, packets, force RMS, and against `twin` (nullptr: not measured) the force error:
/// the same session with the same hand input where the network takes no time and loses nothing.
[[nodiscard]] Measures measure(const Trajectory& session, const Trajectory* twin = nullptr);

/// Drag of a session in which a constant `force` pushed one hand of `site` alone along x. The mean
/// velocities v1, v2, v3 of the last three sixths of the run, taken over whole packet periods, are
/// those of a mass against a viscous drag, v' = (F - b v) / m, whose end is known from three:
///   q = (v3 - v2) / (v2 - v1) = e^(-b T/m),  b = F (1 - q) / (v1 (1 - q) + v2 - v1)
/// also where it has not settled, where there is no drag (q = 1) and where it is negative (q > 1).
/// Where v1 and v2 differ by less than 1 % it is F / v3.
struct MeasuredDrag {
  double n_s_per_m = kNotMeasured;
  bool settled = false;                ///< v3 differs from v2 by less than 1 %
  double growth_per_s = kNotMeasured;  ///< e^(-b/m): of what is left to the end velocity
};
[[nodiscard]] MeasuredDrag measure_drag(const Trajectory& session, int site, double force);

/// A negative drag makes free motion grow exponentially, however little of it a kick left: what was
/// stable so far is not if the drag is below -kLeastDrag, and grows as the push did.
void judge_by_drag(Stability& stability, const MeasuredDrag& drag, double packet_period);
inline constexpr double kLeastDrag = 0.05;  ///< known to that on sockets [N s/m]

/// Force over displacement of `site`'s first finger, by least squares over the last `seconds`,
/// about its means: a hand that moves slowly against another that is held [N/m]. Whole periods of
/// its motion leave out what is in phase with the velocity.
[[nodiscard]] double measure_stiffness(const Trajectory& session, int site, double seconds);

/// From the first slot where `mover`'s hand is further than `motion` [m] from where it was at
/// first_slot, to the first where the force on `feeler`'s hand differs from its mean before by more
/// than `force` [N]. Resolution is a tick [s]; not a number if it never does.
[[nodiscard]] double motion_to_force(const Trajectory& session, int mover, int feeler,
                                     double motion, double force);

}  // namespace tandem::harness
