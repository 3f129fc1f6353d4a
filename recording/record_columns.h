#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "core/records.h"

namespace tandem::recording {

/// Which part of the fixed-size records a session uses, so only that is stored. A count of 0 leaves
/// the column out.
struct RecordColumns {
  int fingers = 0;        ///< of this node's user, up to kMaxFingers
  int hand_values = 3;    ///< of a position: 1 axis, 2 plane, 3 space
  int users = 0;          ///< ages, up to kMaxUsers
  int objects = 0;        ///< up to kMaxObjects
  int object_values = 0;  ///< of an object's state, up to kMaxObjectValues
  bool contacts = false;  ///< contact bits of the objects
  int packet_values = 0;  ///< of a state packet, up to kMaxPacketValues
};

/// Throws std::invalid_argument with the field, its value and its range.
void check(const RecordColumns& columns);

/// The one list of a tick's columns: the file's layout, writing, reading and CSV walk it.
///   visitor.one(name, unit, value&)
///   visitor.many(name, unit, {rows, columns}, element) with element(row, column) -> value&
template <typename Record, typename Visitor>
void visit_tick_columns(Record& r, const RecordColumns& c, Visitor&& visitor) {
  visitor.one("slot", "1", r.slot);
  visitor.one("due_ns", "ns", r.due_ns);
  visitor.one("woke_ns", "ns", r.woke_ns);
  visitor.one("faults", "bits", r.faults);
  visitor.one("fresh", "bits", r.fresh);
  visitor.many(
      "hand_position", "m",
      {c.fingers, c.hand_values}, [&](int f, int i) -> auto& { return r.hands[f].position[i]; });
  visitor.many(
      "hand_velocity", "m/s",
      {c.fingers, c.hand_values}, [&](int f, int i) -> auto& { return r.hands[f].velocity[i]; });
  visitor.many(
      "command_force", "N",
      {c.fingers, c.hand_values}, [&](int f, int i) -> auto& { return r.command[f][i]; });
  visitor.many(
      "age", "s", {1, c.users}, [&](int, int u) -> auto& { return r.ages[u]; });
  visitor.many(
      "object_state", "m, rad, m/s, rad/s",
      {c.objects, c.object_values}, [&](int o, int i) -> auto& { return r.objects[o][i]; });
  visitor.many(
      "contact_bits", "4 bits a contact",
      {1, c.contacts ? c.objects : 0}, [&](int, int o) -> auto& { return r.contact_bits[o]; });
}

/// The same for a packet.
template <typename Record, typename Visitor>
void visit_packet_columns(Record& r, const RecordColumns& c, Visitor&& visitor) {
  visitor.one("slot", "1", r.slot);
  visitor.one("peer", "1", r.peer);
  visitor.one("sender", "1", r.packet.sender);
  visitor.one("sequence", "1", r.packet.sequence);
  visitor.one("sender_slot", "1", r.packet.slot);
  visitor.one("send_ns", "ns", r.packet.send_ns);
  visitor.one("echo_ns", "ns", r.packet.echo_ns);
  visitor.one("echo_hold_ns", "ns", r.packet.echo_hold_ns);
  visitor.one("contact_bits", "4 bits a contact", r.packet.contact_bits);
  visitor.one("energy_in", "J", r.packet.energy_in);
  visitor.one("energy_out", "J", r.packet.energy_out);
  visitor.one("value_count", "1", r.packet.value_count);
  visitor.many(
      "values", "WIRE_FORMAT.md",
      {1, c.packet_values}, [&](int, int i) -> auto& { return r.packet.values[i]; });
}

template <typename Visitor>
void visit_columns(core::TickRecord& r, const RecordColumns& c, Visitor&& visitor) {
  visit_tick_columns(r, c, visitor);
}
template <typename Visitor>
void visit_columns(const core::TickRecord& r, const RecordColumns& c, Visitor&& visitor) {
  visit_tick_columns(r, c, visitor);
}
template <typename Visitor>
void visit_columns(core::PacketRecord& r, const RecordColumns& c, Visitor&& visitor) {
  visit_packet_columns(r, c, visitor);
}
template <typename Visitor>
void visit_columns(const core::PacketRecord& r, const RecordColumns& c, Visitor&& visitor) {
  visit_packet_columns(r, c, visitor);
}

/// What a recording says about itself besides its rows.
struct RecordingHeader {
  std::string scene_text;
  std::string scene_hash;
  std::string git_revision;
  std::string program_version;
  std::string user;                     ///< whose node this is; "server"
  double local_rate_hz = 0.0;           ///< of the slots
  std::int64_t start_ns = 0;            ///< when slot 0 was due, monotonic clock
  std::int64_t start_wall_ns = 0;       ///< filled by the writer: both clocks,
  std::int64_t start_monotonic_ns = 0;  ///< read together when the file was made [ns]
};

}  // namespace tandem::recording
