#pragma once

#include <cmath>
#include <deque>

#include "view/snapshot.h"

/// A spectator gets states now and then, late and not all of them; it draws many times between. It
/// shows the session a little later than it hears of it, so that it can go from one state to the
/// next.
namespace tandem::view {

/// Position and velocity between two samples: cubic Hermite. `s` in 0 .. 1, `span` [s].
[[nodiscard]] Vec3 hermite(const Vec3& p0, const Vec3& v0, const Vec3& p1, const Vec3& v1, double s,
                           double span);
/// The same of a rotation, on the rotation vector from q0 to q1 (angular velocities in W).
[[nodiscard]] Quat hermite(const Quat& q0, const Vec3& w0, const Quat& q1, const Vec3& w1, double s,
                           double span);

/// One site's states over time. Times are the sender's [s].
class SiteBuffer {
 public:
  /// Old, repeated and reordered ones are fine.
  void add(double time, const Site& site);
  /// The site at a time: between two states interpolated; after the newest moved on with its
  /// velocity, at most `kMostAhead`, the speed dying away. False before the first state.
  [[nodiscard]] bool at(double time, int fingers, int objects, Site& out) const;
  [[nodiscard]] bool empty() const noexcept { return states_.empty(); }
  [[nodiscard]] double newest() const noexcept { return states_.back().time; }

  static constexpr double kMostAhead = 0.060;  ///< [s]

 private:
  struct State {
    double time = 0.0;
    Site site;
  };
  std::deque<State> states_;  ///< in order of time
};

/// Lets no step be seen: when the newest states say that the guess over a gap was wrong, the
/// drawing goes from where it was, and the difference dies away (time constant 40 ms).
class Softener {
 public:
  /// `at`: to draw now; `gap_ended`: states arrived for a time that was guessed before; `drawn`:
  /// what was drawn last; `seconds`: since then.
  [[nodiscard]] Vec3 soften(const Vec3& at, const Vec3& velocity, bool gap_ended, double seconds) {
    constexpr double kTimeConstant = 0.040;
    if (gap_ended && drawn_before_) offset_ = drawn_ + velocity * seconds - at;
    offset_ *= std::exp(-seconds / kTimeConstant);
    drawn_ = at + offset_;
    drawn_before_ = true;
    return drawn_;
  }

 private:
  Vec3 offset_{0.0}, drawn_{0.0};
  bool drawn_before_ = false;
};

/// When to draw what: follows the sender's clock by what arrives, behind it by a buffer of packets.
/// The earliest arrivals count (their delay is the least); an offset that stays too early, because
/// the way has become longer, is let go slowly.
class PlaybackClock {
 public:
  /// `buffer` [s]: 2 to 3 packet periods.
  explicit PlaybackClock(double buffer) : buffer_(buffer) {}
  /// A state of the sender's `time` arrived at our `now` [s].
  void arrived(double time, double now);
  /// The sender's time to draw at our `now`; goes forward only.
  [[nodiscard]] double at(double now);
  [[nodiscard]] bool known() const noexcept { return known_; }

 private:
  double buffer_, offset_ = 0.0, last_arrival_ = 0.0, shown_ = 0.0, last_now_ = 0.0;
  bool known_ = false, showing_ = false;
};

}  // namespace tandem::view
