#include "view/assemble.h"

#include <algorithm>
#include <stdexcept>

#include "core/with_world.h"
#include "view/from_world.h"

namespace tandem::view {
namespace {

/// Body from numbers in the order of the wire.
template <typename World>
Body body_from(const std::array<double, core::kMaxObjectValues>& values) {
  core::StatePacket packet;
  packet.value_count = core::kMaxObjectValues;
  std::copy(values.begin(), values.end(), packet.values.begin());
  typename World::Body body;
  World::visit_body(body, core::detail::UnpackVisitor{&packet});
  return body_of(body);
}

}  // namespace

Assembler::Assembler(const core::Scene& scene, const std::string& user) : scene_(scene) {
  const bool central = scene.architecture == core::Architecture::kCentral ||
                       scene.architecture == core::Architecture::kSingle;
  if (user == "server") {
    now_.own = kServerSite;
    for (int u = static_cast<int>(scene.users.size()) - 1; u >= 0; --u)
      if (scene.users[static_cast<std::size_t>(u)].local ||
          scene.architecture == core::Architecture::kSingle)
        hand_ = u;
  } else {
    hand_ = core::index_of(scene.users, user);
    if (hand_ < 0)
      throw std::invalid_argument("scene " + scene.name + " has no user \"" + user + "\"");
    is_client_ = central;
    now_.own = central ? kServerSite : hand_;
  }
}

void Assembler::take(const core::TickRecord& tick) {
  now_.slot = tick.slot;
  now_.time = static_cast<double>(tick.slot) * scene_.tick();
  now_.lateness = 1e-9 * static_cast<double>(tick.woke_ns - tick.due_ns);
  now_.faults = tick.faults;
  if (hand_ >= 0) {
    Site& site = now_.sites[static_cast<std::size_t>(hand_)];
    site.has_hand = site.forces_known = true;
    const std::size_t fingers = scene_.users[static_cast<std::size_t>(hand_)].fingers.size();
    for (std::size_t f = 0; f < fingers; ++f) {
      Finger& finger = site.fingers[f];
      finger.p = tick.hands[f].position;
      finger.v = tick.hands[f].velocity;
      finger.force = tick.command[f];
      const int contact = core::contact_of_finger(tick.contact_bits[0], static_cast<int>(f));
      finger.contact = core::contact_state(tick.contact_bits[0], contact);
      finger.side = core::contact_side(tick.contact_bits[0], contact);
    }
  }
  Site& own = now_.sites[static_cast<std::size_t>(now_.own)];
  own.has_objects = !scene_.objects.empty();
  core::with_world(scene_, [&]<typename World>(World) {
    for (std::size_t o = 0; o < scene_.objects.size(); ++o)
      own.objects[o] = body_from<World>(tick.objects[o]);
  });
  for (std::size_t u = 0; u < scene_.users.size(); ++u)
    if (static_cast<int>(u) != hand_) now_.sites[u].age = tick.ages[u];
}

void Assembler::take(const core::TappedTick& tapped) {
  take(tapped.tick);
  now_.lateness = 1e-9 * static_cast<double>(tapped.worst_lateness_ns);
  now_.missed = tapped.missed;
  now_.faults = tapped.faults;
}

void Assembler::take(const core::PacketRecord& record, std::int64_t count) {
  if (record.peer == core::kServerSender || record.peer >= scene_.users.size()) return;
  const auto u = static_cast<std::size_t>(record.peer);
  Site& site = now_.sites[u];
  const int fingers = static_cast<int>(scene_.users[u].fingers.size());
  const bool copies = now_.own != kServerSite;
  const core::SiteCounts counts{fingers, copies ? static_cast<int>(scene_.objects.size()) : 0};
  core::with_world(scene_, [&]<typename World>(World) {
    core::SiteState<World> state;
    core::unpack(record.packet, counts, state);
    set_hand(site, state.fingers, fingers, state.contact_bits);
    set_objects(site, state.objects, counts.objects);
  });
  if (count > 0) site.loss = loss_of(static_cast<int>(u), count, record.packet.sequence);
}

/// Packets used against packets numbered, over about the last second. Two that come within a tick
/// count as one.
double Assembler::loss_of(int site, std::int64_t used, std::uint64_t sequence) {
  auto& counts = counts_[static_cast<std::size_t>(site)];
  if (!counts.empty() && sequence < counts.back().sequence) counts.clear();  // a new session
  counts.push_back({used, sequence});
  while (sequence - counts.front().sequence > static_cast<std::uint64_t>(scene_.rates.packet_hz))
    counts.pop_front();
  const auto numbered = static_cast<double>(sequence - counts.front().sequence);
  if (numbered < 1.0) return 0.0;
  return std::clamp(1.0 - static_cast<double>(used - counts.front().used) / numbered, 0.0, 1.0);
}

void Assembler::forget() {
  for (auto& counts : counts_) counts.clear();
}

bool take_all(core::ViewTap& tap, Assembler& assembler) {
  bool any = false;
  core::TappedPacket packet;
  for (std::uint32_t peer = 0; peer < core::kMaxUsers; ++peer)
    if (tap.fetch(peer, packet)) assembler.take(packet.record, packet.count), any = true;
  core::TappedTick tick;
  if (tap.fetch(tick)) assembler.take(tick), any = true;
  return any;
}

}  // namespace tandem::view
