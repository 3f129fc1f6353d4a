#pragma once

#include <cstdint>
#include <vector>

#include "arch_distributed/replica_law.h"
#include "core/hands.h"
#include "core/modelled_port.h"
#include "core/network_model.h"

namespace tandem::distributed {

/// All replicas of a session closed over modelled links and simulated hands: the whole session as
/// one discrete map, in virtual time, bit for bit repeatable. Copying a loop copies the session.
template <typename LoopWorld>
class DistributedLoop {
 public:
  using World = LoopWorld;
  using Law = ReplicaLaw<World>;
  using Vector = typename World::Vector;
  using Site = core::SiteState<World>;

  explicit DistributedLoop(const core::Scene& scene, const core::NetworkModel& network = {});

  /// One tick of every site: sample, send, receive, law, hand.
  void tick() noexcept;

  void advance_packet_period() noexcept {
    for (std::int64_t k = slots_.period_from(slot_); k > 0; --k) tick();
  }
  /// Until the pattern of packet ticks begins again: a packet period where the ratio is whole.
  void advance_repeat() noexcept {
    for (std::int64_t k = 0; k < slots_.ticks; ++k) tick();
  }

  /// The states in order: hands, sites, packets in flight.
  template <typename Visitor>
  void visit_state(Visitor&& visitor) {
    hands_.visit_state(visitor);
    for (Law& law : laws_) law.visit_state(visitor);
    for (int i = 0; i < users_; ++i)
      for (int j = 0; j < users_; ++j)
        port(i, j).link().visit_in_flight(
            [&](Site& site) { core::visit_site(site, laws_[i].counts(i), visitor); });
  }

  /// Visits every directed link: from, to, receiving end.
  template <typename Visitor>
  void visit_links(Visitor&& visitor) {
    for (int i = 0; i < users_; ++i)
      for (int j = 0; j < users_; ++j)
        if (i != j) visitor(i, j, port(i, j));
  }

  [[nodiscard]] std::int64_t slot() const noexcept { return slot_; }
  [[nodiscard]] double time() const noexcept { return static_cast<double>(slot_) * T_; }
  [[nodiscard]] int user_count() const noexcept { return users_; }
  [[nodiscard]] const core::PacketSlots& packet_slots() const noexcept { return slots_; }
  [[nodiscard]] core::Hands<Vector>& hands() noexcept { return hands_; }
  [[nodiscard]] const core::Hands<Vector>& hands() const noexcept { return hands_; }
  [[nodiscard]] const Law& law(int user) const noexcept { return laws_[user]; }
  /// The copy of object `o` that this user's fingers touch.
  [[nodiscard]] const typename World::Body& object(int user, int o) const noexcept {
    return laws_[user].object(o);
  }
  [[nodiscard]] const typename World::Wrench& user_wrench(int user, int o) const noexcept {
    return laws_[user].own_wrench(o);
  }
  [[nodiscard]] const core::FingerOutput<Vector>& output(int user) const noexcept {
    return outputs_[user];
  }
  [[nodiscard]] std::int64_t packets_sent() const noexcept {
    std::int64_t sum = 0;
    for (const auto& p : ports_) sum += static_cast<std::int64_t>(p.link().sent());
    return sum;
  }
  [[nodiscard]] std::int64_t packets_accepted() const noexcept {
    std::int64_t sum = 0;
    for (const auto& p : ports_) sum += p.accepted();
    return sum;
  }

 private:
  [[nodiscard]] core::ModelledPort<Site>& port(int from, int to) noexcept {
    return ports_[from * users_ + to];
  }

  int users_ = 0;
  double T_ = 0.0;
  core::PacketSlots slots_;
  std::array<core::PacketTicks, core::kMaxUsers> packet_ticks_{};
  std::int64_t slot_ = 0;
  core::Hands<Vector> hands_;
  std::vector<Law> laws_;
  std::vector<core::ModelledPort<Site>> ports_;
  std::vector<core::FingerOutput<Vector>> outputs_;
  std::vector<typename Law::Inputs> inputs_;
  core::HandSample<Vector> sample_{};
};

}  // namespace tandem::distributed
