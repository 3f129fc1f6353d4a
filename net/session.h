#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/packet.h"
#include "core/scene.h"
#include "net/control_message.h"
#include "net/endpoint.h"

/// Joining, staying and leaving, as two state machines without socket and clock: datagrams and
/// times go in, datagrams and events come out. The rules are in WIRE_FORMAT.md.
namespace tandem::net {

/// [ns]; the defaults are what WIRE_FORMAT.md promises.
struct SessionTimes {
  std::int64_t first_repeat = 100'000'000;  ///< of a HELLO or SCENE_REQUEST; doubles up to
  std::int64_t last_repeat = 1'000'000'000;
  std::int64_t give_up = 5'000'000'000;  ///< without an answer: tell the user
  std::int64_t keep_alive = 250'000'000;
  std::int64_t lost = 2'000'000'000;     ///< guest: silence after which it joins anew
  std::int64_t replace = 1'000'000'000;  ///< host: silence after which another may take the seat
  std::int64_t forget = 10'000'000'000;  ///< host: silence after which the seat is free
};

struct SessionDatagram {
  Endpoint to;
  std::vector<std::uint8_t> bytes;
};

enum class SessionEventKind : std::uint8_t {
  kJoined,   ///< a session begins; also after a reconnect, with a new session number
  kLeft,     ///< the peer said so, or (host) was silent for `forget`
  kLost,     ///< guest: the host is silent or has forgotten us; joining anew
  kRefused,  ///< guest: final; host: somebody was turned away
  kFailed,   ///< guest: no answer in `give_up`; it goes on asking
};

/// Sender of an event that is about no participant: a spectator.
inline constexpr std::uint32_t kNobody = 0xffffffff;

struct SessionEvent {
  SessionEventKind kind = SessionEventKind::kJoined;
  std::uint32_t sender = 0;   ///< the peer's sender index, where known
  std::uint64_t session = 0;  ///< kJoined
  Endpoint peer;
  std::string text;  ///< for people
};

/// What both roles put out; the caller empties both queues after every call.
class SessionOutput {
 public:
  [[nodiscard]] std::optional<SessionDatagram> next_datagram();
  [[nodiscard]] std::optional<SessionEvent> next_event();

 protected:
  void send(const Endpoint& to, const ControlMessage& message);
  void tell(SessionEvent event) { events_.push_back(std::move(event)); }

 private:
  std::deque<SessionDatagram> datagrams_;
  std::deque<SessionEvent> events_;
};

/// Whether a user of the scene can join at this host.
enum class Seat : std::uint8_t {
  kOpen,   ///< joins here
  kTaken,  ///< sits at this computer
  kHosts,  ///< mesh: has a lower index, so it hosts and we join there
};

struct HostOptions {
  std::uint32_t own_sender = core::kServerSender;  ///< or our user index in a mesh
  std::vector<std::string> user_names;             ///< of the scene, in order
  std::vector<Seat> seats;                         ///< one a user
  std::uint64_t scene_hash = 0;                    ///< not 0
  std::string scene_text;                          ///< sent to whoever asks, unread
  double packet_hz = 128.0;
  std::string program_version;
  std::uint64_t seed = 0;  ///< of the session numbers: from a random device
  SessionTimes times{};
};

/// The side that gives out seats: the server, or a replica towards users of higher index.
class HostSession : public SessionOutput {
 public:
  /// @throws std::invalid_argument for a scene text or user list nothing can be done with
  explicit HostSession(HostOptions options);

  void on_datagram(std::span<const std::uint8_t> datagram, const Endpoint& from,
                   std::int64_t now_ns);
  /// Call at least every 50 ms.
  void poll(std::int64_t now_ns);
  /// A state packet of this user was accepted: it lives.
  void heard(std::uint32_t user_index, std::int64_t now_ns) noexcept;
  /// Says goodbye to everyone and frees all seats.
  void leave();

  [[nodiscard]] const HostOptions& options() const { return options_; }
  [[nodiscard]] std::uint64_t refused() const { return refused_; }

 private:
  struct Guest {
    bool here = false;
    Endpoint address;
    std::uint64_t session = 0;
    std::uint64_t nonce = 0;
    std::uint64_t previous_nonce = 0;
    std::int64_t heard_ns = 0;
    std::int64_t keep_alive_ns = 0;  ///< when the next one is due
    Endpoint contender;              ///< somebody else who wants this seat
    std::int64_t contended_ns = -1;
  };

  void on_hello(const ControlMessage& hello, const Endpoint& from, std::int64_t now_ns);
  [[nodiscard]] int choose_seat(const ControlMessage& hello, const Endpoint& from);
  void seat(int index, const ControlMessage& hello, const Endpoint& from, std::int64_t now_ns);
  void welcome(int index);
  void refuse(const Endpoint& to, const ControlMessage& request, RefuseReason reason,
              const std::string& text);
  void send_chunk(const Guest& guest, std::uint32_t offset);
  [[nodiscard]] std::string list_of_users() const;
  [[nodiscard]] std::uint64_t next_session() noexcept;

  HostOptions options_;
  std::array<Guest, core::kMaxUsers> guests_{};
  std::uint64_t random_;
  std::uint64_t refused_ = 0;
  std::int64_t unknown_answered_ns_ = 0;  ///< last REFUSE for an unknown session
};

struct GuestOptions {
  Endpoint host;
  std::string host_text;         ///< as the user wrote it, for messages
  std::string user_name;         ///< empty: any free seat
  std::uint64_t scene_hash = 0;  ///< 0: send me the scene
  bool spectator = false;        ///< takes no seat, only looks on
  std::string program_version;
  std::uint64_t seed = 0;  ///< of the nonces: from a random device
  SessionTimes times{};
};

/// The side that asks for a seat: a client, or a replica towards users of lower index.
class GuestSession : public SessionOutput {
 public:
  enum class State : std::uint8_t { kHello, kScene, kJoined, kRefused, kLeft };

  explicit GuestSession(GuestOptions options);

  void on_datagram(std::span<const std::uint8_t> datagram, const Endpoint& from,
                   std::int64_t now_ns);
  /// Call at least every 50 ms; the first call starts the handshake.
  void poll(std::int64_t now_ns);
  /// A state packet of the host was accepted: it lives.
  void heard(std::int64_t now_ns) noexcept { heard_ns_ = now_ns; }
  void leave();

  [[nodiscard]] State state() const noexcept { return state_; }
  [[nodiscard]] const GuestOptions& options() const { return options_; }
  /// What the host said; valid once kJoined.
  [[nodiscard]] const ControlMessage& welcome() const { return welcome_; }
  /// The host's scene, if we asked for it; complete once kJoined.
  [[nodiscard]] const std::string& scene_text() const { return scene_text_; }
  [[nodiscard]] RefuseReason refusal() const noexcept { return refusal_; }

 private:
  void begin_hello(std::int64_t now_ns);
  void on_welcome(const ControlMessage& message, std::int64_t now_ns);
  void on_refuse(const ControlMessage& message, std::int64_t now_ns);
  void on_chunk(const ControlMessage& message, std::int64_t now_ns);
  void request_scene(std::int64_t now_ns);
  void joined(std::int64_t now_ns);
  void lose(std::int64_t now_ns, SessionEventKind kind, const std::string& text);

  GuestOptions options_;
  State state_ = State::kHello;
  ControlMessage welcome_;
  std::string scene_text_;
  std::uint32_t scene_total_ = 0;
  RefuseReason refusal_ = RefuseReason::kNone;
  std::uint64_t random_;
  std::uint64_t nonce_ = 0;    ///< 0: the handshake has not begun
  std::int64_t began_ns_ = 0;  ///< of this attempt
  bool told_failure_ = false;
  std::int64_t next_send_ns_ = 0;  ///< next HELLO, SCENE_REQUEST or KEEP_ALIVE
  std::int64_t repeat_ns_ = 0;     ///< back-off
  std::int64_t heard_ns_ = 0;
};

}  // namespace tandem::net
