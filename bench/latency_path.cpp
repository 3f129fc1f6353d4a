#include "bench/latency_path.h"

#include <atomic>
#include <cmath>
#include <ctime>
#include <memory>
#include <stdexcept>
#include <sys/mman.h>
#include <thread>
#include <unordered_map>

#include "arch_distributed/replica_law.h"
#include "core/plane_world.h"
#include "net/endpoint.h"
#include "net/peer_link.h"
#include "node/force_loop.h"
#include "node/hand_port.h"
#include "node/open_hands.h"
#include "node/session_setup.h"
#include "scene/scene_text.h"
#include "scene/shared_hash.h"

namespace tandem::bench {
namespace {

using World = core::PlaneWorld;
constexpr double kSettle = 0.3;  // before stamps count [s]

/// What a replica's tick does (arch_distributed/replica_node.cpp), with a look at the clock at each
/// handing over.
class StampedReplica {
 public:
  struct Sent {
    std::int64_t slot = 0, sampled = 0, published = 0;
  };
  struct Used {
    std::int64_t slot = 0, sent = 0, arrived = 0, used = 0, felt = 0;
  };

  StampedReplica(core::Scene& scene, int user, net::PeerLink& link, double seconds)
      : law_(scene, user),
        hand_(scene, user, node::open_hands(scene, user, {})),
        outbox_(link.outbox(static_cast<std::uint32_t>(1 - user))),
        inbox_(link.inbox(static_cast<std::uint32_t>(1 - user))),
        user_(user) {
    const auto ticks = static_cast<std::size_t>(seconds * scene.rates.local_hz) + 1024;
    wakes.reserve(ticks);
    sent.reserve(ticks);
    used.reserve(ticks);
  }

  void tick(const node::Slot& slot, core::TickRecord&, node::TickLog&) noexcept {
    core::Fault faults = core::Fault::kNone;
    const core::SiteState<World>& own = law_.observe(hand_.read(slot.number, faults));
    if (wakes.size() < wakes.capacity()) wakes.push_back(slot.woke_ns);
    if (slot.sends) {
      core::pack(own, law_.counts(user_), packet_);
      packet_.slot = slot.number;
      outbox_.publish(packet_);
      if (sent.size() < sent.capacity())
        sent.push_back({slot.number, slot.woke_ns, core::monotonic_ns()});
    }
    distributed::ReplicaLaw<World>::Inputs inputs;
    const int peer = 1 - user_;
    const bool fresh = inbox_.fetch(arrived_) && !arrived_.left;
    if (fresh) {
      core::unpack(arrived_.packet, law_.counts(peer), fresh_);
      inputs.fresh[peer] = &fresh_;
    }
    inputs.age[peer] = arrived_.epoch == 0 ? 0.0 : std::max(0.0, arrived_.age(slot.woke_ns));
    hand_.write(law_.tick(slot.number, inputs), faults);
    if (fresh && used.size() < used.capacity())
      used.push_back({arrived_.packet.slot, arrived_.packet.send_ns, arrived_.arrival_ns,
                      slot.woke_ns, core::monotonic_ns()});
  }
  void report(node::LoopStatus&) const noexcept {}

  std::vector<std::int64_t> wakes;
  std::vector<Sent> sent;
  std::vector<Used> used;

 private:
  distributed::ReplicaLaw<World> law_;
  node::HandPort<core::Vec2> hand_;
  core::LatestValue<core::StatePacket>& outbox_;
  core::LatestValue<net::PeerSample>& inbox_;
  int user_;
  net::PeerSample arrived_;
  core::SiteState<World> fresh_{};
  core::StatePacket packet_;
};

net::PeerLinkOptions link_options(const core::Scene& scene, int user,
                                  const core::RealtimeRequest& realtime) {
  net::PeerLinkOptions link;
  link.bind = "127.0.0.1:0";
  link.user_name = scene.users[user].name;
  link.scene_hash = scene::shared_hash(scene);
  link.realtime = node::link_realtime(realtime);
  net::HostOptions host;
  host.own_sender = static_cast<std::uint32_t>(user);
  host.scene_hash = link.scene_hash;
  host.scene_text = scene::to_text(scene);
  host.packet_hz = scene.rates.packet_hz;
  for (int j = 0; j < 2; ++j) {
    host.user_names.push_back(scene.users[j].name);
    host.seats.push_back(j == user  ? net::Seat::kTaken
                         : j < user ? net::Seat::kHosts
                                    : net::Seat::kOpen);
  }
  link.host = host;
  return link;
}

PathRun join(const StampedReplica& from, const StampedReplica& to) {
  PathRun run;
  run.wakes = from.wakes;
  std::unordered_map<std::int64_t, const StampedReplica::Sent*> sent;
  for (const auto& s : from.sent) sent[s.slot] = &s;
  const auto settled = from.wakes.front() + static_cast<std::int64_t>(1e9 * kSettle);
  run.wakes.erase(run.wakes.begin(), std::lower_bound(run.wakes.begin(), run.wakes.end(), settled));
  std::int64_t last = settled;
  for (const auto& u : to.used) {
    const auto found = sent.find(u.slot);
    if (found == sent.end() || found->second->sampled < settled) continue;
    const auto& s = *found->second;
    run.packets.push_back({s.sampled, s.published, u.sent, u.arrived, u.used, u.felt});
    last = s.sampled;
  }
  for (const auto& s : from.sent) run.published += s.sampled >= settled && s.sampled <= last;
  return run;
}

}  // namespace

PathResult run_path(const core::Scene& given, const PathOptions& options) {
  if (given.space != core::Space::kPlane || given.users.size() != 2 ||
      given.architecture != core::Architecture::kDistributed)
    throw std::invalid_argument("scene " + given.name +
                                ": the path is measured in a planar DISTRIBUTED one of two users, "
                                "like box_distributed");
  core::Scene scene = given;
  core::RealtimeRequest realtime;
  realtime.priority = options.priority;
  realtime.lock_memory = realtime.hold_cpu_dma_latency = options.priority > 0;

  std::array<std::unique_ptr<net::PeerLink>, 2> links;
  for (int u = 0; u < 2; ++u) {
    net::PeerLinkOptions link = link_options(scene, u, realtime);
    if (u == 1) link.join = {net::to_string(links[0]->local())};
    links[u] = std::make_unique<net::PeerLink>(link);
    links[u]->start();
  }
  const net::JoinResult joined = links[1]->wait_until_joined(6.0);
  if (!joined.joined) throw std::runtime_error("the two replicas did not meet: " + joined.error);

  const double all = kSettle + options.seconds;
  std::array<std::unique_ptr<StampedReplica>, 2> sites;
  for (int u = 0; u < 2; ++u) sites[u] = std::make_unique<StampedReplica>(scene, u, *links[u], all);
  const std::int64_t start = core::monotonic_ns() + 100'000'000;
  core::StatePacket sample;
  core::pack(core::SiteState<World>{}, distributed::ReplicaLaw<World>(scene, 0).counts(0), sample);
  node::StopRequest stop;
  std::array<std::thread, 2> threads;
  const std::clock_t busy = std::clock();
  for (int u = 0; u < 2; ++u) {
    net::ExchangeOptions exchange;
    exchange.own_sender = static_cast<std::uint32_t>(u);
    exchange.packet_hz = scene.rates.packet_hz;
    exchange.local_hz = scene.rates.local_hz;
    exchange.start_ns = start + (u == 0 ? 0 : std::llround(1e9 * options.phase * scene.tick()));
    exchange.values_from.fill(-1);
    exchange.values_from[1 - u] = sample.value_count;
    if (!options.watch) {
      exchange.watch_before_ns = -40'000;
      exchange.watch_after_ns = 0;
    }
    links[u]->open_exchange(exchange);
    threads[u] = std::thread([&, u, exchange] {
      const core::RealtimeGrant grant = core::request_realtime(realtime);
      node::TickLog log(nullptr);
      core::LatestValue<node::LoopStatus> status;
      std::atomic<std::int64_t> heartbeat{0};
      core::MonotonicClock clock;
      node::ForceLoop<StampedReplica> loop(*sites[u], log, status, heartbeat);
      loop.run({exchange.start_ns, scene.rates.local_hz, scene.packet_slots(),
                std::llround(all * scene.rates.local_hz), grant.default_spin_ns()},
               stop, clock);
    });
  }
  for (std::thread& thread : threads) thread.join();
  if (options.priority > 0) munlockall();
  PathResult result;
  result.processor =
      0.5 * static_cast<double>(std::clock() - busy) / static_cast<double>(CLOCKS_PER_SEC) / all;
  const net::LinkSnapshot sent = links[0]->statistics(1);
  if (sent.packets_sent > 0) result.bytes = sent.bytes_sent / sent.packets_sent;
  for (auto& link : links) link->stop();
  for (int u = 0; u < 2; ++u) {
    if (sites[u]->wakes.empty()) throw std::runtime_error("a force loop did not run");
    result.runs[u] = join(*sites[u], *sites[1 - u]);
  }
  return result;
}

}  // namespace tandem::bench
