#include "arch_central/central_loop.h"

#include "core/axis_world.h"
#include "core/plane_world.h"
#include "core/space_world.h"

namespace tandem::central {

template <typename World>
CentralLoop<World>::CentralLoop(const core::Scene& scene, const core::NetworkModel& network)
    : users_(static_cast<int>(scene.users.size())),
      T_(scene.tick()),
      slots_(scene.packet_slots()),
      hands_(scene),
      server_(scene) {
  constexpr int kServer = core::NetworkModel::kServer;
  slots_.timer = network.packet_timer;
  packet_ticks_[kServer] = core::PacketTicks(slots_, network.phase_ticks[kServer]);
  for (int u = 0; u < users_; ++u) {
    clients_.emplace_back(scene, u);
    packet_ticks_[u] = core::PacketTicks(slots_, network.phase_ticks[u]);
    up_.emplace_back(network.link[u][kServer]);
    down_.emplace_back(network.link[kServer][u]);
  }
  outputs_.resize(clients_.size());
}

template <typename World>
void CentralLoop<World>::tick() noexcept {
  typename Server::Inputs& inputs = inputs_;
  for (int u = 0; u < users_; ++u) {
    hands_.sample(u, sample_);
    if (server_.is_local(u)) {
      server_.observe(u, sample_);
      continue;
    }
    const Site& site = clients_[u].observe(sample_);
    if (packet_ticks_[u].due(slot_)) up_[u].push(site, slot_, packet_ticks_[u].late());
    inputs.fresh[u] = up_[u].receive(slot_);
    inputs.age[u] = up_[u].reckoned_age(slot_) * T_;
  }
  server_.tick(slot_, inputs);
  core::PacketTicks& reply_ticks = packet_ticks_[core::NetworkModel::kServer];
  const bool replies = reply_ticks.due(slot_);
  for (int u = 0; u < users_; ++u) {
    if (server_.is_local(u)) {
      outputs_[u] = server_.output(u);
    } else {
      if (replies) down_[u].push(server_.reply(u), slot_, reply_ticks.late());
      outputs_[u] = clients_[u].tick(slot_, down_[u].receive(slot_));
    }
    hands_.step(u, outputs_[u], slot_);
  }
  ++slot_;
}

template class CentralLoop<core::AxisWorld>;
template class CentralLoop<core::PlaneWorld>;
template class CentralLoop<core::SpaceWorld>;

}  // namespace tandem::central
