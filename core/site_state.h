#pragma once

#include <array>
#include <cstdint>

#include "core/components.h"
#include "core/finger_sample.h"
#include "core/packet.h"
#include "core/scene.h"

namespace tandem::core {

/// What a site tells the others once a packet period: its user's fingers and its copies of the
/// objects (a client of a server has none).
template <typename World>
struct SiteState {
  HandSample<typename World::Vector> fingers{};
  std::array<typename World::Body, kMaxObjects> objects{};
  std::uint32_t contact_bits = 0;
  double energy_in = 0.0;   ///< absorbed so far at the port to the receiver [J]
  double energy_out = 0.0;  ///< delivered so far [J]
};

/// What the server returns to one client: the force on each of its fingers, and the objects to see.
template <typename World>
struct ServerReply {
  std::array<typename World::Vector, kMaxFingers> forces{};
  std::array<typename World::Body, kMaxObjects> objects{};
  std::uint32_t contact_bits = 0;
};

/// How many values of a SiteState or ServerReply are in use.
struct SiteCounts {
  int fingers = 0;
  int objects = 0;
};

namespace detail {

/// Writes or reads the numbers of a state in their wire order.
struct PackVisitor {
  StatePacket* packet;
  void one(double x) noexcept {
    if (packet->value_count < kMaxPacketValues) packet->values[packet->value_count++] = x;
  }
  template <typename T>
  void all(const T& x) noexcept {
    for (int i = 0; i < kComponents<T>; ++i) one(component(x, i));
  }
  template <typename T>
  void position(const T& x) noexcept {
    all(x);
  }
  template <typename T>
  void velocity(const T& x) noexcept {
    all(x);
  }
  template <typename T>
  void force(const T& x) noexcept {
    all(x);
  }
  void angle(double x) noexcept { one(x); }
  template <typename T>
  void angular_velocity(const T& x) noexcept {
    all(x);
  }
  void orientation(const Quat& q) noexcept { one(q.w), one(q.x), one(q.y), one(q.z); }
};

struct UnpackVisitor {
  const StatePacket* packet;
  int next = 0;
  [[nodiscard]] double one() noexcept {
    return next < packet->value_count ? packet->values[next++] : 0.0;
  }
  template <typename T>
  void all(T& x) noexcept {
    for (int i = 0; i < kComponents<T>; ++i) component(x, i) = one();
  }
  template <typename T>
  void position(T& x) noexcept {
    all(x);
  }
  template <typename T>
  void velocity(T& x) noexcept {
    all(x);
  }
  template <typename T>
  void force(T& x) noexcept {
    all(x);
  }
  void angle(double& x) noexcept { x = one(); }
  template <typename T>
  void angular_velocity(T& x) noexcept {
    all(x);
  }
  void orientation(Quat& q) noexcept {
    q.w = one();
    q.x = one();
    q.y = one();
    q.z = one();
  }
};

}  // namespace detail

/// Visits fingers, then objects, of a state in use.
template <typename World, typename Visitor>
void visit_site(SiteState<World>& state, const SiteCounts& counts, Visitor&& visitor) {
  for (int f = 0; f < counts.fingers; ++f) {
    visitor.position(state.fingers[f].p);
    visitor.velocity(state.fingers[f].v);
  }
  for (int o = 0; o < counts.objects; ++o) World::visit_body(state.objects[o], visitor);
}

template <typename World, typename Visitor>
void visit_reply(ServerReply<World>& reply, const SiteCounts& counts, Visitor&& visitor) {
  for (int f = 0; f < counts.fingers; ++f) visitor.force(reply.forces[f]);
  for (int o = 0; o < counts.objects; ++o) World::visit_body(reply.objects[o], visitor);
}

/// Fills `packet.values`, contact bits and energy counters; the link fills the rest.
template <typename World>
void pack(SiteState<World> state, const SiteCounts& counts, StatePacket& packet) noexcept {
  packet.value_count = 0;
  visit_site(state, counts, detail::PackVisitor{&packet});
  packet.contact_bits = state.contact_bits;
  packet.energy_in = state.energy_in;
  packet.energy_out = state.energy_out;
}
template <typename World>
void unpack(const StatePacket& packet, const SiteCounts& counts, SiteState<World>& state) noexcept {
  visit_site(state, counts, detail::UnpackVisitor{&packet});
  state.contact_bits = packet.contact_bits;
  state.energy_in = packet.energy_in;
  state.energy_out = packet.energy_out;
}
template <typename World>
void pack(ServerReply<World> reply, const SiteCounts& counts, StatePacket& packet) noexcept {
  packet.value_count = 0;
  visit_reply(reply, counts, detail::PackVisitor{&packet});
  packet.contact_bits = reply.contact_bits;
}
template <typename World>
void unpack(const StatePacket& packet, const SiteCounts& counts,
            ServerReply<World>& reply) noexcept {
  visit_reply(reply, counts, detail::UnpackVisitor{&packet});
  reply.contact_bits = packet.contact_bits;
}

}  // namespace tandem::core
