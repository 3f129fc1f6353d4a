#pragma once

#include <array>
#include <cstdint>

#include "core/contact_state.h"
#include "core/finger_output.h"
#include "core/presence.h"
#include "core/reconstruction.h"
#include "core/site_state.h"

namespace tandem::central {

/// What the server is given in one tick beside the hands of its own machine.
template <typename World>
struct ServerInputs {
  /// Packet of each remote user accepted since the last tick, nullptr if none.
  std::array<const core::SiteState<World>*, core::kMaxUsers> fresh{};
  /// Age of each remote user's newest accepted sample at this slot [s].
  std::array<double, core::kMaxUsers> age{};
};

/// The server of the centralized architecture (thesis 4.1.1, Fig 4.3, eq 4.25-4.26 without the
/// mirrored axis): it simulates every object at the local rate. A local user's hand is sampled
/// every tick; a remote hand is reconstructed from packets, its coupler is evaluated every tick
/// here, acts on the object at once, and its newest force goes back in the reply. A single user
/// without network is a server with one local user (chapter 3).
/// Braking pulses go to local users only: held for a packet period they would return more momentum
/// than arrived.
/// A tick: `observe` each local hand, then `tick`; then send `reply` if the slot is a packet slot.
template <typename World>
class ServerLaw {
 public:
  using Vector = typename World::Vector;
  using Body = typename World::Body;
  using Site = core::SiteState<World>;
  using Reply = core::ServerReply<World>;
  using Inputs = ServerInputs<World>;
  using Output = core::FingerOutput<Vector>;

  ServerLaw() noexcept = default;
  explicit ServerLaw(const core::Scene& scene) noexcept;

  void observe(int user, const core::HandSample<Vector>& hand) noexcept {
    users_[user].stages.observe(hand, users_[user].fingers, users_[user].hand.fingers);
  }

  void tick(std::int64_t slot, const Inputs& inputs) noexcept;

  /// Force on a local user's fingers, guarded; valid after `tick`.
  [[nodiscard]] const Output& output(int user) const noexcept { return users_[user].output; }
  /// What goes back to a remote user, valid after `tick`.
  [[nodiscard]] Reply reply(int user) const noexcept;
  /// Observed or held hand of a user.
  [[nodiscard]] const Site& hand(int user) const noexcept { return users_[user].hand; }

  [[nodiscard]] const Body& object(int o) const noexcept { return objects_[o]; }
  [[nodiscard]] bool is_local(int user) const noexcept { return users_[user].local; }
  [[nodiscard]] int user_count() const noexcept { return user_count_; }
  [[nodiscard]] double user_gain(int user) const noexcept { return users_[user].presence.gain(); }
  [[nodiscard]] core::SiteCounts counts(int user) const noexcept {
    return {users_[user].fingers, world_.object_count()};
  }
  /// Force on object `o` by one user's fingers in the last tick.
  [[nodiscard]] const typename World::Wrench& user_wrench(int user, int o) const noexcept {
    return users_[user].wrench[o];
  }

  /// The states in order: objects, held samples of the remote users, delayed forces, velocity
  /// estimates, and what led fingers did before (Integrator::kExactCoupler). Other contacts,
  /// presence and the guard are not among them: a linear law has none.
  template <typename Visitor>
  void visit_state(Visitor&& visitor) {
    for (int o = 0; o < world_.object_count(); ++o) World::visit_body(objects_[o], visitor);
    for (int u = 0; u < user_count_; ++u)
      if (!users_[u].local) core::visit_site(users_[u].hand, {users_[u].fingers, 0}, visitor);
    for (int u = 0; u < user_count_; ++u)
      users_[u].latency.visit_state({users_[u].fingers, u == 0 ? world_.object_count() : 0},
                                    visitor);
    for (int u = 0; u < user_count_; ++u) users_[u].stages.visit_state(users_[u].fingers, visitor);
    if constexpr (World::kSpace == core::Space::kAxis)
      for (User& user : users_)
        for (int f = 0; f < user.fingers; ++f)
          for (int o = 0; o < world_.object_count(); ++o)
            if (user.grasps[f][o].exact) visitor.velocity(user.contacts[f][o].before);
  }

 private:
  using Wrench = typename World::Wrench;
  using Objects = std::array<Wrench, core::kMaxObjects>;

  struct User {
    bool local = false;
    int fingers = 0;
    std::array<double, core::kMaxFingers> radius{};  ///< [m]
    core::FingerStages<Vector> stages;
    core::Presence presence;
    core::Latency<Vector, Wrench> latency;  ///< of the objects in the first user's
    Site hand{};
    core::Advance advance{};
    Output output{};
    Objects wrench{};
    std::array<std::array<typename World::Grasp, core::kMaxObjects>, core::kMaxFingers> grasps{};
    std::array<std::array<typename World::Contact, core::kMaxObjects>, core::kMaxFingers>
        contacts{};
    std::array<typename World::FingerWalls, core::kMaxFingers> walls{};

    /// The finger as it is reconstructed now.
    [[nodiscard]] core::FingerSample<Vector> finger(int f) const noexcept {
      return {hand.fingers[f].p + hand.fingers[f].v * advance.time,
              hand.fingers[f].v * advance.keep};
    }
  };

  void accept(std::int64_t slot, const Inputs& inputs) noexcept;
  [[nodiscard]] Wrench touch(User& user, int o, const typename World::Placed& object) noexcept;
  void give_way(int o, const Body& change) noexcept;
  void finish(User& user) noexcept;

  World world_{};
  core::ReconstructionParameters reconstruction_{};
  int user_count_ = 0;
  std::array<User, core::kMaxUsers> users_{};
  std::array<Body, core::kMaxObjects> objects_{};
  std::array<typename World::ObjectWalls, core::kMaxObjects> object_walls_{};
};

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

}  // namespace tandem::central
