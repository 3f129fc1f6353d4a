#include "harness/recorded_session.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>

#include <fmt/format.h>

#include "core/components.h"
#include "core/packet.h"
#include "harness/harness_error.h"
#include "net/state_codec.h"
#include "recording/recording_reader.h"

namespace tandem::harness {
namespace {

constexpr int kServer = core::NetworkModel::kServer;
constexpr double kLost = -1.0;

/// One recording in memory: a few seconds of it.
struct Node {
  const RealNode* real = nullptr;
  int site = 0;  ///< user, or kServer
  std::vector<core::TickRecord> ticks;
  std::vector<core::PacketRecord> packets;  ///< from peers, as used
};

[[nodiscard]] int site_of(std::uint32_t sender) {
  return sender == core::kServerSender ? kServer : static_cast<int>(sender);
}

[[nodiscard]] std::string name_of(int site, const core::Scene& scene) {
  return site == kServer ? "server" : scene.users.at(site).name;
}

[[nodiscard]] Node read_node(const RealNode& real, const core::Scene& scene) {
  recording::RecordingReader reader(real.recording);
  Node node;
  node.real = &real;
  node.site = real.user == "server" ? kServer : core::index_of(scene.users, real.user);
  node.ticks = reader.ticks(0, reader.tick_count());
  node.packets = reader.packets(0, reader.packet_count());
  // A server also logs the hands of its further local users, without a number.
  std::erase_if(node.packets, [](const core::PacketRecord& p) { return p.packet.sequence == 0; });
  if (node.ticks.empty()) throw HarnessError(real.name + " recorded nothing: " + real.recording);
  return node;
}

/// Whom a node hears.
[[nodiscard]] std::vector<int> peers_of(int site, const core::Scene& scene) {
  std::vector<int> peers;
  const bool central = scene.architecture == core::Architecture::kCentral ||
                       scene.architecture == core::Architecture::kSingle;
  if (central && site != kServer) return {kServer};
  for (std::size_t u = 0; u < scene.users.size(); ++u)
    if (static_cast<int>(u) != site &&
        !(central && (scene.users[u].local || scene.architecture == core::Architecture::kSingle)))
      peers.push_back(static_cast<int>(u));
  return peers;
}

/// The slot from which every site has heard everyone.
[[nodiscard]] std::int64_t all_joined(const std::vector<Node>& nodes, const core::Scene& scene) {
  std::int64_t slot = 0;
  for (const Node& node : nodes)
    for (const int peer : peers_of(node.site, scene)) {
      const auto first =
          std::find_if(node.packets.begin(), node.packets.end(),
                       [&](const core::PacketRecord& p) { return site_of(p.peer) == peer; });
      if (first == node.packets.end())
        throw HarnessError(fmt::format("{} never heard {}; it said:\n{}", node.real->name,
                                       name_of(peer, scene), node.real->said));
      slot = std::max(slot, first->slot);
    }
  return slot;
}

/// The slot from which a session that blows up has numbers near those that receivers refuse
/// (net::limits::kMaxMagnitude): the samples in use then grow old, whatever the network does.
[[nodiscard]] std::int64_t blows_up_at(const std::vector<Node>& nodes) {
  constexpr double kMost = 0.5 * net::limits::kMaxMagnitude;  // it may double in a packet period
  const auto refused = [&](const core::Vec3& v) { return !(core::inner(v, v) < kMost * kMost); };
  std::int64_t slot = std::numeric_limits<std::int64_t>::max();
  for (const Node& node : nodes)
    for (const core::TickRecord& tick : node.ticks) {
      bool out = false;
      for (int f = 0; f < core::kMaxFingers; ++f)
        out = out || refused(tick.hands[f].position) || refused(tick.hands[f].velocity) ||
              refused(tick.command[f]);
      for (const auto& object : tick.objects)
        for (const double value : object) out = out || !(std::abs(value) < kMost);
      if (!out) continue;
      slot = std::min(slot, tick.slot);
      break;
    }
  return slot;
}

[[nodiscard]] SiteSample sample_of(const core::TickRecord& tick, const core::Scene& scene) {
  SiteSample sample;
  sample.slot = tick.slot;
  for (int f = 0; f < core::kMaxFingers; ++f) {
    sample.hand[f] = tick.hands[f].position;
    sample.force[f] = tick.command[f];
  }
  const auto& object = tick.objects[0];
  sample.object.x = object[0];
  if (scene.space != core::Space::kAxis) sample.object.y = object[1];
  if (scene.space == core::Space::kPlane) sample.angle = object[2];
  if (scene.space == core::Space::kSpace) sample.object.z = object[2];
  return sample;
}

/// What a site's network port has given it, as the others heard it.
void add_energy(SiteTrajectory& site, int user, const std::vector<Node>& nodes) {
  std::map<std::int64_t, double> energy;  // by the sender's slot
  for (const Node& node : nodes)
    for (const core::PacketRecord& p : node.packets)
      if (site_of(p.peer) == user) energy[p.packet.slot] = p.packet.energy_out - p.packet.energy_in;
  site.has_network_energy = !energy.empty();
  double given = 0.0;
  auto next = energy.begin();
  for (SiteSample& sample : site.samples) {
    for (; next != energy.end() && next->first <= sample.slot; ++next) given = next->second;
    sample.network_energy = given;
  }
}

/// What the network port of a client has given its hand, by exact increments: a force held while
/// the hand moved. In ticks that were missed nothing is known to have moved.
void add_client_energy(SiteTrajectory& site) {
  site.has_network_energy = true;
  double given = 0.0;
  for (std::size_t k = 0; k + 1 < site.samples.size(); ++k) {
    const SiteSample &now = site.samples[k], &next = site.samples[k + 1];
    site.samples[k].network_energy = given;
    if (next.slot == now.slot + 1)
      for (int f = 0; f < site.fingers; ++f)
        given += core::inner(now.force[f], next.hand[f] - now.hand[f]);
  }
  if (!site.samples.empty()) site.samples.back().network_energy = given;
}

[[nodiscard]] SiteTrajectory trajectory_of(const Node& node, const std::vector<Node>& nodes,
                                           const core::Scene& scene, int packet_bytes) {
  SiteTrajectory site;
  int user = node.site;
  const bool server = node.site == kServer;
  if (server) {  // the first user who sits there is in its record
    const auto local =
        std::find_if(scene.users.begin(), scene.users.end(), [&](const core::UserParameters& u) {
          return u.local || scene.architecture == core::Architecture::kSingle;
        });
    user = local == scene.users.end() ? kServer : static_cast<int>(local - scene.users.begin());
  }
  site.user = name_of(user, scene);
  site.fingers = user == kServer ? 0 : static_cast<int>(scene.users[user].fingers.size());
  site.has_object = server || scene.architecture == core::Architecture::kDistributed ||
                    scene.architecture == core::Architecture::kDistributedSplit;
  site.samples.reserve(node.ticks.size());
  for (const core::TickRecord& tick : node.ticks) site.samples.push_back(sample_of(tick, scene));
  if (!server && site.has_object) add_energy(site, node.site, nodes);
  if (!server && !site.has_object) add_client_energy(site);
  site.packets_sent = node.real->report.value("packets_sent", std::int64_t{0});
  site.packets_accepted = node.real->report.value("packets_received", std::int64_t{0});
  site.bytes_sent = site.packets_sent * packet_bytes;
  return site;
}

template <typename Key>
[[nodiscard]] std::pair<Key, std::int64_t> most_frequent(
    const std::map<Key, std::int64_t>& counts) {
  std::pair<Key, std::int64_t> most{};
  for (const auto& [key, count] : counts)
    if (count > most.second) most = {key, count};
  return most;
}

/// From `first_slot` to before `end_slot`.
[[nodiscard]] MeasuredLink measure_link(const Node& receiver, int from, std::int64_t first_slot,
                                        std::int64_t end_slot, const core::Scene& scene) {
  MeasuredLink link;
  link.from = from;
  link.to = receiver.site;
  link.from_name = name_of(from, scene);
  link.to_name = name_of(receiver.site, scene);
  std::map<int, std::int64_t> delays, phases;
  // Of packet rates that are no whole part of the local rate there is no one phase.
  const std::int64_t period = std::max<std::int64_t>(1, std::llround(scene.ticks_per_packet()));
  std::uint64_t first = 0, last = 0;
  double sum = 0.0, squares = 0.0, ages = 0.0, ages_taken = 0.0;
  std::int64_t ticks = 0;
  std::optional<std::int64_t> held;  // slot of the sample in use
  const core::PacketSlots slots = scene.packet_slots();
  const auto packet_of = [&](std::int64_t slot) {
    return static_cast<std::size_t>(slots.packet_at(slot));
  };
  link.fates.assign(packet_of(receiver.ticks.back().slot) + 1, kLost);
  std::size_t first_packet = link.fates.size(), last_packet = 0;
  auto packet = receiver.packets.begin();
  for (const core::TickRecord& tick : receiver.ticks) {
    if (tick.slot >= end_slot) break;
    for (; packet != receiver.packets.end() && packet->slot <= tick.slot; ++packet) {
      if (site_of(packet->peer) != from) continue;
      held = packet->packet.slot;
      if (const std::size_t k = packet_of(*held); *held >= 0 && k < link.fates.size()) {
        link.fates[k] = static_cast<double>(packet->slot - *held);
        first_packet = std::min(first_packet, k);
        last_packet = std::max(last_packet, k);
      }
      if (packet->slot < first_slot) continue;
      const int delay = static_cast<int>(packet->slot - *held);
      ++delays[delay];
      ++phases[static_cast<int>(*held % period)];
      sum += delay;
      squares += static_cast<double>(delay) * delay;
      if (link.used++ == 0) first = packet->packet.sequence;
      last = packet->packet.sequence;
    }
    if (tick.slot < first_slot || !held) continue;
    ages += static_cast<double>(tick.slot - *held);
    if (from != kServer) ages_taken += tick.ages[static_cast<std::size_t>(from)] / scene.tick();
    ++ticks;
  }
  if (link.used == 0) return link;
  const double n = static_cast<double>(link.used);
  link.sent = static_cast<std::int64_t>(last - first + 1);
  link.mean_ticks = sum / n;
  link.sd_ticks = std::sqrt(std::max(0.0, squares / n - link.mean_ticks * link.mean_ticks));
  const auto usual = most_frequent(delays);
  link.usual_ticks = usual.first;
  link.usual_share = static_cast<double>(usual.second) / n;
  link.least_ticks = delays.begin()->first;
  link.most_ticks = delays.rbegin()->first;
  link.phase_ticks = most_frequent(phases).first;
  link.mean_age = ages / static_cast<double>(std::max<std::int64_t>(1, ticks));
  if (from != kServer)
    link.age_error_ticks =
        ages_taken / static_cast<double>(std::max<std::int64_t>(1, ticks)) - link.mean_age;
  link.steady_ticks = std::max(0.0, link.mean_age - 0.5 * (scene.ticks_per_packet() - 1.0));
  std::fill_n(link.fates.begin(), first_packet, static_cast<double>(link.usual_ticks));
  if (end_slot <= receiver.ticks.back().slot)  // what was under way then is not known either
    std::fill(link.fates.begin() + static_cast<std::ptrdiff_t>(last_packet) + 1, link.fates.end(),
              static_cast<double>(link.usual_ticks));
  return link;
}

}  // namespace

RecordedSession read_session(const RealSession& session, const core::Scene& scene,
                             int packet_bytes) {
  std::vector<Node> nodes;
  for (const RealNode& real : session.nodes) nodes.push_back(read_node(real, scene));
  RecordedSession recorded;
  Trajectory& trajectory = recorded.trajectory;
  trajectory.tick = scene.tick();
  trajectory.ticks_per_packet = static_cast<int>(std::lround(scene.ticks_per_packet()));
  trajectory.first_slot = all_joined(nodes, scene);
  const std::int64_t end_slot = blows_up_at(nodes);
  for (const Node& node : nodes) {
    const double missed = node.real->report.value("missed_ticks", 0.0);
    recorded.missed_share =
        std::max(recorded.missed_share, missed / static_cast<double>(node.ticks.back().slot + 1));
    trajectory.sites.push_back(trajectory_of(node, nodes, scene, packet_bytes));
    for (const int peer : peers_of(node.site, scene))
      recorded.links.push_back(measure_link(node, peer, trajectory.first_slot, end_slot, scene));
  }
  // By user; a server without one comes last.
  std::stable_sort(trajectory.sites.begin(), trajectory.sites.end(),
                   [&](const SiteTrajectory& a, const SiteTrajectory& b) {
                     const auto order = [&](const SiteTrajectory& s) {
                       const int user = core::index_of(scene.users, s.user);
                       return user < 0 ? core::kMaxUsers : user;
                     };
                     return order(a) < order(b);
                   });
  return recorded;
}

core::NetworkModel measured_network(const std::vector<MeasuredLink>& links) {
  core::NetworkModel network;
  for (const MeasuredLink& link : links) {
    network.link[link.from][link.to].delay_ticks = link.steady_ticks;
    network.link[link.from][link.to].age_error_ticks = link.age_error_ticks;
    network.phase_ticks[link.from] = link.phase_ticks;
  }
  return network;
}

core::NetworkModel replayed_network(const std::vector<MeasuredLink>& links) {
  core::NetworkModel network;
  for (const MeasuredLink& link : links) {
    network.link[link.from][link.to].recorded = link.fates;
    network.link[link.from][link.to].age_error_ticks = link.age_error_ticks;
    network.phase_ticks[link.from] = link.phase_ticks;
  }
  return network;
}

}  // namespace tandem::harness
