#include "bench/scale_measure.h"

#include <chrono>
#include <memory>
#include <stdexcept>
#include <vector>

#include "arch_central/central_loop.h"
#include "arch_distributed/distributed_loop.h"
#include "bench/percentile.h"
#include "core/clock.h"
#include "core/finite_guard.h"
#include "core/plane_world.h"

namespace tandem::bench {
namespace {

using World = core::PlaneWorld;
using Site = core::SiteState<World>;
using Hand = core::HandSample<core::Vec2>;
using Replica = distributed::ReplicaLaw<World>;
using Server = central::ServerLaw<World>;

constexpr int kWarmUp = 2304;  // ticks, 2.25 s: all hands have closed and squeeze
constexpr int kTicks = 256;    // a timed stretch
constexpr int kTicksPerPacket = 8;

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// What a datagram would have to carry, where a packet cannot.
int values_of(const core::SiteCounts& counts, bool reply) {
  return (reply ? 2 : 4) * counts.fingers + 6 * counts.objects;
}

template <typename Loop>
double virtual_speed(Loop& loop, double tick, int rounds) {
  std::vector<double> speeds;
  for (int r = 0; r < rounds; ++r) {
    const auto start = std::chrono::steady_clock::now();
    for (int k = 0; k < kTicksPerPacket * 4; ++k) loop.tick();
    speeds.push_back(kTicksPerPacket * 4 * tick / seconds_since(start));
  }
  return percentiles_of(speeds).p50;
}

/// Nanoseconds of `tick(k)`.
template <typename Tick>
double time_ticks(int rounds, Tick&& tick) {
  std::vector<double> ns;
  for (int r = 0; r < rounds + 1; ++r) {  // the first warms up
    const auto start = std::chrono::steady_clock::now();
    for (int k = 0; k < kTicks; ++k) tick(k);
    if (r > 0) ns.push_back(1e9 * seconds_since(start) / kTicks);
  }
  return percentiles_of(ns).p50;
}

/// A session after `kWarmUp` ticks and what its site is given from there on.
struct Around {
  std::vector<Hand> hands;
  std::vector<Site> sites;
};

template <typename Loop, typename Observe>
Around around(Loop& loop, int users, Observe&& observe) {
  for (int k = 0; k < kWarmUp; ++k) loop.tick();
  Around a;
  a.hands.resize(static_cast<std::size_t>(users));
  for (int u = 0; u < users; ++u) {
    loop.hands().sample(u, a.hands[u]);
    a.sites.push_back(observe(u, a.hands[u]));
  }
  return a;
}

void take_new(net::PeerLink& link, int user, const core::SiteCounts& counts,
              std::vector<net::PeerSample>& arrived, std::vector<Site>& fresh,
              const Site*& fresh_out, double& age) {
  if (link.inbox(static_cast<std::uint32_t>(user)).fetch(arrived[user])) {
    core::unpack(arrived[user].packet, counts, fresh[user]);
    fresh_out = &fresh[user];
  }
  age = arrived[user].epoch == 0 ? 0.0 : arrived[user].age(core::monotonic_ns());
}

TrafficHost host_of(const core::Scene& scene) {
  TrafficHost host;
  for (const core::UserParameters& user : scene.users) host.user_names.push_back(user.name);
  host.from_user.resize(scene.users.size());
  host.local_hz = scene.rates.local_hz;
  host.packet_hz = scene.rates.packet_hz;
  return host;
}

void measure_mesh(const core::Scene& scene, const ScaleWork& work, ScaleRow& row) {
  const int users = row.size.users;
  auto loop = std::make_unique<distributed::DistributedLoop<World>>(scene);
  Around a = around(*loop, users, [&](int u, const Hand& hand) {
    auto law = std::make_unique<Replica>(loop->law(u));
    return law->observe(hand);
  });
  auto law = std::make_unique<Replica>(loop->law(0));
  for (int o = 0; o < row.size.objects; ++o)
    row.finite = row.finite && core::is_finite(law->object(o).p);
  Replica::Inputs inputs;
  std::int64_t slot = loop->slot();
  row.tick_ns = time_ticks(work.rounds, [&](int k) {
    for (int j = 1; j < users; ++j) {
      inputs.fresh[j] = k % kTicksPerPacket == 0 ? &a.sites[j] : nullptr;
      inputs.age[j] = k % kTicksPerPacket * scene.tick();
    }
    (void)law->observe(a.hands[0]);
    (void)law->tick(slot++, inputs);
  });
  row.virtual_speed = virtual_speed(*loop, scene.tick(), work.rounds);

  const core::SiteCounts counts = law->counts(0);
  row.values_in = row.values_out = values_of(counts, false);
  row.fits = row.values_in <= core::kMaxPacketValues;
  if (!row.fits || !(work.seconds > 0.0)) return;
  TrafficHost host = host_of(scene);
  host.own_sender = 0;
  host.values_out = row.values_out;
  for (int j = 1; j < users; ++j) core::pack(a.sites[j], counts, host.from_user[j]);
  std::vector<net::PeerSample> arrived(static_cast<std::size_t>(users));
  std::vector<Site> fresh(static_cast<std::size_t>(users));
  core::StatePacket packet;
  host.tick = [&](std::int64_t k, bool sends, net::PeerLink& link) {
    const Site& own = law->observe(a.hands[0]);
    if (sends) {
      core::pack(own, counts, packet);
      packet.slot = k;
      for (int j = 1; j < users; ++j) link.outbox(static_cast<std::uint32_t>(j)).publish(packet);
    }
    for (int j = 1; j < users; ++j) {
      inputs.fresh[j] = nullptr;
      take_new(link, j, counts, arrived, fresh, inputs.fresh[j], inputs.age[j]);
    }
    (void)law->tick(slot + k, inputs);
  };
  row.traffic = run_traffic(host, {work.seconds, work.priority});
}

void measure_central(const core::Scene& scene, const ScaleWork& work, ScaleRow& row) {
  const int users = row.size.users;
  auto loop = std::make_unique<central::CentralLoop<World>>(scene);
  Around a = around(*loop, users, [&](int u, const Hand& hand) {
    if (loop->server().is_local(u)) return Site{};
    auto client = loop->client(u);
    return client.observe(hand);
  });
  auto law = std::make_unique<Server>(loop->server());
  for (int o = 0; o < row.size.objects; ++o)
    row.finite = row.finite && core::is_finite(law->object(o).p);
  Server::Inputs inputs;
  std::int64_t slot = loop->slot();
  double moved = 0.0;
  row.tick_ns = time_ticks(work.rounds, [&](int k) {
    const bool packets = k % kTicksPerPacket == 0;
    for (int u = 0; u < users; ++u) {
      if (law->is_local(u)) {
        law->observe(u, a.hands[u]);
        continue;
      }
      inputs.fresh[u] = packets ? &a.sites[u] : nullptr;
      inputs.age[u] = k % kTicksPerPacket * scene.tick();
    }
    law->tick(slot++, inputs);
    if (!packets) return;
    for (int u = 0; u < users; ++u)
      if (!law->is_local(u)) moved += law->reply(u).forces[0].x;
  });
  row.finite = row.finite && core::is_finite(moved);
  row.virtual_speed = virtual_speed(*loop, scene.tick(), work.rounds);

  const core::SiteCounts counts = law->counts(users - 1), hand{counts.fingers, 0};
  row.values_in = values_of(hand, false);
  row.values_out = values_of(counts, true);
  row.fits = row.values_out <= core::kMaxPacketValues;
  if (!row.fits || !(work.seconds > 0.0)) return;
  TrafficHost host = host_of(scene);
  host.own_sender = core::kServerSender;
  host.values_out = row.values_out;
  for (int u = 0; u < users; ++u)
    if (!law->is_local(u)) core::pack(a.sites[u], hand, host.from_user[u]);
  std::vector<net::PeerSample> arrived(static_cast<std::size_t>(users));
  std::vector<Site> fresh(static_cast<std::size_t>(users));
  core::StatePacket packet;
  host.tick = [&](std::int64_t k, bool sends, net::PeerLink& link) {
    for (int u = 0; u < users; ++u) {
      if (law->is_local(u)) {
        law->observe(u, a.hands[u]);
        continue;
      }
      inputs.fresh[u] = nullptr;
      take_new(link, u, hand, arrived, fresh, inputs.fresh[u], inputs.age[u]);
    }
    law->tick(slot + k, inputs);
    for (int u = 0; sends && u < users; ++u) {
      if (law->is_local(u)) continue;
      core::pack(law->reply(u), counts, packet);
      packet.slot = k;
      link.outbox(static_cast<std::uint32_t>(u)).publish(packet);
    }
  };
  row.traffic = run_traffic(host, {work.seconds, work.priority});
}

}  // namespace

ScaleRow measure_scale(const core::Scene& given, const ScaleSize& size, const ScaleWork& work) {
  if (size.users > core::kMaxUsers || size.objects > core::kMaxObjects)
    throw std::invalid_argument(std::to_string(size.users) + " users and " +
                                std::to_string(size.objects) + " objects: this build holds " +
                                std::to_string(core::kMaxUsers) + " and " +
                                std::to_string(core::kMaxObjects));
  const core::Scene scene = grown_scene(given, size);
  ScaleRow row;
  const bool central = scene.architecture == core::Architecture::kCentral;
  row.architecture = central ? "central" : "mesh";
  row.size = size;
  row.packet_hz = scene.rates.packet_hz;
  row.most_users = core::kMaxUsers;
  row.most_objects = core::kMaxObjects;
  if (central)
    measure_central(scene, work, row);
  else
    measure_mesh(scene, work, row);
  return row;
}

}  // namespace tandem::bench
