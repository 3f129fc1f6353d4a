#include "arch_central/server_node.h"

#include <stdexcept>

#include "arch_central/server_law.h"
#include "core/with_world.h"
#include "node/hand_port.h"
#include "node/open_hands.h"
#include "node/peer_port.h"
#include "node/run_site.h"
#include "node/site_values.h"
#include "scene/scene_text.h"
#include "scene/shared_hash.h"

namespace tandem::central {
namespace {

/// The server's tick: local devices, law, links. Nothing is computed here. The record carries the
/// hand of the first local user; those of the others are logged as packets without a number.
template <typename World>
class ServerSite {
 public:
  using Law = ServerLaw<World>;
  using Vector = typename World::Vector;

  ServerSite(const core::Scene& scene, std::vector<node::OpenedDevices> devices,
             net::PeerLink& link)
      : law_(scene),
        user_count_(law_.user_count()),
        object_count_(static_cast<int>(scene.objects.size())) {
    for (int u = user_count_ - 1; u >= 0; --u) {
      if (law_.is_local(u)) {
        hands_[u] = node::HandPort<Vector>(scene, u, std::move(devices[u]));
        first_local_ = u;
      } else {
        peers_[u] = node::PeerPort(link, static_cast<std::uint32_t>(u));
      }
    }
  }

  void tick(const node::Slot& slot, core::TickRecord& record, node::TickLog& log) noexcept {
    core::Fault faults = core::Fault::kNone;
    typename Law::Inputs inputs;
    for (int u = 0; u < user_count_; ++u) {
      if (law_.is_local(u)) {
        const core::HandSample<Vector>& hand = hands_[u].read(slot.number, faults);
        law_.observe(u, hand);
        if (u != first_local_) log_hand(u, hand, slot.number, log);
        continue;
      }
      if (peers_[u].receive(slot.number, law_.user_gain(u) <= 0.0, log)) {
        core::unpack(peers_[u].packet(), {law_.counts(u).fingers, 0}, fresh_[u]);
        inputs.fresh[u] = &fresh_[u];
        record.fresh |= 1u << u;
      }
      inputs.age[u] = record.ages[u] = peers_[u].age(slot.woke_ns);
    }

    law_.tick(slot.number, inputs);
    for (int u = 0; u < user_count_; ++u) {
      faults |= law_.output(u).faults;
      if (law_.is_local(u)) {
        hands_[u].write(law_.output(u), faults);
      } else if (slot.sends) {
        send(u, slot.number);
      }
    }

    if (first_local_ >= 0) {
      hands_[first_local_].note(law_.output(first_local_), record);
      record.contact_bits[0] = law_.hand(first_local_).contact_bits;
    }
    for (int o = 0; o < object_count_; ++o)
      node::write_body<World>(law_.object(o), record.objects[o]);
    record.faults = static_cast<std::uint32_t>(faults);
  }

  void report(node::LoopStatus& status) const noexcept {
    for (int u = 0; u < user_count_; ++u)
      status.gains[u] = law_.is_local(u) ? 1.0 : law_.user_gain(u);
  }
  void stop() noexcept {
    for (auto& hand : hands_) hand.stop();
  }
  void append_devices(std::vector<devices::HapticDevice*>& all) const {
    for (const auto& hand : hands_) hand.append_devices(all);
  }

 private:
  void send(int user, std::int64_t slot) noexcept {
    core::pack(law_.reply(user), law_.counts(user), packet_);
    packet_.slot = slot;
    peers_[user].send(packet_);
  }

  void log_hand(int user, const core::HandSample<Vector>& hand, std::int64_t slot,
                node::TickLog& log) noexcept {
    core::SiteState<World> site;
    site.fingers = hand;
    site.contact_bits = law_.hand(user).contact_bits;  // of the tick before: for those who look on
    core::PacketRecord record{.slot = slot, .peer = static_cast<std::uint32_t>(user), .packet = {}};
    core::pack(site, {law_.counts(user).fingers, 0}, record.packet);
    record.packet.sender = record.peer;
    log.push_hand(record);
  }

  Law law_;
  int user_count_, object_count_, first_local_ = -1;
  std::array<node::HandPort<Vector>, core::kMaxUsers> hands_;
  std::array<node::PeerPort, core::kMaxUsers> peers_;
  std::array<core::SiteState<World>, core::kMaxUsers> fresh_{};
  core::StatePacket packet_;
};

template <typename World>
node::NodeReport run(node::SessionSetup& setup, net::PeerLink& link) {
  core::Scene& scene = setup.scene;
  std::vector<node::OpenedDevices> devices(scene.users.size());
  int recorded_fingers = 0;
  for (std::size_t u = 0; u < scene.users.size(); ++u) {
    const int fingers = static_cast<int>(scene.users[u].fingers.size());
    if (scene.users[u].local) {
      if (recorded_fingers == 0) recorded_fingers = fingers;
      devices[u] = node::open_hands(scene, static_cast<int>(u), setup.options.hands);
    } else {
      setup.exchange.values_from[u] = node::site_value_count<World>({fingers, 0});
    }
  }
  setup.columns = node::record_columns<World>(scene, recorded_fingers);
  auto site = std::make_unique<ServerSite<World>>(scene, std::move(devices), link);
  return node::run_site(*site, setup, link);
}

/// `given`: the scene as it was written, which is what others are told: in `scene` the one user of
/// a SINGLE scene is marked as local, which such a scene must not say.
net::PeerLinkOptions link_options(const core::Scene& scene, const core::Scene& given,
                                  const node::NodeOptions& options) {
  net::HostOptions host;
  host.own_sender = core::kServerSender;
  host.scene_hash = scene::shared_hash(scene);
  host.scene_text = scene::to_text(given);
  host.packet_hz = scene.rates.packet_hz;
  host.program_version = options.program_version;
  for (const core::UserParameters& user : scene.users) {
    host.user_names.push_back(user.name);
    host.seats.push_back(user.local ? net::Seat::kTaken : net::Seat::kOpen);
  }
  net::PeerLinkOptions link;
  link.bind = options.bind;
  link.host = host;
  link.program_version = options.program_version;
  link.realtime = node::link_realtime(options.realtime);
  return link;
}

}  // namespace

node::NodeReport run_server(const core::Scene& given, const node::NodeOptions& options) {
  core::Scene scene = given;
  if (scene.architecture == core::Architecture::kSingle)
    for (core::UserParameters& user : scene.users) user.local = true;
  else if (scene.architecture != core::Architecture::kCentral)
    throw std::invalid_argument("scene " + scene.name +
                                ": field architecture is not CENTRAL or SINGLE, which a server "
                                "needs; start a `tandem replica` for each user instead");

  node::SessionSetup setup;
  setup.role = "server";
  setup.user = "server";
  setup.scene = scene;
  setup.options = options;
  setup.exchange.own_sender = core::kServerSender;
  setup.exchange.packet_hz = scene.rates.packet_hz;
  setup.exchange.local_hz = scene.rates.local_hz;
  for (std::size_t u = 0; u < scene.users.size(); ++u)
    if (!scene.users[u].local) setup.peers.push_back(static_cast<std::uint32_t>(u));

  net::PeerLink link(link_options(scene, given, options));
  return core::with_world(scene, [&]<typename World>(World) { return run<World>(setup, link); });
}

}  // namespace tandem::central
