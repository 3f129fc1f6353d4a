#include "net/spectator_desk.h"

#include <algorithm>

#include "net/session_random.h"

namespace tandem::net {

bool SpectatorDesk::anybody() const noexcept {
  return std::any_of(spectators_.begin(), spectators_.end(),
                     [](const Spectator& s) { return s.here; });
}

bool SpectatorDesk::on_control(const ControlMessage& message, const Endpoint& from,
                               std::int64_t now_ns) {
  if (message.type == ControlType::kSpectate) {
    on_spectate(message, from, now_ns);
    return true;
  }
  if (message.version != kProtocolVersion) return false;
  const auto found = std::find_if(spectators_.begin(), spectators_.end(), [&](const Spectator& s) {
    return s.here && s.session == message.session && s.address == from;
  });
  if (found == spectators_.end()) return false;
  found->heard_ns = now_ns;
  if (message.type == ControlType::kSceneRequest && message.offset < options_.scene_text.size()) {
    found->proven = true;
    ControlMessage chunk;
    chunk.type = ControlType::kSceneChunk;
    chunk.session = found->session;
    chunk.offset = message.offset;
    chunk.total = static_cast<std::uint32_t>(options_.scene_text.size());
    chunk.chunk = options_.scene_text.substr(message.offset, kMaxChunkBytes);
    send(from, chunk);
  }
  if (message.type == ControlType::kKeepAlive) found->proven = true;
  if (message.type == ControlType::kLeave) {
    *found = {};
    tell({.kind = SessionEventKind::kLeft,
          .sender = kNobody,
          .peer = from,
          .text = "spectator " + to_string(from) + " left"});
  }
  return true;
}

void SpectatorDesk::on_spectate(const ControlMessage& message, const Endpoint& from,
                                std::int64_t now_ns) {
  if (message.version != kProtocolVersion)
    return refuse(from, message.nonce, RefuseReason::kWrongVersion,
                  "this host speaks protocol version " + std::to_string(kProtocolVersion) +
                      " (program " + options_.program_version + "), the spectator version " +
                      std::to_string(message.version) + "; run the same program on both sides");
  if (message.scene_hash != 0 && message.scene_hash != options_.scene_hash)
    return refuse(from, message.nonce, RefuseReason::kOtherScene,
                  "the host runs another scene than it did; start the viewer again");
  auto place = std::find_if(spectators_.begin(), spectators_.end(),
                            [&](const Spectator& s) { return s.here && s.address == from; });
  if (place != spectators_.end() && place->nonce == message.nonce) return welcome(*place);
  if (place == spectators_.end())
    place = std::find_if(spectators_.begin(), spectators_.end(),
                         [](const Spectator& s) { return !s.here; });
  if (place == spectators_.end())
    return refuse(from, message.nonce, RefuseReason::kServerFull,
                  std::to_string(kMost) + " spectators are here, and no more can be");
  *place = {};
  place->here = true;
  place->address = from;
  place->session = next_random(random_);
  place->nonce = message.nonce;
  place->heard_ns = now_ns;
  place->keep_alive_ns = now_ns + options_.times.keep_alive;
  tell({.kind = SessionEventKind::kJoined,
        .sender = kNobody,
        .session = place->session,
        .peer = from,
        .text = "spectator at " + to_string(from) + " (program " + message.program_version + ")"});
  welcome(*place);
}

void SpectatorDesk::welcome(const Spectator& spectator) {
  ControlMessage answer;
  answer.type = ControlType::kWelcome;
  answer.session = spectator.session;
  answer.nonce = spectator.nonce;
  answer.scene_hash = options_.scene_hash;
  answer.program_version = options_.program_version;
  answer.packet_hz = options_.packet_hz;
  answer.host_sender = options_.own_sender;
  send(spectator.address, answer);
}

void SpectatorDesk::refuse(const Endpoint& to, std::uint64_t nonce, RefuseReason reason,
                           const std::string& text) {
  ControlMessage answer;
  answer.type = ControlType::kRefuse;
  answer.nonce = nonce;
  answer.reason = reason;
  answer.text = text;
  send(to, answer);
  tell({.kind = SessionEventKind::kRefused,
        .sender = kNobody,
        .peer = to,
        .text = "refused spectator " + to_string(to) + ": " + text});
}

void SpectatorDesk::poll(std::int64_t now_ns) {
  for (Spectator& s : spectators_) {
    if (!s.here) continue;
    if (now_ns - s.heard_ns > options_.times.lost) {
      tell({.kind = SessionEventKind::kLeft,
            .sender = kNobody,
            .peer = s.address,
            .text = "spectator " + to_string(s.address) + " is silent and gets nothing more"});
      s = {};
      continue;
    }
    if (now_ns < s.keep_alive_ns) continue;
    s.keep_alive_ns = now_ns + options_.times.keep_alive;
    ControlMessage alive;
    alive.type = ControlType::kKeepAlive;
    alive.session = s.session;
    send(s.address, alive);
  }
}

void SpectatorDesk::leave() {
  for (Spectator& s : spectators_) {
    if (!s.here) continue;
    ControlMessage leave;
    leave.type = ControlType::kLeave;
    leave.session = s.session;
    for (int i = 0; i < 3; ++i) send(s.address, leave);
    s = {};
  }
}

}  // namespace tandem::net
