#include "view/paced_session.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "arch_central/central_loop.h"
#include "arch_distributed/distributed_loop.h"
#include "core/clock.h"
#include "core/modelled_port.h"
#include "core/with_world.h"
#include "view/from_world.h"

namespace tandem::view {
namespace {

[[nodiscard]] bool is_central(const core::Scene& scene) {
  return scene.architecture == core::Architecture::kCentral ||
         scene.architecture == core::Architecture::kSingle;
}

/// A pointer takes the place of the scene's script.
core::Scene without_script(core::Scene scene, int user) {
  for (core::FingerParameters& finger : scene.users.at(static_cast<std::size_t>(user)).fingers)
    finger.intent = {};
  return scene;
}

template <typename World>
void see(const distributed::DistributedLoop<World>& loop, const core::Scene& scene, int own,
         Snapshot& out) {
  const int objects = static_cast<int>(scene.objects.size());
  out.own = own;
  for (int u = 0; u < loop.user_count(); ++u) {
    Site& site = out.sites[u];
    const auto& law = loop.law(u);
    set_hand(site, law.site().fingers, law.counts(u).fingers, law.site().contact_bits);
    set_objects(site, law.site().objects, objects);
    site.forces_known = true;
    for (int f = 0; f < law.counts(u).fingers; ++f)
      site.fingers[f].force = core::to_vec3(loop.output(u).forces[f]);
    site.gain = u == own ? 1.0 : loop.law(own).peer_gain(u);
  }
}

template <typename World>
void see(const central::CentralLoop<World>& loop, const core::Scene& scene, int, Snapshot& out) {
  const int objects = static_cast<int>(scene.objects.size());
  out.own = kServerSite;
  Site& server = out.sites[kServerSite];
  server.has_objects = objects > 0;
  for (int o = 0; o < objects; ++o) server.objects[o] = body_of(loop.server().object(o));
  for (int u = 0; u < loop.user_count(); ++u) {
    Site& site = out.sites[u];
    const bool local = loop.server().is_local(u);
    const int fingers = loop.server().counts(u).fingers;
    const auto& hand = local ? loop.server().hand(u) : loop.client(u).site();
    set_hand(site, hand.fingers, fingers, loop.server().hand(u).contact_bits);
    site.forces_known = true;
    for (int f = 0; f < fingers; ++f)
      site.fingers[f].force = core::to_vec3(loop.output(u).forces[f]);
    if (local) continue;
    set_objects(site, loop.client(u).held().objects, objects);
    site.gain = loop.server().user_gain(u);
  }
}

}  // namespace

/// One loop, and the pointer's fingers in it.
template <typename Loop>
struct PacedSession::LoopRunner {
  LoopRunner(const core::Scene& given, const Options& options)
      : scene(options.pointer != nullptr ? without_script(given, options.own) : given),
        loop(scene, options.network),
        own(options.own),
        feed(options.pointer) {
    const int here = is_central(scene) ? core::NetworkModel::kServer : own;
    for (int u = 0; u < static_cast<int>(scene.users.size()); ++u) {
      const bool remote = is_central(scene) ? !scene.users[static_cast<std::size_t>(u)].local &&
                                                  scene.architecture == core::Architecture::kCentral
                                            : u != own;
      ways.push_back(
          {remote,
           core::PacketTicks(scene.packet_slots(),
                             options.network.phase_ticks[static_cast<std::size_t>(u)]),
           core::ModelledPort<int>(
               options.network.link[static_cast<std::size_t>(u)][static_cast<std::size_t>(here)])});
    }
    if (feed == nullptr) return;
    for (const core::FingerParameters& finger : scene.users[static_cast<std::size_t>(own)].fingers)
      followers.emplace_back(finger.position);
  }

  void tick() noexcept {
    for (std::size_t f = 0; f < followers.size(); ++f) {
      const core::FingerParameters& finger = scene.users[static_cast<std::size_t>(own)].fingers[f];
      core::Vec3 target{0.0};
      if (feed->fetch(static_cast<int>(f), target)) followers[f].aim(target);
      followers[f].step(scene.tick());
      const core::Vec3 pull = (followers[f].position() - finger.position) * finger.hand.stiffness +
                              followers[f].velocity() * finger.hand.damping;
      loop.hands()
          .finger(own, static_cast<int>(f))
          .set_external_force(core::from_vec3<typename Loop::Vector>(pull));
    }
    const std::int64_t slot = loop.slot();
    loop.tick();
    for (Way& way : ways) {
      if (!way.remote) continue;
      if (way.packets.due(slot)) way.port.push(0, slot);
      (void)way.port.receive(slot);
      way.age = static_cast<double>(way.port.age(slot)) * scene.tick();
    }
  }

  void fill(Snapshot& out) const {
    out.slot = loop.slot();
    out.time = loop.time();
    see(loop, scene, own, out);
    for (std::size_t u = 0; u < ways.size(); ++u) {
      if (!ways[u].remote) continue;
      const auto& link = ways[u].port.link();
      out.sites[u].age = ways[u].age;
      if (link.sent() > 0)
        out.sites[u].loss = static_cast<double>(link.lost()) / static_cast<double>(link.sent());
    }
  }

  /// The way of one user's packets to here. The loop's own is not to be looked into; a link with
  /// the same parameters and seed deals the same fates, so this one tells their age.
  struct Way {
    bool remote = false;
    core::PacketTicks packets;
    core::ModelledPort<int> port;
    double age = 0.0;
  };

  core::Scene scene;
  Loop loop;
  int own;
  devices::PointerFeed* feed;
  std::vector<devices::PointerFollower> followers;
  std::vector<Way> ways;
};

template <typename Loop>
void PacedSession::use(const core::Scene& scene) {
  auto runner = std::make_shared<LoopRunner<Loop>>(scene, options_);
  tick_ = [runner] { runner->tick(); };
  fill_ = [runner](Snapshot& out) { runner->fill(out); };
}

PacedSession::PacedSession(const core::Scene& scene, const Options& options)
    : options_(options), T_(scene.tick()), ticks_per_packet_(scene.most_ticks_per_packet()) {
  core::with_world(scene, [&]<typename World>(World) {
    if (is_central(scene))
      use<central::CentralLoop<World>>(scene);
    else
      use<distributed::DistributedLoop<World>>(scene);
  });
  Snapshot first;
  fill_(first);
  newest_.publish(first);
  if (options_.speed > 0.0) thread_ = std::thread([this] { run(); });
}

PacedSession::~PacedSession() {
  stop_ = true;
  if (thread_.joinable()) thread_.join();
}

void PacedSession::advance_to(double time) {
  for (; static_cast<double>(slot_) * T_ < time - 1e-9; ++slot_) tick_();
  Snapshot now;
  fill_(now);
  newest_.publish(now);
  if (options_.seconds > 0.0 && time >= options_.seconds) ended_ = true;
}

/// A packet period at a time. Where this computer cannot keep up the session falls behind the wall
/// clock; it does not run in bursts.
void PacedSession::run() {
  core::MonotonicClock clock;
  const auto period_ns = std::llround(1e9 * T_ * ticks_per_packet_ / options_.speed);
  std::int64_t due = clock.now_ns();
  Snapshot now;
  while (!stop_) {
    if (options_.seconds > 0.0 && static_cast<double>(slot_) * T_ >= options_.seconds) break;
    for (int k = 0; k < ticks_per_packet_; ++k, ++slot_) tick_();
    due += period_ns;
    const std::int64_t late = clock.now_ns() - due;
    now = {};
    fill_(now);
    now.lateness = 1e-9 * static_cast<double>(std::max<std::int64_t>(late, 0));
    newest_.publish(now);
    if (late > 4 * period_ns) due = clock.now_ns();
    clock.sleep_until(due);
  }
  ended_.store(true, std::memory_order_release);
}

}  // namespace tandem::view
