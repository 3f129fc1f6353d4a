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

}  // namespace tandem::central
