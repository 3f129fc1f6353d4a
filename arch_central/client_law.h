#pragma once

#include <cstdint>

#include "core/finger_output.h"
#include "core/presence.h"
#include "core/site_state.h"

namespace tandem::central {

/// A remote user of the centralized architecture: sends its hand once a packet period and holds the
/// force that comes back (zero before the first reply). Everything it
/// feels has made the round trip: that is what the architecture costs.
/// A tick: `observe` the hand, send its result if the slot is a packet slot, then `tick`.
template <typename World>
class ClientLaw {
 public:
  using Vector = typename World::Vector;
  using Site = core::SiteState<World>;
  using Reply = core::ServerReply<World>;
  using Output = core::FingerOutput<Vector>;

  ClientLaw() noexcept = default;
  ClientLaw(const core::Scene& scene, int user) noexcept
      : fingers_(static_cast<int>(scene.users[user].fingers.size())),
        objects_(static_cast<int>(scene.objects.size())),
        stages_(scene, user),
        presence_(scene.silence, scene.tick()) {
    for (int f = 0; f < fingers_; ++f)
      own_.fingers[f].p = core::from_vec3<Vector>(scene.users[user].fingers[f].position);
    for (int o = 0; o < objects_; ++o) held_.objects[o] = World::initial_body(scene.objects[o]);
  }

  const Site& observe(const core::HandSample<Vector>& hand) noexcept {
    stages_.observe(hand, fingers_, own_.fingers);
    return own_;
  }

  /// `fresh`: the reply accepted since the last tick, nullptr if none.
  [[nodiscard]] Output tick(std::int64_t slot, const Reply* fresh) noexcept {
    if (fresh != nullptr) held_ = *fresh;
    presence_.update(fresh != nullptr, slot);
    Output output;
    if (presence_.stale()) output.faults |= core::Fault::kStalePeer;
    for (int f = 0; f < fingers_; ++f) output.forces[f] = held_.forces[f] * presence_.gain();
    stages_.guard(output, fingers_);
    return output;
  }

  [[nodiscard]] const Site& site() const noexcept { return own_; }
  [[nodiscard]] const Reply& held() const noexcept { return held_; }
  [[nodiscard]] double server_gain() const noexcept { return presence_.gain(); }
  [[nodiscard]] core::SiteCounts counts() const noexcept { return {fingers_, objects_}; }

  /// The states in order: held forces, velocity estimates.
  template <typename Visitor>
  void visit_state(Visitor&& visitor) {
    core::visit_reply(held_, {fingers_, 0}, visitor);
    stages_.visit_state(fingers_, visitor);
  }

 private:
  int fingers_ = 0, objects_ = 0;
  core::FingerStages<Vector> stages_{};
  core::Presence presence_{};
  Site own_{};
  Reply held_{};
};

}  // namespace tandem::central
