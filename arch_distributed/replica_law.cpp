#include "arch_distributed/replica_law.h"

#include "core/axis_world.h"
#include "core/plane_world.h"
#include "core/space_world.h"

namespace tandem::distributed {

template <typename World>
ReplicaLaw<World>::ReplicaLaw(const core::Scene& scene, int user) noexcept
    : world_(scene, scene.architecture == core::Architecture::kDistributedSplit
                        ? 1.0 / static_cast<double>(scene.users.size())
                        : 1.0),
      reconstruction_(scene.reconstruction),
      user_(user),
      user_count_(static_cast<int>(scene.users.size())),
      stages_(scene, user),
      latency_(scene.rates.latency_ticks) {
  for (int j = 0; j < user_count_; ++j) {
    const core::UserParameters& other = scene.users[j];
    finger_counts_[j] = static_cast<int>(other.fingers.size());
    Peer& peer = peers_[j];
    peer.presence = core::Presence(scene.silence, scene.tick());
    for (int f = 0; f < finger_counts_[j]; ++f)
      peer.held.fingers[f].p = core::from_vec3<Vector>(other.fingers[f].position);
    for (int o = 0; o < world_.object_count(); ++o)
      peer.held.objects[o] = World::initial_body(scene.objects[o]);
  }
  own_ = peers_[user].held;
  for (int f = 0; f < finger_counts_[user]; ++f) radius_[f] = scene.users[user].fingers[f].radius;

  for (const core::CouplerParameters& coupler : scene.couplers) {
    if (coupler.copy != scene.users[user].name) continue;
    const int o = core::index_of(scene.objects, coupler.object);
    if (o < 0) continue;
    if (coupler.user.empty()) {
      coordination_[o] = World::coordination(coupler);
      continue;
    }
    const int j = core::index_of(scene.users, coupler.user);
    if (j < 0) continue;
    for (int f = 0; f < finger_counts_[j]; ++f)
      grasps_[j][f][o] = World::grasp(scene, coupler, scene.users[j].fingers[f], scene.objects[o],
                                      scene.users[j].mass, j == user);
    if constexpr (World::kSpace == core::Space::kAxis)
      if (j == user) {
        const auto fingers = static_cast<double>(finger_counts_[j]);
        world_.hold(o, {coupler.gain.stiffness * fingers, coupler.gain.damping * fingers});
      }
  }
}

template <typename World>
auto ReplicaLaw<World>::observe(const core::HandSample<Vector>& hand) noexcept -> const Site& {
  stages_.observe(hand, finger_counts_[user_], own_.fingers);
  return own_;
}

template <typename World>
auto ReplicaLaw<World>::tick(std::int64_t slot, const Inputs& inputs) noexcept -> Output {
  Output output;
  output.faults = accept(slot, inputs);
  own_.contact_bits = 0;
  for (int o = 0; o < world_.object_count(); ++o) {
    const typename World::Placed placed = World::place(own_.objects[o]);
    own_wrench_[o] = own_hand(o, placed, output);
    Wrench network{};
    for (int j = 0; j < user_count_; ++j) {
      const Peer& peer = peers_[j];
      if (j == user_ || peer.presence.silent()) continue;
      network +=
          World::scaled(remote_hand(j, o, placed) + coordinate(peer, o), peer.presence.gain());
    }
    Wrench wrench = latency_.delayed(o, own_wrench_[o] + network);
    if (world_.has_walls()) wrench += world_.walls_on_object(o, object_walls_[o], placed);
    const Body before = own_.objects[o];
    own_.objects[o] = world_.step(o, before, wrench);
    if constexpr (World::kSpace == core::Space::kAxis)
      if (world_.holds_exactly()) give_way(o, world_.mean_change(o, before, wrench), output);
    account(network, before, own_.objects[o]);
  }
  if (world_.has_walls())
    for (int f = 0; f < finger_counts_[user_]; ++f)
      output.forces[f] += world_.walls_on_finger(finger_walls_[f], own_.fingers[f], radius_[f]);

  latency_.delay(output, finger_counts_[user_]);
  stages_.guard(output, finger_counts_[user_]);
  return output;
}

template <typename World>
core::Fault ReplicaLaw<World>::accept(std::int64_t slot, const Inputs& inputs) noexcept {
  core::Fault faults = core::Fault::kNone;
  for (int j = 0; j < user_count_; ++j) {
    if (j == user_) continue;
    Peer& peer = peers_[j];
    const bool fresh = inputs.fresh[j] != nullptr;
    if (fresh) peer.held = *inputs.fresh[j];
    peer.advance = core::advance_by_age(reconstruction_, inputs.age[j]);
    const bool back = peer.presence.update(fresh, slot);
    if (peer.presence.stale()) faults |= core::Fault::kStalePeer;
    if (!back) continue;
    for (int o = 0; o < world_.object_count(); ++o)
      peer.seat[o] =
          World::difference(World::advance(peer.held.objects[o], peer.advance), own_.objects[o]);
    for (int f = 0; f < finger_counts_[j]; ++f)
      for (int o = 0; o < world_.object_count(); ++o) contacts_[j][f][o] = Contact{};
  }
  return faults;
}

template <typename World>
auto ReplicaLaw<World>::own_hand(int o, const typename World::Placed& object,
                                 Output& output) noexcept -> Wrench {
  Wrench wrench{};
  for (int f = 0; f < finger_counts_[user_]; ++f) {
    const Grasp& grasp = grasps_[user_][f][o];
    if (!grasp.present) continue;
    Contact& contact = contacts_[user_][f][o];
    const auto touch = world_.touch(o, contact, grasp, own_.fingers[f], object);
    output.forces[f] += touch.on_finger;
    wrench += touch.on_body;
    own_.contact_bits |= core::contact_word(World::contact_bits(contact), o, f);
  }
  return wrench;
}

/// Forces at the start of the tick become those of its mean (Integrator::kExactCoupler).
template <typename World>
void ReplicaLaw<World>::give_way(int o, const Body& change, Output& output) noexcept {
  for (int f = 0; f < finger_counts_[user_]; ++f) {
    if (!grasps_[user_][f][o].present) continue;
    if constexpr (World::kSpace == core::Space::kAxis) {
      const Wrench less = World::given_way(grasps_[user_][f][o], change);
      output.forces[f] += less;
      own_wrench_[o] -= less;
    }
  }
}

template <typename World>
auto ReplicaLaw<World>::remote_hand(int user, int o, const typename World::Placed& object) noexcept
    -> Wrench {
  const Peer& peer = peers_[user];
  Wrench wrench{};
  for (int f = 0; f < finger_counts_[user]; ++f) {
    const Grasp& grasp = grasps_[user][f][o];
    if (!grasp.present) continue;
    const core::FingerSample<Vector>& held = peer.held.fingers[f];
    const core::FingerSample<Vector> finger{held.p + held.v * peer.advance.time,
                                            held.v * peer.advance.keep};
    wrench += world_.touch(o, contacts_[user][f][o], grasp, finger, object).on_body;
  }
  return wrench;
}

template <typename World>
auto ReplicaLaw<World>::coordinate(const Peer& peer, int o) noexcept -> Wrench {
  if (!coordination_[o].present) return {};
  Body other = World::advance(peer.held.objects[o], peer.advance);
  if (const double part = peer.presence.seat_part(); part > 0.0)
    other = World::moved_back(other, peer.seat[o], part);
  return World::coordinate(coordination_[o], own_.objects[o], other);
}

/// Energy over the network port by exact increments (force held while the copy moved), in two
/// counters that only grow, so that lost packets lose nothing.
template <typename World>
void ReplicaLaw<World>::account(const Wrench& network, const Body& before,
                                const Body& after) noexcept {
  const double work = World::work(network, before, after);
  (work > 0.0 ? own_.energy_out : own_.energy_in) += work > 0.0 ? work : -work;
}

template class ReplicaLaw<core::AxisWorld>;
template class ReplicaLaw<core::PlaneWorld>;
template class ReplicaLaw<core::SpaceWorld>;

}  // namespace tandem::distributed
