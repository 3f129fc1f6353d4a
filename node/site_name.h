#pragma once

#include <string>

namespace tandem::node {

/// How messages call a site: "replica 2", "client 2"; there is one server: "server".
[[nodiscard]] inline std::string site_name(const std::string& role, const std::string& user) {
  return role == user ? role : role + " " + user;
}

}  // namespace tandem::node
