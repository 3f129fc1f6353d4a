#include "node/session_setup.h"

#include <cstdio>
#include <stdexcept>

#include "node/site_name.h"

namespace tandem::node {

int user_index(const core::Scene& scene, const std::string& name, const std::string& what) {
  const int index = core::index_of(scene.users, name);
  if (index >= 0) return index;
  std::string known;
  for (const core::UserParameters& user : scene.users)
    known += (known.empty() ? "" : ", ") + user.name;
  throw std::invalid_argument(what + ": scene " + scene.name + " has no user \"" + name +
                              "\"; it has " + known);
}

core::RealtimeRequest link_realtime(const core::RealtimeRequest& of_loop) {
  constexpr int kBelow = 10;
  core::RealtimeRequest link = of_loop;
  if (link.priority > 0) link.priority = std::max(1, of_loop.priority - kBelow);
  link.cpu.reset();          // the force loop spins there
  link.lock_memory = false;  // for the whole process and machine: the force thread asks for these
  link.hold_cpu_dma_latency = false;
  return link;
}

void demand_silence(const SessionSetup& setup) {
  if (setup.peers.empty() || setup.scene.silence || setup.options.without_silence) return;
  throw std::runtime_error(
      "scene " + setup.scene.name +
      " has no part silence: the force of a peer that dies would stay on for ever; put "
      "silence { timeout: 0.1  fade: 0.1 } into it (--without-silence runs it all the same: "
      "never with a person's hand in a device)");
}

void tell_address(const SessionSetup& setup, const net::PeerLink& link) {
  std::fprintf(stderr, "%s: scene %s at %s\n", site_name(setup.role, setup.user).c_str(),
               setup.scene.name.c_str(), net::to_string(link.local()).c_str());
}

}  // namespace tandem::node
