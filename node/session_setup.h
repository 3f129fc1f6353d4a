#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/components.h"
#include "core/scene.h"
#include "net/peer_link.h"
#include "node/node_options.h"
#include "node/site_values.h"
#include "recording/record_columns.h"

namespace tandem::node {

/// What is settled about a session before its first tick, whatever the role.
struct SessionSetup {
  std::string role;   ///< "replica", "server", "client"
  std::string user;   ///< "server" for a server
  core::Scene scene;  ///< with the limits of the opened devices in it
  NodeOptions options;
  std::vector<std::uint32_t> peers;  ///< sender indices it may hear from
  net::ExchangeOptions exchange;     ///< start_ns is filled in by run_site
  recording::RecordColumns columns;

  /// Name of a sender: its user's, or "server".
  [[nodiscard]] std::string name_of(std::uint32_t sender) const {
    return sender < scene.users.size() ? scene.users[sender].name : std::string("server");
  }
};

/// Columns that hold all of a World's session, with so many own fingers.
template <typename World>
[[nodiscard]] recording::RecordColumns record_columns(const core::Scene& scene, int fingers) {
  recording::RecordColumns columns;
  columns.fingers = fingers;
  columns.hand_values = core::kComponents<typename World::Vector>;
  columns.users = static_cast<int>(scene.users.size());
  columns.objects = static_cast<int>(scene.objects.size());
  columns.object_values = site_value_count<World>({0, 1});
  columns.contacts = true;
  // The longest packet of all: a site with as many fingers as the user with the most.
  for (const core::UserParameters& user : scene.users)
    columns.packet_values =
        std::max(columns.packet_values,
                 site_value_count<World>({static_cast<int>(user.fingers.size()), columns.objects}));
  return columns;
}

/// Index of a user of the scene. Throws std::invalid_argument: `what` names nobody in it.
[[nodiscard]] int user_index(const core::Scene& scene, const std::string& name,
                             const std::string& what);

/// What the link thread asks for when the force thread asks for `of_loop`: a little less.
[[nodiscard]] core::RealtimeRequest link_realtime(const core::RealtimeRequest& of_loop);

/// Throws std::runtime_error where a peer that dies would leave its force on for ever.
void demand_silence(const SessionSetup& setup);

/// Says on stderr where this node can be reached.
void tell_address(const SessionSetup& setup, const net::PeerLink& link);

}  // namespace tandem::node
