#pragma once

#include <nlohmann/json.hpp>

#include "bench/scale_measure.h"

/// A row as it crosses from a program with other capacities, and as it is printed.
namespace tandem::bench {

/// `field(key, value&)` for every number of a row.
template <typename Row, typename Field>
void visit_fields(Row& r, Field&& field) {
  field("architecture", r.architecture);
  field("packet_hz", r.packet_hz);
  field("users", r.size.users);
  field("objects", r.size.objects);
  field("capacity_users", r.most_users);
  field("capacity_objects", r.most_objects);
  field("tick_ns", r.tick_ns);
  field("virtual_speed", r.virtual_speed);
  field("finite", r.finite);
  field("values_in", r.values_in);
  field("values_out", r.values_out);
  field("fits_a_datagram", r.fits);
  auto& t = r.traffic;
  field("packets_in_per_s", t.in_per_s);
  field("packets_out_per_s", t.out_per_s);
  field("packets_delivered_per_s", t.delivered_per_s);
  field("bytes_in_per_s", t.bytes_in_per_s);
  field("bytes_out_per_s", t.bytes_out_per_s);
  field("force_thread_share", t.force_share);
  field("link_thread_share", t.link_share);
  field("other_users_share", t.others_share);
  field("missed_share", t.missed_share);
  field("wakeup_p99_us", t.late_p99_us);
  field("why_not", t.why_not);
}

[[nodiscard]] inline nlohmann::ordered_json to_json(const ScaleRow& row) {
  nlohmann::ordered_json json;
  visit_fields(row, [&](const char* key, const auto& value) { json[key] = value; });
  return json;
}

[[nodiscard]] inline ScaleRow row_from(const nlohmann::ordered_json& json) {
  ScaleRow row;
  visit_fields(row, [&](const char* key, auto& value) { json.at(key).get_to(value); });
  return row;
}

}  // namespace tandem::bench
