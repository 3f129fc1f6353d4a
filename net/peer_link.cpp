#include "net/peer_link.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <random>
#include <stdexcept>

#include "core/clock.h"
#include "core/sequence_gate.h"
#include "net/clock_filter.h"
#include "net/udp_socket.h"

namespace tandem::net {
namespace {

[[nodiscard]] std::uint64_t random_seed() {
  std::random_device device;
  return std::uint64_t{device()} << 32 | device();
}

}  // namespace

struct PeerLink::Peer {
  core::LatestValue<core::StatePacket> outbox;
  core::LatestValue<PeerSample> inbox;

  bool connected = false;
  Endpoint address;
  std::uint64_t session = 0;
  std::uint32_t epoch = 0;
  core::SequenceGate gate;
  ClockFilter clock;
  LinkStatistics statistics;
  PeerSample newest;  ///< what was last put into the inbox
  std::int64_t heard_ns = 0;
  std::int64_t echo_ns = 0;  ///< send stamp of the newest accepted packet of this session
  std::int64_t echo_arrival_ns = 0;
  std::uint64_t sequence = 0;   ///< last one sent
  std::int64_t sent_slot = -1;  ///< packet slot of the last packet sent
  std::uint64_t impossible_stamps = 0;
};

PeerLink::PeerLink(PeerLinkOptions options)
    : PeerLink(options, std::make_unique<UdpLink>(options.bind)) {}

PeerLink::PeerLink(PeerLinkOptions options, std::unique_ptr<Link> link)
    : options_(std::move(options)), link_(std::move(link)) {
  for (auto& peer : peers_) peer = std::make_unique<Peer>();
  if (options_.host) {
    options_.host->times = options_.times;
    options_.host->seed = random_seed();
    host_ = std::make_unique<HostSession>(*options_.host);
    desk_ = std::make_unique<SpectatorDesk>(*options_.host);
    tap_ = std::make_unique<core::ViewTap>();
  }
  for (const std::string& host_text : options_.join) {
    GuestOptions guest;
    guest.host = link_->resolve(host_text);
    for (const auto& other : guests_)
      if (other->options().host == guest.host)
        throw std::invalid_argument("host " + host_text + " is given twice (also as " +
                                    other->options().host_text + "); give each host once");
    guest.host_text = host_text;
    guest.user_name = options_.user_name;
    guest.scene_hash = options_.scene_hash;
    guest.program_version = options_.program_version;
    guest.seed = random_seed();
    guest.times = options_.times;
    guests_.push_back(std::make_unique<GuestSession>(guest));
  }
}

PeerLink::~PeerLink() { stop(); }

PeerLink::Peer& PeerLink::peer_of(std::uint32_t sender) const {
  const int index = peer_index(sender);
  if (index < 0)
    throw std::out_of_range("no peer can have sender index " + std::to_string(sender) + "; 0 to " +
                            std::to_string(core::kMaxUsers - 1) + ", or 255 for the server");
  return *peers_[static_cast<std::size_t>(index)];
}

core::LatestValue<core::StatePacket>& PeerLink::outbox(std::uint32_t sender) {
  return peer_of(sender).outbox;
}
core::LatestValue<PeerSample>& PeerLink::inbox(std::uint32_t sender) {
  return peer_of(sender).inbox;
}

void PeerLink::start() {
  if (thread_.joinable()) return;
  stop_ = false;
  thread_ = std::thread([this] { run(); });
}

void PeerLink::stop() {
  if (!thread_.joinable()) return;
  stop_ = true;
  thread_.join();
}

JoinResult PeerLink::wait_until_joined(double seconds) {
  std::unique_lock lock(mutex_);
  JoinResult result;
  const auto settled = [&] {
    result.joined = true;
    for (const auto& guest : guests_) {
      if (guest->state() == GuestSession::State::kRefused) result.error = "refused";
      result.joined = result.joined && guest->state() == GuestSession::State::kJoined;
    }
    return result.joined || !result.error.empty() ||
           std::any_of(messages_.begin(), messages_.end(),
                       [](const auto& m) { return m.is_error; });
  };
  const bool in_time = joined_.wait_for(lock, std::chrono::duration<double>(seconds), settled);
  if (!result.joined) {
    if (result.error.empty()) result.error = in_time ? "not joined" : "no answer yet";
    for (const LinkMessage& message : messages_)
      if (message.is_error) result.error = message.text;
    if (!in_time && !guests_.empty() && result.error == "no answer yet")
      result.error = "no answer from " + guests_.front()->options().host_text + " yet";
    return result;
  }
  if (!guests_.empty()) {
    const ControlMessage& welcome = guests_.front()->welcome();
    result.user_index = welcome.user_index;
    result.scene_hash = welcome.scene_hash;
    result.packet_hz = welcome.packet_hz;
    result.scene_text = guests_.front()->scene_text();
  }
  return result;
}

void PeerLink::open_exchange(const ExchangeOptions& options) {
  if (!(options.packet_hz > 0.0 && options.packet_hz <= 1e5))
    throw std::invalid_argument("packet rate " + std::to_string(options.packet_hz) +
                                " Hz; above 0 and at most 100000 Hz");
  const std::lock_guard lock(mutex_);
  exchange_ = options;
  if (!(exchange_->local_hz > 0.0)) exchange_->local_hz = options.packet_hz;
  slots_ = core::PacketSlots::of(exchange_->local_hz, options.packet_hz);
  packet_slot_ = -1;
  for (std::size_t i = 0; i < peers_.size(); ++i) {
    peers_[i]->sent_slot = -1;
    if (peers_[i]->connected)
      expect_from(*peers_[i],
                  i == core::kMaxUsers ? core::kServerSender : static_cast<std::uint32_t>(i));
  }
}

void PeerLink::expect_from(const Peer& peer, std::uint32_t sender) noexcept {
  const std::int32_t count =
      exchange_ ? exchange_->values_from[static_cast<std::size_t>(peer_index(sender))] : -1;
  if (count >= 0)
    decoder_.expect(sender, peer.session, count);
  else
    decoder_.forget(sender);
}

void PeerLink::run() {
  const core::RealtimeGrant grant = core::request_realtime(options_.realtime);
  {
    const std::lock_guard lock(mutex_);
    for (const core::RealtimeSetting& setting : grant.settings())
      if (!setting.granted)
        messages_.push_back({false, "link thread: real-time: asked " + setting.name + " " +
                                        setting.asked + ": not granted: " + setting.refusal +
                                        "; to get it: " + setting.to_get_it});
  }
  constexpr std::int64_t kSessionPeriod_ns = 20'000'000;  // back-off and keep-alive resolution
  while (!stop_) {
    std::int64_t wake_ns;
    {
      const std::lock_guard lock(mutex_);
      receive_all();
      const std::int64_t now = core::monotonic_ns();
      if (host_) host_->poll(now);
      if (desk_) desk_->poll(now);
      for (auto& guest : guests_) guest->poll(now);
      flush_sessions(now);
      wake_ns = std::min(look_in_outboxes(now), now + kSessionPeriod_ns);
      if (desk_ && desk_->anybody()) {
        send_snapshots();
        // Often enough that snapshots do not bunch.
        constexpr std::int64_t kSnapshotLook_ns = 2'000'000;
        wake_ns = std::min(wake_ns, now + kSnapshotLook_ns);
      }
    }
    // On the way to look again at once: others may want this processor, the force loop above all.
    if (const std::int64_t left = wake_ns - core::monotonic_ns(); left > 0)
      link_->wait(left);
    else
      std::this_thread::yield();
  }
  const std::lock_guard lock(mutex_);
  if (host_) host_->leave();
  if (desk_) desk_->leave();
  for (auto& guest : guests_) guest->leave();
  flush_sessions(core::monotonic_ns());
}

void PeerLink::receive_all() {
  // One byte more than allowed, so that longer datagrams are seen to be too long; and not for ever,
  // or a flood would keep our own packets from leaving.
  std::array<std::uint8_t, kMaxDatagram + 1> buffer;
  constexpr int kAtMost = 64;
  Endpoint from;
  for (int i = 0; i < kAtMost; ++i) {
    const auto size = link_->receive(from, buffer);
    if (!size) return;
    const std::int64_t now = core::monotonic_ns();
    const std::span<const std::uint8_t> datagram(buffer.data(), *size);
    const auto prefix = prefix_of(datagram);
    if (prefix && prefix->kind == Kind::kControl)
      on_control(datagram, from, now);
    else
      on_state(datagram, from, now);
  }
}

void PeerLink::on_control(std::span<const std::uint8_t> datagram, const Endpoint& from,
                          std::int64_t now_ns) {
  const auto message = decode_control(datagram);
  if (!message) return strays_.add(Decode::kMalformed);
  if (desk_ && desk_->on_control(*message, from, now_ns)) return;
  const bool to_host =
      message->type == ControlType::kHello || message->type == ControlType::kSceneRequest;
  for (auto& guest : guests_)
    if (!to_host && guest->options().host == from)
      return guest->on_datagram(datagram, from, now_ns);
  if (host_) host_->on_datagram(datagram, from, now_ns);
}

void PeerLink::on_state(std::span<const std::uint8_t> datagram, const Endpoint& from,
                        std::int64_t now_ns) {
  if (!exchange_) return;  // we are still building our laws: nobody's fault
  core::StatePacket packet;
  Decode answer = decoder_.decode(datagram, packet);
  const auto found = std::find_if(peers_.begin(), peers_.end(), [&](const auto& p) {
    return p->connected && p->address == from;
  });
  if (found == peers_.end())
    return strays_.add(answer == Decode::kOk ? Decode::kUnknownSender : answer);
  Peer& peer = **found;
  if (answer == Decode::kOk && peer_index(packet.sender) != found - peers_.begin())
    answer = Decode::kUnknownSender;
  if (answer == Decode::kOk) {
    switch (peer.gate.admit(packet.sequence)) {
      case core::Gate::kAccept:
        break;
      case core::Gate::kOld:
        answer = Decode::kStaleSequence;
        break;
      case core::Gate::kDuplicate:
        answer = Decode::kDuplicate;
        break;
      case core::Gate::kLeap:
        answer = Decode::kOutOfRange;
        break;
    }
  }
  peer.statistics.received(datagram.size(), answer);
  if (answer != Decode::kOk) return;

  const ClockAnswer clock = peer.clock.update({.echo_ns = packet.echo_ns,
                                               .echo_hold_ns = packet.echo_hold_ns,
                                               .send_ns = packet.send_ns,
                                               .arrival_ns = now_ns});
  if (clock == ClockAnswer::kRestarted)
    messages_.push_back({false, "the clock of " + to_string(peer.address) +
                                    " or ours has jumped; delays are measured anew"});
  if (clock == ClockAnswer::kImpossible) ++peer.impossible_stamps;
  peer.heard_ns = now_ns;
  peer.echo_ns = packet.send_ns;
  peer.echo_arrival_ns = now_ns;
  peer.newest = {.packet = packet,
                 .arrival_ns = now_ns,
                 .age_at_arrival_ns = peer.clock.age_ns(packet.send_ns, now_ns),
                 .age_bound_ns = peer.clock.valid() ? peer.clock.bound_ns(now_ns) : 0,
                 .epoch = peer.epoch,
                 .left = false};
  peer.inbox.publish(peer.newest);
  if (desk_ && desk_->anybody()) {
    core::StatePacket copy = packet;
    send_snapshot(copy);
  }

  peer.statistics.jitter().record(packet.send_ns, now_ns);
  if (clock == ClockAnswer::kUsed || clock == ClockAnswer::kRestarted)
    peer.statistics.round_trip(peer.clock.round_trip_ns());
  if (clock == ClockAnswer::kRestarted) peer.statistics.jitter().restart();
  if (peer.clock.valid()) peer.statistics.one_way(peer.newest.age_at_arrival_ns);
  const auto guest = std::find_if(guests_.begin(), guests_.end(),
                                  [&](const auto& g) { return g->options().host == from; });
  if (guest != guests_.end())
    (*guest)->heard(now_ns);
  else if (host_)
    host_->heard(packet.sender, now_ns);
}

void PeerLink::flush_sessions(std::int64_t now_ns) {
  const auto flush = [&](SessionOutput& session, bool is_host) {
    while (auto datagram = session.next_datagram()) link_->send(datagram->to, datagram->bytes);
    while (auto event = session.next_event()) on_event(*event, is_host, now_ns);
  };
  if (host_) flush(*host_, true);
  if (desk_) flush(*desk_, true);
  for (auto& guest : guests_) flush(*guest, false);
}

void PeerLink::on_event(const SessionEvent& event, bool is_host, std::int64_t now_ns) {
  LinkMessage message{.is_error = false, .text = event.text};
  const bool spectator = event.sender == kNobody;
  if (!spectator) switch (event.kind) {
      case SessionEventKind::kJoined:
        join_peer(event, now_ns);
        break;
      case SessionEventKind::kLeft:
      case SessionEventKind::kLost:
        leave_peer(event.sender, now_ns);
        break;
      case SessionEventKind::kRefused:
      case SessionEventKind::kFailed:
        message.is_error = !is_host;
        break;
    }
  constexpr std::size_t kMostMessages = 1000;  // nobody reads them, somebody knocks all day
  if (messages_.size() < kMostMessages) messages_.push_back(std::move(message));
  joined_.notify_all();
}

void PeerLink::join_peer(const SessionEvent& event, std::int64_t now_ns) {
  Peer& peer = peer_of(event.sender);
  if (peer.connected && peer.address != event.peer && !guests_.empty() && !host_)
    messages_.push_back({.is_error = true,
                         .text = "two hosts say they are the same user: " + to_string(event.peer) +
                                 " and " + to_string(peer.address)});
  peer.connected = true;
  peer.address = event.peer;
  peer.session = event.session;
  ++peer.epoch;
  peer.gate.reset();
  peer.clock.reset();
  peer.statistics.jitter().restart();
  peer.heard_ns = now_ns;
  peer.echo_ns = peer.echo_arrival_ns = 0;
  peer.sequence = 0;
  core::StatePacket stale;
  while (peer.outbox.fetch(stale)) {
  }
  expect_from(peer, event.sender);
}

void PeerLink::leave_peer(std::uint32_t sender, std::int64_t now_ns) {
  Peer& peer = peer_of(sender);
  if (!peer.connected) return;
  peer.connected = false;
  decoder_.forget(sender);
  peer.heard_ns = now_ns;
  if (peer.newest.epoch == 0) return;  // never a packet: the force loop does not know it
  peer.newest.left = true;
  peer.inbox.publish(peer.newest);
}

/// Sends what the force loop has published. Returns when to look again.
std::int64_t PeerLink::look_in_outboxes(std::int64_t now_ns) {
  // Nobody wakes us when the exchange opens; slot 0 may be only milliseconds after that.
  constexpr std::int64_t kUntilOpen_ns = 1'000'000;
  if (!exchange_) return now_ns + kUntilOpen_ns;
  const double tick_ns = 1e9 / exchange_->local_hz;
  const double period_ns = tick_ns * slots_.ticks_per_packet();
  const auto due = [&](std::int64_t packet) {
    return exchange_->start_ns +
           std::llround(static_cast<double>(slots_.tick_of(packet)) * tick_ns);
  };
  const double since = static_cast<double>(now_ns - exchange_->start_ns);
  const auto tick = static_cast<std::int64_t>(std::floor(since / tick_ns));
  if (tick >= 0) packet_slot_ = std::max(packet_slot_, slots_.packet_at(tick));

  bool complete = true, anybody = false;
  for (auto& peer : peers_) {
    if (!peer->connected) continue;
    core::StatePacket packet;
    if (peer->outbox.fetch(packet)) {
      send_state(*peer, packet);
      peer->sent_slot = packet_slot_;
    }
    complete = complete && peer->sent_slot == packet_slot_;
    anybody = true;
  }
  const auto most_ns = static_cast<std::int64_t>(period_ns / 16);
  const std::int64_t next =
      due(packet_slot_ + 1) - std::min(exchange_->watch_before_ns, anybody ? most_ns : 0);
  if (anybody && now_ns >= next) return now_ns;
  if (packet_slot_ < 0) return next;
  // Between slots one look more: what a late force loop published for the slot before may have been
  // taken for this one's.
  if (complete) return std::min(next, now_ns + static_cast<std::int64_t>(period_ns / 2));
  const std::int64_t late_ns = now_ns - due(packet_slot_);
  if (late_ns < std::min(exchange_->watch_after_ns, most_ns)) return now_ns;
  // A force loop that is this late has stopped or missed the slot: look less often.
  constexpr std::int64_t kLate_ns = 1'500'000;
  return std::min(next, now_ns + (late_ns > kLate_ns ? 8 : 1) * exchange_->look_again_ns);
}

void PeerLink::send_state(Peer& peer, core::StatePacket& packet) {
  packet.sender = exchange_->own_sender;
  packet.sequence = ++peer.sequence;
  packet.send_ns = core::monotonic_ns();
  packet.echo_ns = peer.echo_ns;
  packet.echo_hold_ns = peer.echo_ns != 0 ? packet.send_ns - peer.echo_arrival_ns : 0;
  const auto datagram = encoder_.encode(packet, peer.session);
  peer.statistics.sent(datagram.size(), link_->send(peer.address, datagram));
}

/// To every spectator: what the force loop left, if there is something new.
void PeerLink::send_snapshots() {
  if (!exchange_ || !tap_->fetch(tapped_)) return;
  for (std::uint32_t user = 0; user < core::kMaxUsers; ++user) {
    if (!tap_->fetch(user, tapped_hand_)) continue;
    core::StatePacket hand = tapped_hand_.record.packet;
    hand.slot = tapped_hand_.record.slot;
    send_snapshot(hand);
  }
  core::StatePacket packet;
  packet.sender = exchange_->own_sender;
  core::pack_spectator(tapped_, exchange_->spectators, packet);
  send_snapshot(packet);
}

/// To every spectator: our own tick, or a peer's packet as it came.
void PeerLink::send_snapshot(core::StatePacket& packet) {
  const int site = peer_index(packet.sender);
  if (site < 0) return;
  packet.send_ns = core::monotonic_ns();
  packet.echo_ns = packet.echo_hold_ns = 0;
  for (SpectatorDesk::Spectator& s : desk_->spectators()) {
    if (!s.here || !s.proven) continue;
    packet.sequence = ++s.sequence[static_cast<std::size_t>(site)];
    link_->send(s.address, encoder_.encode(packet, s.session, Kind::kSnapshot));
  }
}

PeerStatus PeerLink::status(std::uint32_t sender) const {
  const Peer& peer = peer_of(sender);
  const std::lock_guard lock(mutex_);
  const std::int64_t now = core::monotonic_ns();
  PeerStatus s;
  s.connected = peer.connected;
  s.epoch = peer.epoch;
  if (peer.epoch == 0) return s;
  s.address = to_string(peer.address);
  s.silent_for = 1e-9 * static_cast<double>(now - peer.heard_ns);
  s.delay_known = peer.clock.valid();
  if (!s.delay_known) return s;
  s.one_way_delay = 1e-9 * static_cast<double>(peer.newest.age_at_arrival_ns);
  s.delay_bound = 1e-9 * static_cast<double>(peer.clock.bound_ns(now));
  s.round_trip = 1e-9 * static_cast<double>(peer.clock.round_trip_ns());
  return s;
}

LinkSnapshot PeerLink::statistics(std::uint32_t sender) const {
  const Peer& peer = peer_of(sender);
  const std::lock_guard lock(mutex_);
  LinkSnapshot s = peer.statistics.snapshot(peer.gate);
  s.clock_restarts = peer.clock.restarts();
  s.impossible_stamps = peer.impossible_stamps;
  if (peer.clock.valid())
    s.one_way_bound = 1e-9 * static_cast<double>(peer.clock.bound_ns(core::monotonic_ns()));
  return s;
}

DecodeCounts PeerLink::strays() const {
  const std::lock_guard lock(mutex_);
  return strays_;
}

int PeerLink::connected_peers() const {
  const std::lock_guard lock(mutex_);
  return static_cast<int>(
      std::count_if(peers_.begin(), peers_.end(), [](const auto& p) { return p->connected; }));
}

std::vector<LinkMessage> PeerLink::take_messages() {
  const std::lock_guard lock(mutex_);
  return std::exchange(messages_, {});
}

}  // namespace tandem::net
