#include "view/spectator.h"

#include <algorithm>
#include <random>
#include <stdexcept>
#include <utility>

#include "core/clock.h"
#include "scene/load_scene.h"

namespace tandem::view {
namespace {

[[nodiscard]] bool is_central(const core::Scene& scene) {
  return scene.architecture == core::Architecture::kCentral ||
         scene.architecture == core::Architecture::kSingle;
}

[[nodiscard]] std::string name_of(const core::Scene& scene, std::uint32_t sender) {
  return sender < scene.users.size() ? scene.users[sender].name : "server";
}

[[nodiscard]] core::SpectatorLayout layout_of(const core::Scene& scene, std::uint32_t host) {
  core::SpectatorLayout l;
  l.hand_values = scene.space == core::Space::kAxis    ? 1
                  : scene.space == core::Space::kPlane ? 2
                                                       : 3;
  l.object_values = l.hand_values == 1 ? 2 : l.hand_values == 2 ? 6 : core::kMaxObjectValues;
  l.objects = static_cast<int>(scene.objects.size());
  l.users = static_cast<int>(scene.users.size());
  if (host < scene.users.size()) {
    l.fingers = static_cast<int>(scene.users[host].fingers.size());
  } else {
    for (const core::UserParameters& user : scene.users)
      if (user.local || scene.architecture == core::Architecture::kSingle) {
        l.fingers = static_cast<int>(user.fingers.size());
        break;
      }
  }
  return l;
}

[[nodiscard]] double seconds_of(std::int64_t ns) { return 1e-9 * static_cast<double>(ns); }

}  // namespace

SpectatorPicture::SpectatorPicture(const core::Scene& scene, std::uint32_t host_sender,
                                   double buffer_packets)
    : scene_(scene),
      layout_(layout_of(scene, host_sender)),
      host_(host_sender),
      buffer_(buffer_packets / scene.rates.packet_hz),
      assembler_(scene, name_of(scene, host_sender)),
      streams_(kSites, Stream(buffer_)) {}

std::int32_t SpectatorPicture::values_from(std::uint32_t sender) const {
  if (sender == host_) return layout_.value_count();
  if (sender >= scene_.users.size()) return -1;
  const int fingers = static_cast<int>(scene_.users[sender].fingers.size());
  const int objects = is_central(scene_) ? 0 : layout_.objects;
  return 2 * fingers * layout_.hand_values + objects * layout_.object_values;
}

void SpectatorPicture::put(int site, std::int64_t slot, double now) {
  Stream& stream = streams_[static_cast<std::size_t>(site)];
  const double time = static_cast<double>(slot) * scene_.tick();
  stream.buffer.add(time, assembler_.snapshot().sites[static_cast<std::size_t>(site)]);
  stream.clock.arrived(time, now);
}

void SpectatorPicture::take(const core::StatePacket& packet, double now) {
  if (packet.sender == host_) {
    core::TappedTick tick;
    core::unpack_spectator(packet, layout_, tick);
    assembler_.take(tick);
    const int own = assembler_.snapshot().own;
    put(own, packet.slot, now);
    for (std::size_t u = 0; u < scene_.users.size(); ++u)
      if (static_cast<int>(u) != own && assembler_.snapshot().sites[u].forces_known)
        put(static_cast<int>(u), packet.slot, now);  // the hand at the server
    return;
  }
  if (packet.sender >= scene_.users.size()) return;
  core::PacketRecord record;
  record.slot = packet.slot;
  record.peer = packet.sender;
  record.packet = packet;
  assembler_.take(record, ++used_[packet.sender]);
  put(static_cast<int>(packet.sender), packet.slot, now);
}

bool SpectatorPicture::at(double now, Snapshot& out) {
  const double since = std::clamp(now - drawn_at_, 0.0, 0.1);
  drawn_at_ = now;
  out = assembler_.snapshot();
  bool any = false;
  for (int s = 0; s < kSites; ++s) {
    Stream& stream = streams_[static_cast<std::size_t>(s)];
    Site& site = out.sites[static_cast<std::size_t>(s)];
    if (stream.buffer.empty()) continue;
    const double time = stream.clock.at(now);
    const int fingers =
        s < static_cast<int>(scene_.users.size())
            ? static_cast<int>(scene_.users[static_cast<std::size_t>(s)].fingers.size())
            : 0;
    const int objects = site.has_objects ? layout_.objects : 0;
    const double age = site.age, loss = site.loss;
    if (!stream.buffer.at(time, fingers, objects, site)) continue;
    site.age = age;
    site.loss = loss;
    if (s == out.own) out.time = std::min(time, stream.buffer.newest() + SiteBuffer::kMostAhead);
    any = true;
    const bool guesses = time > stream.buffer.newest();
    const bool gap_ended = stream.guessing && stream.buffer.newest() > stream.newest_drawn;
    for (int f = 0; f < fingers; ++f)
      site.fingers[static_cast<std::size_t>(f)].p =
          stream.fingers[static_cast<std::size_t>(f)].soften(
              site.fingers[static_cast<std::size_t>(f)].p,
              site.fingers[static_cast<std::size_t>(f)].v, gap_ended, since);
    for (int o = 0; o < objects; ++o)
      site.objects[static_cast<std::size_t>(o)].p =
          stream.objects[static_cast<std::size_t>(o)].soften(
              site.objects[static_cast<std::size_t>(o)].p,
              site.objects[static_cast<std::size_t>(o)].v, gap_ended, since);
    stream.guessing = guesses;
    stream.newest_drawn = stream.buffer.newest();
  }
  return any;
}

Spectator::Spectator(const std::string& host, const std::string& program_version, double seconds)
    : link_(host.starts_with("[") ? "[::]:0" : "0.0.0.0:0"), session_([&] {
        net::GuestOptions o;
        o.host = link_.resolve(host);
        o.host_text = host;
        o.spectator = true;
        o.program_version = program_version;
        std::random_device device;
        o.seed = std::uint64_t{device()} << 32 | device();
        return o;
      }()) {
  core::MonotonicClock clock;
  const std::int64_t give_up = clock.now_ns() + static_cast<std::int64_t>(1e9 * seconds);
  while (session_.state() != net::GuestSession::State::kJoined) {
    receive();
    session_.poll(clock.now_ns());
    flush();
    if (session_.state() == net::GuestSession::State::kRefused)
      throw std::runtime_error(messages_.empty() ? host + " refused us" : messages_.back());
    if (clock.now_ns() > give_up)
      throw std::runtime_error(
          "no answer from " + host +
          ": is a server or replica running there, is the port open, and does it know spectators? "
          "(a client cannot be looked at: give its server)");
    link_.wait(10'000'000);
  }
  scene_ = scene::load_scene_text(session_.scene_text(), "scene sent by " + host);
  picture_ = std::make_unique<SpectatorPicture>(scene_, session_.welcome().host_sender);
  thread_ = std::thread([this] { run(); });
}

Spectator::~Spectator() {
  stop_ = true;
  if (thread_.joinable()) thread_.join();
  session_.leave();
  flush();
}

void Spectator::flush() {
  while (auto datagram = session_.next_datagram()) link_.send(datagram->to, datagram->bytes);
  while (auto event = session_.next_event()) {
    const std::lock_guard lock(mutex_);
    messages_.push_back(event->text);
    if (event->kind != net::SessionEventKind::kJoined) continue;
    // A new session, also after a reconnect; before the first the scene is not known yet.
    if (picture_ == nullptr) continue;
    picture_ = std::make_unique<SpectatorPicture>(scene_, session_.welcome().host_sender);
  }
}

void Spectator::receive() {
  std::array<std::uint8_t, net::kMaxDatagram + 1> buffer;
  core::MonotonicClock clock;
  net::Endpoint from;
  for (int i = 0; i < 64; ++i) {
    const auto size = link_.receive(from, buffer);
    if (!size) return;
    if (from != session_.options().host) continue;
    const std::span<const std::uint8_t> datagram(buffer.data(), *size);
    const auto prefix = net::prefix_of(datagram);
    if (prefix && prefix->kind == net::Kind::kControl) {
      session_.on_datagram(datagram, from, clock.now_ns());
      continue;
    }
    if (picture_ == nullptr || session_.state() != net::GuestSession::State::kJoined) continue;
    const std::lock_guard lock(mutex_);
    for (std::uint32_t u = 0; u < scene_.users.size(); ++u)
      if (const std::int32_t n = picture_->values_from(u); n >= 0)
        decoder_.expect(u, session_.welcome().session, n);
    if (session_.welcome().host_sender == core::kServerSender)
      decoder_.expect(core::kServerSender, session_.welcome().session,
                      picture_->values_from(core::kServerSender));
    core::StatePacket packet;
    if (decoder_.decode(datagram, packet, net::Kind::kSnapshot) != net::Decode::kOk) continue;
    const std::int64_t now = clock.now_ns();
    session_.heard(now);
    picture_->take(packet, seconds_of(now));
    accepted_.fetch_add(1);
  }
}

void Spectator::run() {
  core::MonotonicClock clock;
  while (!stop_) {
    receive();
    session_.poll(clock.now_ns());
    flush();
    link_.wait(10'000'000);
  }
}

bool Spectator::at_now(Snapshot& out) {
  core::MonotonicClock clock;
  const std::lock_guard lock(mutex_);
  return picture_->at(seconds_of(clock.now_ns()), out);
}

std::vector<std::string> Spectator::take_messages() {
  const std::lock_guard lock(mutex_);
  return std::exchange(messages_, {});
}

}  // namespace tandem::view
