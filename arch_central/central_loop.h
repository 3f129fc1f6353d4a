#pragma once

#include <cstdint>
#include <vector>

#include "arch_central/client_law.h"
#include "arch_central/server_law.h"
#include "core/hands.h"
#include "core/modelled_port.h"
#include "core/network_model.h"

namespace tandem::central {

/// Server, clients, links and hands of the centralized architecture as one discrete map, in virtual
/// time. A single user is the same loop with one local user and no links (chapter 3).
template <typename LoopWorld>
class CentralLoop {
 public:
  using World = LoopWorld;
  using Server = ServerLaw<World>;
  using Client = ClientLaw<World>;
  using Vector = typename World::Vector;
  using Site = core::SiteState<World>;
  using Reply = core::ServerReply<World>;

  explicit CentralLoop(const core::Scene& scene, const core::NetworkModel& network = {});

  /// One tick: hands, clients' packets, server, its replies, clients, hands.
  void tick() noexcept;

  void advance_packet_period() noexcept {
    for (std::int64_t k = slots_.period_from(slot_); k > 0; --k) tick();
  }
  /// Until the pattern of packet ticks begins again: a packet period where the ratio is whole.
  void advance_repeat() noexcept {
    for (std::int64_t k = 0; k < slots_.ticks; ++k) tick();
  }

  /// The states in order: hands, server, held forces, packets in flight.
  template <typename Visitor>
  void visit_state(Visitor&& visitor) {
    hands_.visit_state(visitor);
    server_.visit_state(visitor);
    for (int u = 0; u < users_; ++u) {
      if (server_.is_local(u)) continue;
      const core::SiteCounts fingers{clients_[u].counts().fingers, 0};
      clients_[u].visit_state(visitor);
      up_[u].link().visit_in_flight([&](Site& s) { core::visit_site(s, fingers, visitor); });
      down_[u].link().visit_in_flight([&](Reply& r) { core::visit_reply(r, fingers, visitor); });
    }
  }

  /// Visits every directed link that packets take: from and to as in core::NetworkModel, receiving
  /// end.
  template <typename Visitor>
  void visit_links(Visitor&& visitor) {
    for (int u = 0; u < users_; ++u) {
      if (server_.is_local(u)) continue;
      visitor(u, core::NetworkModel::kServer, up_[u]);
      visitor(core::NetworkModel::kServer, u, down_[u]);
    }
  }

  [[nodiscard]] std::int64_t slot() const noexcept { return slot_; }
  [[nodiscard]] double time() const noexcept { return static_cast<double>(slot_) * T_; }
  [[nodiscard]] int user_count() const noexcept { return users_; }
  [[nodiscard]] const core::PacketSlots& packet_slots() const noexcept { return slots_; }
  [[nodiscard]] core::Hands<Vector>& hands() noexcept { return hands_; }
  [[nodiscard]] const core::Hands<Vector>& hands() const noexcept { return hands_; }
  [[nodiscard]] const Server& server() const noexcept { return server_; }
  [[nodiscard]] const Client& client(int user) const noexcept { return clients_[user]; }
  [[nodiscard]] const typename World::Body& object(int, int o) const noexcept {
    return server_.object(o);
  }
  [[nodiscard]] const typename World::Wrench& user_wrench(int user, int o) const noexcept {
    return server_.user_wrench(user, o);
  }
  [[nodiscard]] const core::FingerOutput<Vector>& output(int user) const noexcept {
    return outputs_[user];
  }
  [[nodiscard]] std::int64_t packets_sent() const noexcept {
    std::int64_t sum = 0;
    for (int u = 0; u < users_; ++u)
      sum += static_cast<std::int64_t>(up_[u].link().sent() + down_[u].link().sent());
    return sum;
  }
  [[nodiscard]] std::int64_t packets_accepted() const noexcept {
    std::int64_t sum = 0;
    for (int u = 0; u < users_; ++u) sum += up_[u].accepted() + down_[u].accepted();
    return sum;
  }

 private:
  int users_ = 0;
  double T_ = 0.0;
  core::PacketSlots slots_;
  std::array<core::PacketTicks, core::kMaxUsers + 1> packet_ticks_{};
  std::int64_t slot_ = 0;
  core::Hands<Vector> hands_;
  Server server_;
  std::vector<Client> clients_;
  std::vector<core::ModelledPort<Site>> up_;
  std::vector<core::ModelledPort<Reply>> down_;
  std::vector<core::FingerOutput<Vector>> outputs_;
  typename Server::Inputs inputs_{};
  core::HandSample<Vector> sample_{};
};

}  // namespace tandem::central
