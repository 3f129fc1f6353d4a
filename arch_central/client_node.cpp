#include "arch_central/client_node.h"

#include <stdexcept>

#include "arch_central/client_law.h"
#include "core/with_world.h"
#include "node/hand_port.h"
#include "node/open_hands.h"
#include "node/peer_port.h"
#include "node/run_site.h"
#include "node/site_values.h"
#include "scene/load_scene.h"

namespace tandem::central {
namespace {

/// A client's tick: device, law, link. Nothing is computed here. What it records of objects is what
/// the server last said of them.
template <typename World>
class ClientSite {
 public:
  using Law = ClientLaw<World>;

  ClientSite(const core::Scene& scene, int user, node::OpenedDevices devices, net::PeerLink& link)
      : law_(scene, user),
        hand_(scene, user, std::move(devices)),
        server_(link, core::kServerSender),
        user_(user) {}

  void tick(const node::Slot& slot, core::TickRecord& record, node::TickLog& log) noexcept {
    core::Fault faults = core::Fault::kNone;
    const core::SiteState<World>& own = law_.observe(hand_.read(slot.number, faults));
    if (slot.sends) {
      core::pack(own, {law_.counts().fingers, 0}, packet_);
      packet_.slot = slot.number;
      server_.send(packet_);
    }
    const core::ServerReply<World>* fresh = nullptr;
    if (server_.receive(slot.number, law_.server_gain() <= 0.0, log)) {
      core::unpack(server_.packet(), law_.counts(), reply_);
      fresh = &reply_;
      record.fresh = 1u << user_;
    }
    record.ages[user_] = server_.age(slot.woke_ns);

    const core::FingerOutput<typename World::Vector> output = law_.tick(slot.number, fresh);
    faults |= output.faults;
    hand_.write(output, faults);

    hand_.note(output, record);
    record.contact_bits[0] = law_.held().contact_bits;
    for (int o = 0; o < law_.counts().objects; ++o)
      node::write_body<World>(law_.held().objects[o], record.objects[o]);
    record.faults = static_cast<std::uint32_t>(faults);
  }

  void report(node::LoopStatus& status) const noexcept {
    status.gains[core::kServerSender % core::kMaxUsers] = law_.server_gain();
  }
  void stop() noexcept { hand_.stop(); }
  void append_devices(std::vector<devices::HapticDevice*>& all) const { hand_.append_devices(all); }

 private:
  Law law_;
  node::HandPort<typename World::Vector> hand_;
  node::PeerPort server_;
  int user_;
  core::ServerReply<World> reply_{};
  core::StatePacket packet_;
};

template <typename World>
node::NodeReport run(node::SessionSetup& setup, int user, net::PeerLink& link) {
  const int objects = static_cast<int>(setup.scene.objects.size());
  const int fingers = static_cast<int>(setup.scene.users[user].fingers.size());
  setup.exchange.values_from[core::kMaxUsers] = node::reply_value_count<World>({fingers, objects});
  setup.columns = node::record_columns<World>(setup.scene, fingers);
  auto devices = node::open_hands(setup.scene, user, setup.options.hands);
  auto site = std::make_unique<ClientSite<World>>(setup.scene, user, std::move(devices), link);
  return node::run_site(*site, setup, link);
}

}  // namespace

node::NodeReport run_client(const ClientOptions& options) {
  net::PeerLinkOptions link_options;
  link_options.bind = options.node.bind;
  link_options.join = {options.server};
  link_options.user_name = options.user;
  link_options.scene_hash = options.scene ? scene::shared_hash(*options.scene) : 0;
  link_options.program_version = options.node.program_version;
  link_options.realtime = node::link_realtime(options.node.realtime);
  net::PeerLink link(link_options);
  link.start();
  const net::JoinResult joined = link.wait_until_joined(options.wait);
  if (!joined.joined) throw std::runtime_error(joined.error);

  node::SessionSetup setup;
  setup.role = "client";
  setup.scene = options.scene
                    ? *options.scene
                    : scene::load_scene_text(joined.scene_text, "scene sent by " + options.server);
  if (setup.scene.architecture != core::Architecture::kCentral ||
      joined.user_index >= setup.scene.users.size())
    throw std::runtime_error("the session at " + options.server +
                             " is not a central one; start `tandem replica --join` instead");
  if (scene::shared_hash(setup.scene) != joined.scene_hash)
    throw std::runtime_error("the scene sent by " + options.server +
                             " is not the one it announced; it may be of another program version");
  const int user = static_cast<int>(joined.user_index);
  setup.user = setup.scene.users[user].name;
  setup.options = options.node;
  setup.exchange.own_sender = joined.user_index;
  setup.exchange.packet_hz = setup.scene.rates.packet_hz;
  setup.exchange.local_hz = setup.scene.rates.local_hz;
  setup.peers = {core::kServerSender};

  return core::with_world(setup.scene,
                          [&]<typename World>(World) { return run<World>(setup, user, link); });
}

}  // namespace tandem::central
