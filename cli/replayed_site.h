#pragma once

#include <span>
#include <stdexcept>
#include <string>

#include "arch_central/client_law.h"
#include "arch_central/server_law.h"
#include "arch_distributed/replica_law.h"
#include "core/records.h"
#include "core/scene.h"
#include "node/site_values.h"

namespace tandem::cli {

/// Hands as the force loop read them, in a World's coordinates.
template <typename V>
[[nodiscard]] core::HandSample<V> hand_of(const core::TickRecord& tick) {
  core::HandSample<V> hand{};
  for (int f = 0; f < core::kMaxFingers; ++f)
    hand[f] = {core::from_vec3<V>(tick.hands[f].position),
               core::from_vec3<V>(tick.hands[f].velocity)};
  return hand;
}

template <typename World>
void write_output(const core::FingerOutput<typename World::Vector>& output, core::TickRecord& got) {
  for (int f = 0; f < core::kMaxFingers; ++f) got.command[f] = core::to_vec3(output.forces[f]);
  got.faults = static_cast<std::uint32_t>(output.faults);
}

/// The laws of the three roles, stepped from what a node recorded as its force loop stepped them.
///   core::TickRecord step(const core::TickRecord& tick, std::span<const core::PacketRecord>)
/// gives what the law answers to this tick's inputs: command, objects, contact bits, faults.
template <typename World>
class ReplayedReplica {
 public:
  ReplayedReplica(const core::Scene& scene, const std::string& user)
      : user_(core::index_of(scene.users, user)), objects_(static_cast<int>(scene.objects.size())) {
    if (user_ < 0) throw std::invalid_argument("its scene has no user \"" + user + "\"");
    law_ = distributed::ReplicaLaw<World>(scene, user_);
  }

  core::TickRecord step(const core::TickRecord& tick, std::span<const core::PacketRecord> packets) {
    law_.observe(hand_of<typename World::Vector>(tick));
    distributed::ReplicaInputs<World> inputs;
    inputs.age = tick.ages;
    for (const core::PacketRecord& p : packets) {
      if (p.peer >= core::kMaxUsers || static_cast<int>(p.peer) == user_) continue;
      core::unpack(p.packet, law_.counts(static_cast<int>(p.peer)), fresh_[p.peer]);
      inputs.fresh[p.peer] = &fresh_[p.peer];
    }
    core::TickRecord got;
    write_output<World>(law_.tick(tick.slot, inputs), got);
    got.contact_bits[0] = law_.site().contact_bits;
    for (int o = 0; o < objects_; ++o) node::write_body<World>(law_.object(o), got.objects[o]);
    return got;
  }

  [[nodiscard]] const distributed::ReplicaLaw<World>& law() const { return law_; }

 private:
  int user_, objects_;
  distributed::ReplicaLaw<World> law_;
  std::array<core::SiteState<World>, core::kMaxUsers> fresh_{};
};

template <typename World>
class ReplayedServer {
 public:
  ReplayedServer(const core::Scene& scene, const std::string&)
      : law_(scene), objects_(static_cast<int>(scene.objects.size())) {
    for (int u = law_.user_count() - 1; u >= 0; --u)
      if (law_.is_local(u)) first_local_ = u;
  }

  core::TickRecord step(const core::TickRecord& tick, std::span<const core::PacketRecord> packets) {
    using Vector = typename World::Vector;
    if (first_local_ >= 0) law_.observe(first_local_, hand_of<Vector>(tick));
    central::ServerInputs<World> inputs;
    inputs.age = tick.ages;
    for (const core::PacketRecord& p : packets) {
      const int u = static_cast<int>(p.peer);
      if (u >= law_.user_count()) continue;
      core::unpack(p.packet, {law_.counts(u).fingers, 0}, fresh_[u]);
      if (law_.is_local(u))
        law_.observe(u, fresh_[u].fingers);  // the hand of a further local user, logged every tick
      else
        inputs.fresh[u] = &fresh_[u];
    }
    law_.tick(tick.slot, inputs);
    core::TickRecord got;
    core::Fault faults = core::Fault::kNone;
    for (int u = 0; u < law_.user_count(); ++u) faults |= law_.output(u).faults;
    if (first_local_ >= 0) {
      write_output<World>(law_.output(first_local_), got);
      got.contact_bits[0] = law_.hand(first_local_).contact_bits;
    }
    got.faults = static_cast<std::uint32_t>(faults);
    for (int o = 0; o < objects_; ++o) node::write_body<World>(law_.object(o), got.objects[o]);
    return got;
  }

  [[nodiscard]] const central::ServerLaw<World>& law() const { return law_; }

 private:
  central::ServerLaw<World> law_;
  int objects_, first_local_ = -1;
  std::array<core::SiteState<World>, core::kMaxUsers> fresh_{};
};

template <typename World>
class ReplayedClient {
 public:
  ReplayedClient(const core::Scene& scene, const std::string& user) {
    const int u = core::index_of(scene.users, user);
    if (u < 0) throw std::invalid_argument("its scene has no user \"" + user + "\"");
    law_ = central::ClientLaw<World>(scene, u);
  }

  core::TickRecord step(const core::TickRecord& tick, std::span<const core::PacketRecord> packets) {
    law_.observe(hand_of<typename World::Vector>(tick));
    const core::ServerReply<World>* fresh = nullptr;
    for (const core::PacketRecord& p : packets) {
      core::unpack(p.packet, law_.counts(), reply_);
      fresh = &reply_;
    }
    core::TickRecord got;
    write_output<World>(law_.tick(tick.slot, fresh), got);
    got.contact_bits[0] = law_.held().contact_bits;
    for (int o = 0; o < law_.counts().objects; ++o)
      node::write_body<World>(law_.held().objects[o], got.objects[o]);
    return got;
  }

  [[nodiscard]] const central::ClientLaw<World>& law() const { return law_; }

 private:
  central::ClientLaw<World> law_;
  core::ServerReply<World> reply_{};
};

}  // namespace tandem::cli
