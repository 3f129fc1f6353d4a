#pragma once

#include <array>
#include <cmath>
#include <cstdint>

#include "core/contact_state.h"
#include "core/scene.h"

/// What a viewer draws, free of the scene's space: positions are in the world frame W with the
/// coordinates a space lacks at 0. Trivially copyable, so that it crosses threads by
/// core::LatestValue.
namespace tandem::view {

using core::Quat;
using core::Vec3;

/// Sites by index: users 0 .. kMaxUsers - 1, then the server.
inline constexpr int kServerSite = core::kMaxUsers;
inline constexpr int kSites = core::kMaxUsers + 1;

struct Body {
  Vec3 p{0.0};                 ///< centre [m]
  Quat q{1.0, 0.0, 0.0, 0.0};  ///< B to W
  Vec3 v{0.0};                 ///< [m/s]
  Vec3 omega{0.0};             ///< in W [rad/s]
};

struct Finger {
  Vec3 p{0.0};      ///< haptic interface point [m]
  Vec3 v{0.0};      ///< [m/s]
  Vec3 force{0.0};  ///< on the finger [N]; 0 where it is not known
  core::ContactState contact = core::ContactState::kFree;
  int side = 0;  ///< touched side of the object, core/contact_state.h
};

/// What is known of one workstation: its user's hand and its copy of the objects.
struct Site {
  bool has_hand = false;
  bool has_objects = false;
  bool forces_known = false;
  std::array<Finger, core::kMaxFingers> fingers{};
  std::array<Body, core::kMaxObjects> objects{};
  double age = 0.0;   ///< of what we know of it: delay as it acts here [s]; own: 0
  double gain = 1.0;  ///< of its force here: 0 while it is silent
  double loss = 0.0;  ///< packets lost on the way here over the last second, 0 .. 1
};

/// One instant of a session as one site sees it.
struct Snapshot {
  std::int64_t slot = 0;
  double time = 0.0;  ///< of the slot [s]
  int own = 0;        ///< the site whose copies are drawn solid
  std::array<Site, kSites> sites{};
  double lateness = 0.0;     ///< worst wake-up since the snapshot before [s]
  std::int64_t missed = 0;   ///< slots that did not run, so far
  std::uint32_t faults = 0;  ///< core::Fault bits since the snapshot before
};

/// Distance of the centres of two copies of object `o` [m].
[[nodiscard]] inline double replica_gap(const Site& a, const Site& b, int o) {
  const Vec3 d = a.objects[o].p - b.objects[o].p;
  return std::sqrt(d.x * d.x + d.y * d.y + d.z * d.z);
}

}  // namespace tandem::view
