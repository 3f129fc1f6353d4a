#include "harness/many_users.h"

#include <fmt/format.h>

#include "harness/sweep.h"

namespace tandem::harness {

namespace {

using core::CouplerParameters;

/// Coupler of `user`'s hand (empty: of copies) on `copy`; null if there is none.
const CouplerParameters* coupler(const core::Scene& scene, const std::string& user,
                                 const std::string& copy) {
  for (const CouplerParameters& c : scene.couplers)
    if (c.user == user && c.copy == copy) return &c;
  return nullptr;
}

}  // namespace

core::Scene with_users(const core::Scene& given, int users) {
  if (given.space != core::Space::kAxis || given.users.size() != 2 || given.objects.size() != 1)
    throw SweepError(fmt::format(
        "users = {}: only an axis scene of two users and one object can get more; '{}' is another",
        users, given.name));
  if (users < 2 || users > core::kMaxUsers)
    throw SweepError(fmt::format("users = {} must be within 2 and {}", users, core::kMaxUsers));
  core::Scene scene = given;
  const core::UserParameters& second = given.users[1];
  const std::string one = given.users[0].name, two = second.name;
  const bool central = given.architecture == core::Architecture::kCentral;
  const CouplerParameters* own = coupler(given, two, central ? "" : two);
  const CouplerParameters* on_first = central ? nullptr : coupler(given, two, one);
  const CouplerParameters* from_first = central ? nullptr : coupler(given, one, two);
  const CouplerParameters* copies = central ? nullptr : coupler(given, "", two);
  const auto add = [&](const CouplerParameters* like, const std::string& name,
                       const std::string& user, const std::string& copy) {
    if (like == nullptr) return;
    CouplerParameters c = *like;
    c.name = name;
    c.user = user;
    c.copy = copy;
    scene.couplers.push_back(c);
  };
  for (int u = 3; u <= users; ++u) {
    core::UserParameters user = second;
    user.name = std::to_string(u);
    user.local = false;
    scene.users.push_back(user);
    add(own, central ? "k" + user.name : "k" + user.name + user.name, user.name,
        central ? "" : user.name);
    add(copies, "ko" + user.name, "", user.name);
    for (int v = 1; v < u; ++v) {
      const std::string other = std::to_string(v);
      add(on_first, "k" + other + user.name, user.name, other);
      add(from_first, "k" + user.name + other, other, user.name);
    }
  }
  if (users > 2) scene.name = fmt::format("{}_{}", given.name, users);
  return scene;
}

}  // namespace tandem::harness
