#pragma once

#include <array>
#include <cstdint>

#include "core/records.h"
#include "core/site_state.h"

namespace tandem::node {

/// How many values a packet carries.
template <typename World>
[[nodiscard]] std::int32_t site_value_count(const core::SiteCounts& counts) noexcept {
  core::StatePacket packet;
  core::pack(core::SiteState<World>{}, counts, packet);
  return packet.value_count;
}
template <typename World>
[[nodiscard]] std::int32_t reply_value_count(const core::SiteCounts& counts) noexcept {
  core::StatePacket packet;
  core::pack(core::ServerReply<World>{}, counts, packet);
  return packet.value_count;
}

/// State of a body in the order of the wire.
template <typename World>
void write_body(typename World::Body body,
                std::array<double, core::kMaxObjectValues>& values) noexcept {
  core::StatePacket packet;
  World::visit_body(body, core::detail::PackVisitor{&packet});
  for (int i = 0; i < packet.value_count && i < core::kMaxObjectValues; ++i)
    values[i] = packet.values[i];
}

}  // namespace tandem::node
