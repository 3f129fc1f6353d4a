#include "view/interpolate.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include <glm/gtc/quaternion.hpp>

#include "core/space_rotation.h"

namespace tandem::view {

Vec3 hermite(const Vec3& p0, const Vec3& v0, const Vec3& p1, const Vec3& v1, double s,
             double span) {
  const double s2 = s * s, s3 = s2 * s;
  return p0 * (2 * s3 - 3 * s2 + 1) + v0 * ((s3 - 2 * s2 + s) * span) + p1 * (3 * s2 - 2 * s3) +
         v1 * ((s3 - s2) * span);
}

Quat hermite(const Quat& q0, const Vec3& w0, const Quat& q1, const Vec3& w1, double s,
             double span) {
  const Vec3 whole = core::rotation_between(q0, q1);
  return glm::normalize(core::rotation_by(hermite(Vec3{0.0}, w0, whole, w1, s, span)) * q0);
}

void SiteBuffer::add(double time, const Site& site) {
  constexpr double kKeep = 0.5;                                               // [s]
  if (!states_.empty() && time < states_.back().time - 2.0) states_.clear();  // started anew
  const auto after = std::find_if(states_.rbegin(), states_.rend(),
                                  [&](const State& s) { return s.time <= time; });
  if (after != states_.rend() && after->time == time) return;
  states_.insert(after.base(), State{time, site});
  while (states_.size() > 2 && states_.front().time < states_.back().time - kKeep)
    states_.pop_front();
}

bool SiteBuffer::at(double time, int fingers, int objects, Site& out) const {
  if (states_.empty()) return false;
  const auto next =
      std::find_if(states_.begin(), states_.end(), [&](const State& s) { return s.time > time; });
  if (next == states_.begin()) {
    out = states_.front().site;
    return true;
  }
  const State& a = *std::prev(next);
  out = a.site;
  if (next == states_.end()) {
    // x + v (t - t^2 / 2 most): the speed is gone after kMostAhead.
    const double t = std::clamp(time - a.time, 0.0, kMostAhead);
    const double way = t - 0.5 * t * t / kMostAhead, keep = 1.0 - t / kMostAhead;
    for (int f = 0; f < fingers; ++f) {
      out.fingers[f].p += a.site.fingers[f].v * way;
      out.fingers[f].v *= keep;
    }
    for (int o = 0; o < objects; ++o) {
      Body& body = out.objects[o];
      body.p += body.v * way;
      body.q = core::rotation_by(body.omega * way) * body.q;
      body.v *= keep;
      body.omega *= keep;
    }
    return true;
  }
  const double span = next->time - a.time, s = (time - a.time) / span;
  const Site& b = next->site;
  for (int f = 0; f < fingers; ++f) {
    const Finger &from = a.site.fingers[f], &to = b.fingers[f];
    out.fingers[f].p = hermite(from.p, from.v, to.p, to.v, s, span);
    out.fingers[f].v = from.v + (to.v - from.v) * s;
    out.fingers[f].force = from.force + (to.force - from.force) * s;
  }
  for (int o = 0; o < objects; ++o) {
    const Body &from = a.site.objects[o], &to = b.objects[o];
    Body& body = out.objects[o];
    body.p = hermite(from.p, from.v, to.p, to.v, s, span);
    body.q = hermite(from.q, from.omega, to.q, to.omega, s, span);
    body.v = from.v + (to.v - from.v) * s;
    body.omega = from.omega + (to.omega - from.omega) * s;
  }
  return true;
}

void PlaybackClock::arrived(double time, double now) {
  const double offset = time - now;  // grows when a packet was quicker than those before
  constexpr double kLetGo = 0.002;   // [s/s]: a clock that drifts, a way that became longer
  constexpr double kAnew = 1.0;      // [s]: another session
  if (!known_ || std::abs(offset - offset_) > kAnew) {
    offset_ = offset;
    known_ = true;
    showing_ = false;
  }
  offset_ = std::max(offset, offset_ - kLetGo * std::max(0.0, now - last_arrival_));
  last_arrival_ = now;
}

double PlaybackClock::at(double now) {
  // The drawn time goes a tenth faster or slower at most, so that a change of the offset is no
  // jump.
  constexpr double kRate = 0.1;
  const double wanted = now + offset_ - buffer_;
  if (!showing_) {
    shown_ = wanted;
    showing_ = true;
  } else {
    const double step = std::max(0.0, now - last_now_);
    shown_ = std::clamp(wanted, shown_ + (1.0 - kRate) * step, shown_ + (1.0 + kRate) * step);
  }
  last_now_ = now;
  return shown_;
}

}  // namespace tandem::view
