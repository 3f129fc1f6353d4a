#include <algorithm>
#include <cstdio>
#include <stdexcept>

#include "net/session.h"
#include "net/session_random.h"

namespace tandem::net {
namespace {

[[nodiscard]] std::string hex(std::uint64_t hash) {
  char text[19];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(hash));
  return text;
}

}  // namespace

HostSession::HostSession(HostOptions options)
    : options_(std::move(options)), random_(options_.seed) {
  const std::size_t users = options_.user_names.size();
  if (users == 0 || users > core::kMaxUsers || options_.seats.size() != users)
    throw std::invalid_argument("host session: " + std::to_string(users) + " users with " +
                                std::to_string(options_.seats.size()) + " seats; 1 to " +
                                std::to_string(core::kMaxUsers) + " users, one seat each");
  if (options_.scene_text.size() > kMaxSceneBytes)
    throw std::invalid_argument("the scene has " + std::to_string(options_.scene_text.size()) +
                                " bytes; at most " + std::to_string(kMaxSceneBytes) +
                                " can be sent to those who join");
}

std::string HostSession::list_of_users() const {
  std::string list;
  for (std::size_t i = 0; i < options_.user_names.size(); ++i)
    if (options_.seats[i] == Seat::kOpen)
      list += (list.empty() ? "'" : ", '") + options_.user_names[i] + "'";
  return list.empty() ? "nobody" : list;
}

std::uint64_t HostSession::next_session() noexcept { return next_random(random_); }

void HostSession::on_datagram(std::span<const std::uint8_t> datagram, const Endpoint& from,
                              std::int64_t now_ns) {
  const auto message = decode_control(datagram);
  if (!message) return;
  if (message->type == ControlType::kHello) return on_hello(*message, from, now_ns);
  if (message->version != kProtocolVersion) return;
  if (message->type != ControlType::kKeepAlive && message->type != ControlType::kLeave &&
      message->type != ControlType::kSceneRequest)
    return;

  const auto guest = std::find_if(guests_.begin(), guests_.end(), [&](const Guest& g) {
    return g.here && g.session == message->session && g.address == from;
  });
  if (guest == guests_.end()) {
    constexpr std::int64_t kBetweenAnswers_ns = 100'000'000;
    if (message->type == ControlType::kLeave || now_ns - unknown_answered_ns_ < kBetweenAnswers_ns)
      return;
    unknown_answered_ns_ = now_ns;
    ControlMessage answer;
    answer.type = ControlType::kRefuse;
    answer.session = message->session;
    answer.reason = RefuseReason::kUnknownSession;
    answer.text = "this session is over; join again";
    return send(from, answer);
  }
  guest->heard_ns = now_ns;
  if (message->type == ControlType::kSceneRequest) return send_chunk(*guest, message->offset);
  if (message->type == ControlType::kLeave) {
    const auto index = static_cast<std::size_t>(guest - guests_.begin());
    *guest = {};
    tell({.kind = SessionEventKind::kLeft,
          .sender = static_cast<std::uint32_t>(index),
          .peer = from,
          .text = "user '" + options_.user_names[index] + "' left"});
  }
}

void HostSession::on_hello(const ControlMessage& hello, const Endpoint& from, std::int64_t now_ns) {
  if (hello.version != kProtocolVersion)
    return refuse(from, hello, RefuseReason::kWrongVersion,
                  "this host speaks protocol version " + std::to_string(kProtocolVersion) +
                      " (program " + options_.program_version + "), the guest version " +
                      std::to_string(hello.version) + "; run the same program on both sides");

  // The WELCOME was lost, or this HELLO is a late copy.
  for (std::size_t i = 0; i < guests_.size(); ++i)
    if (guests_[i].here && guests_[i].address == from) {
      if (guests_[i].nonce == hello.nonce) return welcome(static_cast<int>(i));
      if (guests_[i].previous_nonce == hello.nonce) return;
    }

  const int index = choose_seat(hello, from);
  if (index < 0) return;
  if (hello.scene_hash != 0 && hello.scene_hash != options_.scene_hash)
    return refuse(from, hello, RefuseReason::kOtherScene,
                  "the host runs scene " + hex(options_.scene_hash) + ", the guest has " +
                      hex(hello.scene_hash) +
                      "; give both the same file, or join without one and it is sent");

  Guest& guest = guests_[static_cast<std::size_t>(index)];
  if (guest.here && guest.address != from && now_ns - guest.heard_ns <= options_.times.replace) {
    // Two want one seat, or a killed program is back. The old one's next packet decides.
    if (guest.contended_ns >= 0 && guest.contender == from && guest.heard_ns > guest.contended_ns)
      return refuse(from, hello, RefuseReason::kUserNameTaken,
                    "user '" + options_.user_names[static_cast<std::size_t>(index)] +
                        "' is already here, from " + to_string(guest.address));
    if (guest.contended_ns < 0 || guest.contender != from) {
      guest.contender = from;
      guest.contended_ns = now_ns;
    }
    return;
  }
  seat(index, hello, from, now_ns);
}

/// Index of the seat this HELLO asks for; -1 if refused.
int HostSession::choose_seat(const ControlMessage& hello, const Endpoint& from) {
  const auto users = static_cast<int>(options_.user_names.size());
  const auto seat_of = [&](int i) { return options_.seats[static_cast<std::size_t>(i)]; };
  if (hello.user_name.empty()) {
    for (int i = 0; i < users; ++i)  // its own old seat first
      if (guests_[static_cast<std::size_t>(i)].here &&
          guests_[static_cast<std::size_t>(i)].address == from)
        return i;
    for (int i = 0; i < users; ++i)
      if (seat_of(i) == Seat::kOpen && !guests_[static_cast<std::size_t>(i)].here) return i;
    refuse(from, hello, RefuseReason::kServerFull,
           "all seats of the session are taken (" + list_of_users() +
               " can join here); wait until somebody leaves, or use a scene with more users");
    return -1;
  }
  for (int i = 0; i < users; ++i) {
    const std::string& name = options_.user_names[static_cast<std::size_t>(i)];
    if (name != hello.user_name) continue;
    if (seat_of(i) == Seat::kOpen) return i;
    if (seat_of(i) == Seat::kTaken)
      refuse(from, hello, RefuseReason::kUserNameTaken,
             "user '" + name + "' sits at the host itself; " + list_of_users() + " can join here");
    else
      refuse(from, hello, RefuseReason::kWrongRole,
             "user '" + name + "' comes before the host's user in the scene, so it hosts: let " +
                 "the host join there instead; " + list_of_users() + " can join here");
    return -1;
  }
  refuse(from, hello, RefuseReason::kUnknownUserName,
         "the scene has no user '" + hello.user_name + "'; " + list_of_users() + " can join here");
  return -1;
}

void HostSession::seat(int index, const ControlMessage& hello, const Endpoint& from,
                       std::int64_t now_ns) {
  // One address, one seat: whoever comes back under another name leaves the old one.
  for (std::size_t i = 0; i < guests_.size(); ++i)
    if (static_cast<int>(i) != index && guests_[i].here && guests_[i].address == from) {
      guests_[i] = {};
      tell({.kind = SessionEventKind::kLeft,
            .sender = static_cast<std::uint32_t>(i),
            .peer = from,
            .text = "user '" + options_.user_names[i] + "' came back under another name"});
    }
  const auto i = static_cast<std::size_t>(index);
  const bool again = guests_[i].here;
  Guest guest;
  guest.here = true;
  guest.address = from;
  guest.session = next_session();
  guest.nonce = hello.nonce;
  guest.previous_nonce = again && guests_[i].address == from ? guests_[i].nonce : 0;
  guest.heard_ns = now_ns;
  guest.keep_alive_ns = now_ns + options_.times.keep_alive;
  guests_[i] = guest;
  tell({.kind = SessionEventKind::kJoined,
        .sender = static_cast<std::uint32_t>(index),
        .session = guest.session,
        .peer = from,
        .text = "user '" + options_.user_names[i] + (again ? "' is back from " : "' joined from ") +
                to_string(from) + " (program " + hello.program_version + ")"});
  welcome(index);
}

void HostSession::welcome(int index) {
  const Guest& guest = guests_[static_cast<std::size_t>(index)];
  ControlMessage answer;
  answer.type = ControlType::kWelcome;
  answer.session = guest.session;
  answer.nonce = guest.nonce;
  answer.scene_hash = options_.scene_hash;
  answer.user_name = options_.user_names[static_cast<std::size_t>(index)];
  answer.program_version = options_.program_version;
  answer.packet_hz = options_.packet_hz;
  answer.user_index = static_cast<std::uint32_t>(index);
  answer.host_sender = options_.own_sender;
  send(guest.address, answer);
}

void HostSession::refuse(const Endpoint& to, const ControlMessage& request, RefuseReason reason,
                         const std::string& text) {
  ++refused_;
  ControlMessage answer;
  answer.type = ControlType::kRefuse;
  answer.nonce = request.nonce;
  answer.reason = reason;
  answer.text = text;
  send(to, answer);
  tell({.kind = SessionEventKind::kRefused,
        .peer = to,
        .text = "refused " + to_string(to) + ": " + name_of(reason) + ": " + text});
}

void HostSession::send_chunk(const Guest& guest, std::uint32_t offset) {
  const std::string& text = options_.scene_text;
  if (offset >= text.size()) return;
  ControlMessage chunk;
  chunk.type = ControlType::kSceneChunk;
  chunk.session = guest.session;
  chunk.offset = offset;
  chunk.total = static_cast<std::uint32_t>(text.size());
  chunk.chunk = text.substr(offset, kMaxChunkBytes);
  send(guest.address, chunk);
}

void HostSession::heard(std::uint32_t user_index, std::int64_t now_ns) noexcept {
  if (user_index < guests_.size()) guests_[user_index].heard_ns = now_ns;
}

void HostSession::poll(std::int64_t now_ns) {
  for (std::size_t i = 0; i < guests_.size(); ++i) {
    Guest& guest = guests_[i];
    if (!guest.here) continue;
    if (now_ns - guest.heard_ns > options_.times.forget) {
      tell({.kind = SessionEventKind::kLeft,
            .sender = static_cast<std::uint32_t>(i),
            .peer = guest.address,
            .text = "user '" + options_.user_names[i] + "' was silent for " +
                    std::to_string(options_.times.forget / 1'000'000'000) +
                    " s; the seat is free"});
      guest = {};
      continue;
    }
    // Contenders that stopped asking are forgotten, or an old packet would refuse a later one.
    if (guest.contended_ns >= 0 && now_ns - guest.contended_ns > options_.times.give_up)
      guest.contended_ns = -1;
    if (now_ns >= guest.keep_alive_ns) {
      guest.keep_alive_ns = now_ns + options_.times.keep_alive;
      ControlMessage alive;
      alive.type = ControlType::kKeepAlive;
      alive.session = guest.session;
      send(guest.address, alive);
    }
  }
}

void HostSession::leave() {
  for (Guest& guest : guests_) {
    if (!guest.here) continue;
    ControlMessage leave;
    leave.type = ControlType::kLeave;
    leave.session = guest.session;
    for (int i = 0; i < 3; ++i) send(guest.address, leave);
    guest = {};
  }
}

}  // namespace tandem::net
