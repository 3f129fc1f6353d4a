#include <algorithm>

#include "net/session.h"
#include "net/session_random.h"

namespace tandem::net {

GuestSession::GuestSession(GuestOptions options)
    : options_(std::move(options)), random_(options_.seed) {
  if (options_.host_text.empty()) options_.host_text = to_string(options_.host);
}

void GuestSession::begin_hello(std::int64_t now_ns) {
  state_ = State::kHello;
  nonce_ = next_random(random_);
  began_ns_ = now_ns;
  told_failure_ = false;
  next_send_ns_ = now_ns;
  repeat_ns_ = options_.times.first_repeat;
}

void GuestSession::on_datagram(std::span<const std::uint8_t> datagram, const Endpoint& from,
                               std::int64_t now_ns) {
  if (from != options_.host || state_ == State::kRefused || state_ == State::kLeft) return;
  const auto message = decode_control(datagram);
  if (!message) return;
  if (message->type == ControlType::kRefuse) return on_refuse(*message, now_ns);
  if (message->version != kProtocolVersion) return;
  if (message->type == ControlType::kWelcome) return on_welcome(*message, now_ns);

  if (state_ == State::kHello || message->session != welcome_.session) return;
  heard_ns_ = now_ns;
  if (message->type == ControlType::kSceneChunk) return on_chunk(*message, now_ns);
  if (message->type == ControlType::kLeave)
    lose(now_ns, SessionEventKind::kLeft, options_.host_text + " left the session");
}

void GuestSession::on_welcome(const ControlMessage& message, std::int64_t now_ns) {
  if (state_ != State::kHello || nonce_ == 0 || message.nonce != nonce_) return;
  if (options_.scene_hash != 0 && message.scene_hash != options_.scene_hash) return;
  welcome_ = message;
  heard_ns_ = now_ns;
  if (options_.scene_hash != 0) return joined(now_ns);
  state_ = State::kScene;
  scene_text_.clear();
  scene_total_ = 0;
  repeat_ns_ = options_.times.first_repeat;
  request_scene(now_ns);
}

void GuestSession::joined(std::int64_t now_ns) {
  state_ = State::kJoined;
  options_.scene_hash = welcome_.scene_hash;  // when we come back it must still be this one
  options_.user_name = welcome_.user_name.empty() ? options_.user_name : welcome_.user_name;
  next_send_ns_ = now_ns;
  tell({.kind = SessionEventKind::kJoined,
        .sender = welcome_.host_sender,
        .session = welcome_.session,
        .peer = options_.host,
        .text = "joined " + options_.host_text + " as " +
                (options_.spectator ? "a spectator" : "user '" + options_.user_name + "'") +
                " (program " + welcome_.program_version + ")"});
}

void GuestSession::on_refuse(const ControlMessage& message, std::int64_t now_ns) {
  if (message.reason == RefuseReason::kUnknownSession) {
    if (state_ != State::kHello && message.session == welcome_.session)
      lose(now_ns, SessionEventKind::kLost, options_.host_text + " no longer knows us");
    return;
  }
  if (state_ != State::kHello || nonce_ == 0 || message.nonce != nonce_) return;
  refusal_ = message.reason;
  state_ = State::kRefused;
  tell({.kind = SessionEventKind::kRefused,
        .peer = options_.host,
        .text =
            options_.host_text + " refused us: " + name_of(message.reason) + ": " + message.text});
}

void GuestSession::request_scene(std::int64_t now_ns) {
  ControlMessage request;
  request.type = ControlType::kSceneRequest;
  request.session = welcome_.session;
  request.offset = static_cast<std::uint32_t>(scene_text_.size());
  send(options_.host, request);
  next_send_ns_ = now_ns + repeat_ns_;
}

void GuestSession::on_chunk(const ControlMessage& message, std::int64_t now_ns) {
  if (state_ != State::kScene) return;
  if (message.total != scene_total_) {
    scene_text_.clear();
    scene_total_ = message.total;
  }
  if (message.offset != scene_text_.size()) return;  // a second copy
  scene_text_ += message.chunk;
  if (scene_text_.size() == scene_total_) return joined(now_ns);
  repeat_ns_ = options_.times.first_repeat;
  request_scene(now_ns);
}

void GuestSession::lose(std::int64_t now_ns, SessionEventKind kind, const std::string& text) {
  const std::uint32_t sender = welcome_.host_sender;
  begin_hello(now_ns);
  // After a goodbye the host is expected to be away for a while.
  if (kind == SessionEventKind::kLeft) next_send_ns_ = now_ns + options_.times.last_repeat;
  tell({.kind = kind, .sender = sender, .peer = options_.host, .text = text});
}

void GuestSession::poll(std::int64_t now_ns) {
  if (state_ == State::kRefused || state_ == State::kLeft) return;
  if (nonce_ == 0) begin_hello(now_ns);
  if (state_ != State::kHello && now_ns - heard_ns_ > options_.times.lost)
    lose(now_ns, SessionEventKind::kLost, options_.host_text + " is silent; joining again");

  if (state_ == State::kHello && !told_failure_ && now_ns - began_ns_ >= options_.times.give_up) {
    told_failure_ = true;
    tell({.kind = SessionEventKind::kFailed,
          .peer = options_.host,
          .text = "no answer from " + options_.host_text + " after " +
                  std::to_string(options_.times.give_up / 1'000'000'000) +
                  " s: is the server running and the port open?"});
  }
  if (now_ns < next_send_ns_) return;

  switch (state_) {
    case State::kHello: {
      ControlMessage hello;
      hello.type = options_.spectator ? ControlType::kSpectate : ControlType::kHello;
      hello.nonce = nonce_;
      hello.scene_hash = options_.scene_hash;
      hello.user_name = options_.user_name;
      hello.program_version = options_.program_version;
      send(options_.host, hello);
      next_send_ns_ = now_ns + repeat_ns_;
      repeat_ns_ = std::min(2 * repeat_ns_, options_.times.last_repeat);
      break;
    }
    case State::kScene:
      repeat_ns_ = std::min(2 * repeat_ns_, options_.times.last_repeat);
      request_scene(now_ns);
      break;
    case State::kJoined: {
      ControlMessage alive;
      alive.type = ControlType::kKeepAlive;
      alive.session = welcome_.session;
      send(options_.host, alive);
      next_send_ns_ = now_ns + options_.times.keep_alive;
      break;
    }
    case State::kRefused:
    case State::kLeft:
      break;
  }
}

void GuestSession::leave() {
  if (state_ == State::kJoined || state_ == State::kScene) {
    ControlMessage leave;
    leave.type = ControlType::kLeave;
    leave.session = welcome_.session;
    for (int i = 0; i < 3; ++i) send(options_.host, leave);
  }
  state_ = State::kLeft;
}

}  // namespace tandem::net
