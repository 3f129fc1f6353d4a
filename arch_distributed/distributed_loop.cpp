#include "arch_distributed/distributed_loop.h"

#include "core/axis_world.h"
#include "core/plane_world.h"
#include "core/space_world.h"

namespace tandem::distributed {

template <typename World>
DistributedLoop<World>::DistributedLoop(const core::Scene& scene, const core::NetworkModel& network)
    : users_(static_cast<int>(scene.users.size())),
      T_(scene.tick()),
      slots_(scene.packet_slots()),
      hands_(scene) {
  slots_.timer = network.packet_timer;
  for (int i = 0; i < users_; ++i) {
    laws_.emplace_back(scene, i);
    packet_ticks_[i] = core::PacketTicks(slots_, network.phase_ticks[i]);
    for (int j = 0; j < users_; ++j) ports_.emplace_back(network.link[i][j]);
  }
  outputs_.resize(laws_.size());
  inputs_.resize(laws_.size());
}

template <typename World>
void DistributedLoop<World>::tick() noexcept {
  for (int i = 0; i < users_; ++i) {
    hands_.sample(i, sample_);
    const Site& site = laws_[i].observe(sample_);
    if (!packet_ticks_[i].due(slot_)) continue;
    for (int j = 0; j < users_; ++j)
      if (j != i) port(i, j).push(site, slot_, packet_ticks_[i].late());
  }
  for (int i = 0; i < users_; ++i) {
    typename Law::Inputs& inputs = inputs_[i];
    for (int j = 0; j < users_; ++j) {
      if (j == i) continue;
      inputs.fresh[j] = port(j, i).receive(slot_);
      inputs.age[j] = port(j, i).reckoned_age(slot_) * T_;
    }
    outputs_[i] = laws_[i].tick(slot_, inputs);
  }
  for (int i = 0; i < users_; ++i) hands_.step(i, outputs_[i], slot_);
  ++slot_;
}

template class DistributedLoop<core::AxisWorld>;
template class DistributedLoop<core::PlaneWorld>;
template class DistributedLoop<core::SpaceWorld>;

}  // namespace tandem::distributed
