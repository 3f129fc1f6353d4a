#include "arch_distributed/replica_node.h"

#include <stdexcept>

#include "arch_distributed/replica_law.h"
#include "core/with_world.h"
#include "node/hand_port.h"
#include "node/open_hands.h"
#include "node/peer_port.h"
#include "node/run_site.h"
#include "node/site_values.h"
#include "scene/load_scene.h"
#include "scene/scene_text.h"
#include "scene/shared_hash.h"

namespace tandem::distributed {
namespace {

/// One replica's tick: device, law, links. Nothing is computed here.
template <typename World>
class ReplicaSite {
 public:
  using Law = ReplicaLaw<World>;

  ReplicaSite(const core::Scene& scene, int user, node::OpenedDevices devices, net::PeerLink& link)
      : law_(scene, user),
        hand_(scene, user, std::move(devices)),
        user_(user),
        user_count_(law_.user_count()),
        object_count_(static_cast<int>(scene.objects.size())) {
    for (int j = 0; j < user_count_; ++j)
      if (j != user_) peers_[j] = node::PeerPort(link, static_cast<std::uint32_t>(j));
  }

  void tick(const node::Slot& slot, core::TickRecord& record, node::TickLog& log) noexcept {
    core::Fault faults = core::Fault::kNone;
    const core::SiteState<World>& own = law_.observe(hand_.read(slot.number, faults));
    if (slot.sends) send(own, slot.number);

    typename Law::Inputs inputs;
    for (int j = 0; j < user_count_; ++j) {
      if (j == user_) continue;
      if (peers_[j].receive(slot.number, law_.peer_gain(j) <= 0.0, log)) {
        core::unpack(peers_[j].packet(), law_.counts(j), fresh_[j]);
        inputs.fresh[j] = &fresh_[j];
        record.fresh |= 1u << j;
      }
      inputs.age[j] = record.ages[j] = peers_[j].age(slot.woke_ns);
    }

    const core::FingerOutput<typename World::Vector> output = law_.tick(slot.number, inputs);
    faults |= output.faults;
    hand_.write(output, faults);

    hand_.note(output, record);
    record.contact_bits[0] = law_.site().contact_bits;
    for (int o = 0; o < object_count_; ++o)
      node::write_body<World>(law_.object(o), record.objects[o]);
    record.faults = static_cast<std::uint32_t>(faults);
  }

  void report(node::LoopStatus& status) const noexcept {
    for (int j = 0; j < user_count_; ++j) status.gains[j] = j == user_ ? 1.0 : law_.peer_gain(j);
  }
  void stop() noexcept { hand_.stop(); }
  void append_devices(std::vector<devices::HapticDevice*>& all) const { hand_.append_devices(all); }

 private:
  void send(const core::SiteState<World>& own, std::int64_t slot) noexcept {
    core::pack(own, law_.counts(user_), packet_);
    packet_.slot = slot;
    for (int j = 0; j < user_count_; ++j)
      if (j != user_) peers_[j].send(packet_);
  }

  Law law_;
  node::HandPort<typename World::Vector> hand_;
  int user_, user_count_, object_count_;
  std::array<node::PeerPort, core::kMaxUsers> peers_;
  std::array<core::SiteState<World>, core::kMaxUsers> fresh_{};
  core::StatePacket packet_;
};

template <typename World>
node::NodeReport run(node::SessionSetup& setup, int user, net::PeerLink& link) {
  const int objects = static_cast<int>(setup.scene.objects.size());
  for (std::size_t j = 0; j < setup.scene.users.size(); ++j) {
    if (static_cast<int>(j) == user) continue;
    const int fingers = static_cast<int>(setup.scene.users[j].fingers.size());
    setup.exchange.values_from[j] = node::site_value_count<World>({fingers, objects});
  }
  setup.columns = node::record_columns<World>(
      setup.scene, static_cast<int>(setup.scene.users[user].fingers.size()));
  auto devices = node::open_hands(setup.scene, user, setup.options.hands);
  auto site = std::make_unique<ReplicaSite<World>>(setup.scene, user, std::move(devices), link);
  return node::run_site(*site, setup, link);
}

/// Users before us in the scene host, those after us join us.
net::PeerLinkOptions link_options(const core::Scene& scene, int user,
                                  const ReplicaOptions& options) {
  net::PeerLinkOptions link;
  link.bind = options.node.bind;
  link.user_name = scene.users[user].name;
  link.scene_hash = scene::shared_hash(scene);
  link.program_version = options.node.program_version;
  link.realtime = node::link_realtime(options.node.realtime);

  net::HostOptions host;
  host.own_sender = static_cast<std::uint32_t>(user);
  host.scene_hash = link.scene_hash;
  host.scene_text = scene::to_text(scene);
  host.packet_hz = scene.rates.packet_hz;
  host.program_version = options.node.program_version;
  for (std::size_t j = 0; j < scene.users.size(); ++j) {
    const int other = static_cast<int>(j);
    host.user_names.push_back(scene.users[j].name);
    host.seats.push_back(other == user  ? net::Seat::kTaken
                         : other < user ? net::Seat::kHosts
                                        : net::Seat::kOpen);
  }
  link.host = host;

  for (const ReplicaOptions::Peer& peer : options.peers) {
    const int j = node::user_index(scene, peer.user, "--peer " + peer.user + "=" + peer.address);
    if (j == user)
      throw std::invalid_argument("--peer " + peer.user + "=" + peer.address +
                                  ": that is this replica's own user; give the others only");
    if (j < user) link.join.push_back(peer.address);
  }
  for (int j = 0; j < user; ++j) {
    const std::string& name = scene.users[j].name;
    bool given = false;
    for (const ReplicaOptions::Peer& peer : options.peers) given = given || peer.user == name;
    if (!given)
      throw std::invalid_argument("user " + name + " comes before " + scene.users[user].name +
                                  " in the scene, so this replica joins theirs: give --peer " +
                                  name + "=HOST:PORT");
  }
  return link;
}

}  // namespace

FetchedScene fetch_scene(const std::string& host, const ReplicaOptions& options) {
  net::PeerLinkOptions link_options;
  link_options.bind = options.node.bind;
  link_options.join = {host};
  link_options.user_name = options.user;
  link_options.program_version = options.node.program_version;
  net::PeerLink link(link_options);
  link.start();
  constexpr double kPatience = 6.0;  // [s] a session says after 5 s that nobody answers
  const net::JoinResult joined = link.wait_until_joined(kPatience);
  if (!joined.joined) throw std::runtime_error(joined.error);
  FetchedScene fetched{scene::load_scene_text(joined.scene_text, "scene sent by " + host), {}};
  for (std::size_t j = 0; j < fetched.scene.users.size(); ++j)
    if (link.status(static_cast<std::uint32_t>(j)).connected)
      fetched.host = {fetched.scene.users[j].name, host};
  if (fetched.host.user.empty())
    throw std::runtime_error("at " + host +
                             " there is no replica but a server; start `tandem client` instead");
  return fetched;
}

node::NodeReport run_replica(const core::Scene& scene, const ReplicaOptions& options) {
  if (scene.architecture != core::Architecture::kDistributed &&
      scene.architecture != core::Architecture::kDistributedSplit)
    throw std::invalid_argument("scene " + scene.name +
                                ": field architecture is not DISTRIBUTED or DISTRIBUTED_SPLIT, "
                                "which a replica needs; start `tandem server` instead");
  const int user = node::user_index(scene, options.user, "--user " + options.user);

  node::SessionSetup setup;
  setup.role = "replica";
  setup.user = options.user;
  setup.scene = scene;
  setup.options = options.node;
  setup.exchange.own_sender = static_cast<std::uint32_t>(user);
  setup.exchange.packet_hz = scene.rates.packet_hz;
  setup.exchange.local_hz = scene.rates.local_hz;
  for (std::size_t j = 0; j < scene.users.size(); ++j)
    if (static_cast<int>(j) != user) setup.peers.push_back(static_cast<std::uint32_t>(j));

  net::PeerLink link(link_options(scene, user, options));
  return core::with_world(scene,
                          [&]<typename World>(World) { return run<World>(setup, user, link); });
}

}  // namespace tandem::distributed
