#include "arch_central/server_law.h"

#include "core/axis_world.h"
#include "core/plane_world.h"
#include "core/space_world.h"

namespace tandem::central {

template <typename World>
ServerLaw<World>::ServerLaw(const core::Scene& scene) noexcept
    : world_(scene, 1.0),
      reconstruction_(scene.reconstruction),
      user_count_(static_cast<int>(scene.users.size())) {
  for (int o = 0; o < world_.object_count(); ++o)
    objects_[o] = World::initial_body(scene.objects[o]);
  for (int i = 0; i < user_count_; ++i) {
    const core::UserParameters& parameters = scene.users[i];
    User& user = users_[i];
    user.local = parameters.local || scene.architecture == core::Architecture::kSingle;
    user.fingers = static_cast<int>(parameters.fingers.size());
    if (user.local)
      user.stages = core::FingerStages<Vector>(scene, i);
    else
      user.presence = core::Presence(scene.silence, scene.tick());
    user.latency = core::Latency<Vector, Wrench>(scene.rates.latency_ticks);
    for (int f = 0; f < user.fingers; ++f) {
      user.hand.fingers[f].p = core::from_vec3<Vector>(parameters.fingers[f].position);
      user.radius[f] = parameters.fingers[f].radius;
    }
    for (const core::CouplerParameters& coupler : scene.couplers) {
      const int o = core::index_of(scene.objects, coupler.object);
      if (coupler.user != parameters.name || o < 0) continue;
      for (int f = 0; f < user.fingers; ++f)
        user.grasps[f][o] = World::grasp(scene, coupler, parameters.fingers[f], scene.objects[o],
                                         parameters.mass, user.local);
    }
  }
  if constexpr (World::kSpace == core::Space::kAxis)
    for (int o = 0; o < world_.object_count(); ++o) {
      core::Gain sum;
      for (int u = 0; u < user_count_; ++u)
        for (int f = 0; f < users_[u].fingers; ++f)
          if (const auto& grasp = users_[u].grasps[f][o]; grasp.exact) {
            sum.stiffness += grasp.gain.stiffness;
            sum.damping += grasp.gain.damping;
          }
      world_.hold(o, sum);
    }
}

template <typename World>
void ServerLaw<World>::tick(std::int64_t slot, const Inputs& inputs) noexcept {
  accept(slot, inputs);
  for (int o = 0; o < world_.object_count(); ++o) {
    const typename World::Placed placed = World::place(objects_[o]);
    Wrench total{};
    for (int u = 0; u < user_count_; ++u) {
      users_[u].wrench[o] = users_[u].presence.silent() ? Wrench{} : touch(users_[u], o, placed);
      total += users_[u].wrench[o];
    }
    total = users_[0].latency.delayed(o, total);
    if (world_.has_walls()) total += world_.walls_on_object(o, object_walls_[o], placed);
    const Body before = objects_[o];
    objects_[o] = world_.step(o, before, total);
    if constexpr (World::kSpace == core::Space::kAxis)
      if (world_.holds_exactly()) give_way(o, world_.mean_change(o, before, total));
  }
  for (int u = 0; u < user_count_; ++u) finish(users_[u]);
}

template <typename World>
void ServerLaw<World>::accept(std::int64_t slot, const Inputs& inputs) noexcept {
  for (int u = 0; u < user_count_; ++u) {
    User& user = users_[u];
    if (!user.local && inputs.fresh[u] != nullptr) user.hand = *inputs.fresh[u];
    user.output = {};
    user.hand.contact_bits = 0;
    if (user.local) continue;
    const bool fresh = inputs.fresh[u] != nullptr;
    user.advance = core::advance_by_age(reconstruction_, inputs.age[u]);
    const bool back = user.presence.update(fresh, slot);
    if (user.presence.stale()) user.output.faults |= core::Fault::kStalePeer;
    if (back)
      for (auto& finger : user.contacts) finger.fill({});
  }
}

template <typename World>
auto ServerLaw<World>::touch(User& user, int o, const typename World::Placed& object) noexcept
    -> Wrench {
  const double gain = user.presence.gain();
  Wrench wrench{};
  for (int f = 0; f < user.fingers; ++f) {
    if (!user.grasps[f][o].present) continue;
    const auto touch =
        world_.touch(o, user.contacts[f][o], user.grasps[f][o], user.finger(f), object);
    user.output.forces[f] += touch.on_finger * gain;
    wrench += World::scaled(touch.on_body, gain);
    user.hand.contact_bits |= core::contact_word(World::contact_bits(user.contacts[f][o]), o, f);
  }
  return wrench;
}

/// Forces at the start of the tick become those of its mean (Integrator::kExactCoupler).
template <typename World>
void ServerLaw<World>::give_way(int o, const Body& change) noexcept {
  for (int u = 0; u < user_count_; ++u)
    for (int f = 0; f < users_[u].fingers; ++f) {
      if (!users_[u].grasps[f][o].present) continue;
      if constexpr (World::kSpace == core::Space::kAxis) {
        const Wrench less = World::given_way(users_[u].grasps[f][o], change);
        users_[u].output.forces[f] += less;
        users_[u].wrench[o] -= less;
      }
    }
}

template <typename World>
void ServerLaw<World>::finish(User& user) noexcept {
  if (world_.has_walls())
    for (int f = 0; f < user.fingers; ++f)
      user.output.forces[f] +=
          world_.walls_on_finger(user.walls[f], user.finger(f), user.radius[f]) *
          user.presence.gain();
  user.latency.delay(user.output, user.fingers);
  if (user.local) user.stages.guard(user.output, user.fingers);
}

template <typename World>
auto ServerLaw<World>::reply(int user) const noexcept -> Reply {
  Reply reply;
  reply.forces = users_[user].output.forces;
  reply.objects = objects_;
  reply.contact_bits = users_[user].hand.contact_bits;
  return reply;
}

template class ServerLaw<core::AxisWorld>;
template class ServerLaw<core::PlaneWorld>;
template class ServerLaw<core::SpaceWorld>;

}  // namespace tandem::central
