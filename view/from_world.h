#pragma once

#include <cmath>

#include "core/axis_state.h"
#include "core/components.h"
#include "core/plane_state.h"
#include "core/site_state.h"
#include "core/space_state.h"
#include "view/snapshot.h"

/// From the three worlds' states to what is drawn.
namespace tandem::view {

[[nodiscard]] inline Body body_of(const core::AxisState& b) {
  return {.p = {b.p, 0, 0}, .v = {b.v, 0, 0}};
}
[[nodiscard]] inline Body body_of(const core::PlaneBody& b) {
  return {.p = {b.p.x, b.p.y, 0},
          .q = Quat(std::cos(0.5 * b.angle), 0, 0, std::sin(0.5 * b.angle)),
          .v = {b.v.x, b.v.y, 0},
          .omega = {0, 0, b.omega}};
}
[[nodiscard]] inline Body body_of(const core::SpaceBody& b) {
  return {.p = b.p, .q = b.q, .v = b.v, .omega = b.omega};
}

template <typename V>
void set_hand(Site& site, const core::HandSample<V>& hand, int fingers,
              std::uint32_t contact_bits) {
  site.has_hand = true;
  for (int f = 0; f < fingers; ++f) {
    Finger& finger = site.fingers[f];
    finger.p = core::to_vec3(hand[f].p);
    finger.v = core::to_vec3(hand[f].v);
    const int contact = core::contact_of_finger(contact_bits, f);
    finger.contact = core::contact_state(contact_bits, contact);
    finger.side = core::contact_side(contact_bits, contact);
  }
}

template <typename Bodies>
void set_objects(Site& site, const Bodies& bodies, int count) {
  site.has_objects = count > 0;
  for (int o = 0; o < count; ++o) site.objects[o] = body_of(bodies[o]);
}

}  // namespace tandem::view
