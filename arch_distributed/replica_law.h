#pragma once

#include <array>
#include <cstdint>

#include "core/contact_state.h"
#include "core/delay_line.h"
#include "core/finger_output.h"
#include "core/presence.h"
#include "core/reconstruction.h"
#include "core/site_state.h"

namespace tandem::distributed {

/// What a replica is given in one tick beside its own hand.
template <typename World>
struct ReplicaInputs {
  /// Packet of each user accepted since the last tick, nullptr if none; own entry unused.
  std::array<const core::SiteState<World>*, core::kMaxUsers> fresh{};
  /// Age of each user's newest accepted sample at this slot [s].
  std::array<double, core::kMaxUsers> age{};
};

/// One workstation of the distributed architecture (thesis 4.1.2, Fig 4.4, eq 4.28 without the
/// mirrored axis): its own copy of every object, its own hand, and the hands and copies of the
/// others as they come by packet. Copy i feels
///   K_ii (h_i - o_i) + sum_j K_ij (h_j - o_i) + sum_j K_oi (o_j - o_i)
/// with h_j, o_j reconstructed from packets; hand i feels -K_ii (h_i - o_i).
/// In the split kind copies carry m/N and the scene has no K_ij.
///
/// A tick: `observe` the hand, send its result if the slot is a packet slot, then `tick`. Before
/// the first packet of a peer its held sample is the scene's initial state.
/// Trivially copyable; `tick` allocates, locks and throws nothing.
template <typename World>
class ReplicaLaw {
 public:
  using Vector = typename World::Vector;
  using Body = typename World::Body;
  using Site = core::SiteState<World>;
  using Inputs = ReplicaInputs<World>;
  using Output = core::FingerOutput<Vector>;

  ReplicaLaw() noexcept = default;
  ReplicaLaw(const core::Scene& scene, int user) noexcept;

  /// Takes this slot's device sample; returns what to send if this is a packet slot.
  const Site& observe(const core::HandSample<Vector>& hand) noexcept;

  [[nodiscard]] Output tick(std::int64_t slot, const Inputs& inputs) noexcept;

  [[nodiscard]] const Site& site() const noexcept { return own_; }
  [[nodiscard]] const Body& object(int o) const noexcept { return own_.objects[o]; }
  [[nodiscard]] const Site& held(int peer) const noexcept { return peers_[peer].held; }
  [[nodiscard]] double peer_gain(int peer) const noexcept { return peers_[peer].presence.gain(); }
  [[nodiscard]] int user() const noexcept { return user_; }
  [[nodiscard]] int user_count() const noexcept { return user_count_; }
  [[nodiscard]] core::SiteCounts counts(int user) const noexcept {
    return {finger_counts_[user], world_.object_count()};
  }
  /// Force by the user's own fingers on its own copy of object `o` in the last tick.
  [[nodiscard]] const typename World::Wrench& own_wrench(int o) const noexcept {
    return own_wrench_[o];
  }

  /// The states in order: own objects, held samples of the peers, delayed forces, velocity
  /// estimates, and what led fingers did before (Integrator::kExactCoupler). Other contacts,
  /// presence and the guard are not among them: a linear law has none.
  template <typename Visitor>
  void visit_state(Visitor&& visitor) {
    for (int o = 0; o < world_.object_count(); ++o) World::visit_body(own_.objects[o], visitor);
    for (int j = 0; j < user_count_; ++j)
      if (j != user_) core::visit_site(peers_[j].held, counts(j), visitor);
    latency_.visit_state(counts(user_), visitor);
    stages_.visit_state(finger_counts_[user_], visitor);
    if constexpr (World::kSpace == core::Space::kAxis)
      for (int f = 0; f < finger_counts_[user_]; ++f)
        for (int o = 0; o < world_.object_count(); ++o)
          if (grasps_[user_][f][o].exact) visitor.velocity(contacts_[user_][f][o].before);
  }

 private:
  using Grasp = typename World::Grasp;
  using Wrench = typename World::Wrench;
  using Contact = typename World::Contact;
  using Objects = std::array<Wrench, core::kMaxObjects>;

  struct Peer {
    core::Presence presence;
    Site held{};
    core::Advance advance{};
    std::array<Body, core::kMaxObjects> seat{};  ///< stretch at the last (re)join
  };

  /// Returns Fault::kStalePeer while somebody who was there is silent.
  [[nodiscard]] core::Fault accept(std::int64_t slot, const Inputs& inputs) noexcept;
  [[nodiscard]] Wrench own_hand(int o, const typename World::Placed& object,
                                Output& output) noexcept;
  [[nodiscard]] Wrench remote_hand(int user, int o, const typename World::Placed& object) noexcept;
  [[nodiscard]] Wrench coordinate(const Peer& peer, int o) noexcept;
  void give_way(int o, const Body& change, Output& output) noexcept;
  void account(const Wrench& network, const Body& before, const Body& after) noexcept;

  World world_{};
  core::ReconstructionParameters reconstruction_{};
  int user_ = 0, user_count_ = 0;
  std::array<int, core::kMaxUsers> finger_counts_{};
  std::array<double, core::kMaxFingers> radius_{};  ///< of the own fingers [m]

  std::array<std::array<std::array<Grasp, core::kMaxObjects>, core::kMaxFingers>, core::kMaxUsers>
      grasps_{};
  std::array<typename World::Coordination, core::kMaxObjects> coordination_{};

  core::FingerStages<Vector> stages_{};
  Site own_{};
  std::array<Peer, core::kMaxUsers> peers_{};
  std::array<std::array<std::array<Contact, core::kMaxObjects>, core::kMaxFingers>, core::kMaxUsers>
      contacts_{};
  std::array<typename World::ObjectWalls, core::kMaxObjects> object_walls_{};
  std::array<typename World::FingerWalls, core::kMaxFingers> finger_walls_{};
  core::Latency<Vector, Wrench> latency_{};
  Objects own_wrench_{};
};

}  // namespace tandem::distributed
