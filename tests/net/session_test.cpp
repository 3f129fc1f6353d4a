#include "net/session.h"

#include <functional>
#include <memory>
#include <random>

#include <gtest/gtest.h>

#include "net/loopback_link.h"

namespace tandem::net {
namespace {

constexpr std::int64_t kMs = 1'000'000;
constexpr std::uint64_t kHash = 0xABCDEF;
const Endpoint kHostAt = LoopbackNetwork::endpoint(7000);

HostOptions host_options() {
  HostOptions o;
  o.user_names = {"ann", "bob", "eve"};
  o.seats = {Seat::kTaken, Seat::kOpen, Seat::kOpen};
  o.scene_hash = kHash;
  for (int i = 0; i < 700; ++i) o.scene_text += "line " + std::to_string(i) + "\n";
  o.packet_hz = 128;
  o.program_version = "test 1";
  o.seed = 11;
  return o;
}

/// One host and several guests in virtual time; every datagram may be lost, doubled or delayed by
/// up to two steps of 5 ms.
class Room {
 public:
  explicit Room(HostOptions options = host_options(), double loss = 0.0)
      : host(std::move(options)), loss_(loss) {}

  GuestSession& join(std::uint16_t port, const std::string& name, std::uint64_t hash = kHash) {
    GuestOptions o;
    o.host = kHostAt;
    o.host_text = "server:7000";
    o.user_name = name;
    o.scene_hash = hash;
    o.program_version = "test 1";
    o.seed = 1000u + port + 77u * static_cast<unsigned>(members_.size());
    members_.push_back({LoopbackNetwork::endpoint(port), std::make_unique<GuestSession>(o), true});
    return *members_.back().guest;
  }

  /// SIGKILL: says nothing any more.
  void kill(std::size_t member) { members_[member].alive = false; }
  void revive(std::size_t member) { members_[member].alive = true; }

  void run(std::int64_t for_ns) {
    for (const std::int64_t end = now_ns + for_ns; now_ns < end; now_ns += 5 * kMs) {
      auto arriving = std::move(flying_);
      flying_.clear();
      for (auto& f : arriving) deliver(f);
      if (host_alive) host.poll(now_ns);
      for (auto& m : members_)
        if (m.alive) m.guest->poll(now_ns);
      collect();
    }
  }

  std::int64_t now_ns = 3'000 * kMs;
  bool host_alive = true;
  HostSession host;
  std::vector<SessionEvent> host_events, guest_events;

  [[nodiscard]] int count(const std::vector<SessionEvent>& events, SessionEventKind kind) const {
    int n = 0;
    for (const auto& e : events) n += e.kind == kind ? 1 : 0;
    return n;
  }

 private:
  struct Member {
    Endpoint at;
    std::unique_ptr<GuestSession> guest;
    bool alive;
  };
  struct Flight {
    Endpoint from, to;
    std::vector<std::uint8_t> bytes;
    int steps = 0;
  };

  void deliver(Flight& f) {
    if (f.steps-- > 0) {
      flying_.push_back(f);
      return;
    }
    if (f.to == kHostAt) {
      if (host_alive) host.on_datagram(f.bytes, f.from, now_ns);
    } else {
      for (auto& m : members_)
        if (m.alive && m.at == f.to) m.guest->on_datagram(f.bytes, f.from, now_ns);
    }
  }

  void post(const Endpoint& from, SessionDatagram d) {
    const bool lossy = loss_ > 0.0;
    if (lossy && uniform() < loss_) return;
    const int copies = lossy && uniform() < 0.2 ? 2 : 1;
    for (int i = 0; i < copies; ++i)
      flying_.push_back({from, d.to, d.bytes, lossy ? static_cast<int>(3 * uniform()) : 0});
  }

  void collect() {
    while (auto d = host.next_datagram()) post(kHostAt, *d);
    while (auto e = host.next_event()) host_events.push_back(*e);
    for (auto& m : members_) {
      while (auto d = m.guest->next_datagram())
        if (m.alive) post(m.at, *d);
      while (auto e = m.guest->next_event()) guest_events.push_back(*e);
    }
  }

  double uniform() { return static_cast<double>(random_() >> 11) * 0x1p-53; }

  double loss_;
  std::vector<Member> members_;
  std::vector<Flight> flying_;
  std::mt19937_64 random_{5};
};

using State = GuestSession::State;

TEST(Session, AGuestWithTheSameSceneJoinsAtOnce) {
  Room room;
  auto& bob = room.join(1, "bob");
  room.run(50 * kMs);
  ASSERT_EQ(bob.state(), State::kJoined);
  EXPECT_EQ(bob.welcome().user_index, 1u);
  EXPECT_EQ(bob.welcome().host_sender, core::kServerSender);
  EXPECT_EQ(bob.welcome().packet_hz, 128.0);
  ASSERT_EQ(room.host_events.size(), 1u);
  ASSERT_EQ(room.guest_events.size(), 1u);
  EXPECT_EQ(room.host_events[0].kind, SessionEventKind::kJoined);
  EXPECT_EQ(room.host_events[0].session, room.guest_events[0].session);
  EXPECT_NE(room.host_events[0].session, 0u);
}

TEST(Session, AGuestWithoutASceneGetsItWhole) {
  Room room;
  auto& bob = room.join(1, "bob", 0);
  room.run(300 * kMs);
  ASSERT_EQ(bob.state(), State::kJoined);
  EXPECT_EQ(bob.scene_text(), room.host.options().scene_text);
  EXPECT_EQ(bob.welcome().scene_hash, kHash);
}

// 30 % lost, 20 % doubled, reordered: the handshake and 7 chunks of scene still come through, and
// the host starts one session only.
TEST(Session, LossDuplicatesAndReorderingOnlyDelayTheHandshake) {
  Room room(host_options(), 0.3);
  auto& bob = room.join(1, "bob", 0);
  auto& eve = room.join(2, "eve", 0);
  room.run(5'000 * kMs);
  ASSERT_EQ(bob.state(), State::kJoined);
  ASSERT_EQ(eve.state(), State::kJoined);
  EXPECT_EQ(bob.scene_text(), room.host.options().scene_text);
  EXPECT_EQ(eve.scene_text(), room.host.options().scene_text);
  EXPECT_EQ(room.count(room.host_events, SessionEventKind::kJoined), 2);
}

TEST(Session, KeepAlivesHoldASessionWithoutStateForAMinute) {
  Room room;
  auto& bob = room.join(1, "bob");
  room.run(60'000 * kMs);
  EXPECT_EQ(bob.state(), State::kJoined);
  EXPECT_EQ(room.host_events.size(), 1u);
  EXPECT_EQ(room.guest_events.size(), 1u);
}

TEST(Session, NobodyThereIsSaidAfterFiveSecondsWithTheAddress) {
  Room room;
  room.host_alive = false;
  auto& bob = room.join(1, "bob");
  room.run(4'900 * kMs);
  EXPECT_TRUE(room.guest_events.empty());
  room.run(200 * kMs);
  ASSERT_EQ(room.guest_events.size(), 1u);
  EXPECT_EQ(room.guest_events[0].kind, SessionEventKind::kFailed);
  EXPECT_EQ(room.guest_events[0].text,
            "no answer from server:7000 after 5 s: is the server running and the port open?");
  room.host_alive = true;  // late start of the server: the guest has gone on asking
  room.run(1'500 * kMs);
  EXPECT_EQ(bob.state(), State::kJoined);
}

TEST(Session, HellosAreRepeatedWithBackOff) {
  GuestOptions o;
  o.host = kHostAt;
  o.seed = 3;
  GuestSession guest(o);
  std::vector<std::int64_t> sent_ms;
  for (std::int64_t ms = 0; ms < 5000; ++ms) {
    guest.poll(ms * kMs);
    while (guest.next_datagram()) sent_ms.push_back(ms);
  }
  EXPECT_EQ(sent_ms, (std::vector<std::int64_t>{0, 100, 300, 700, 1500, 2500, 3500, 4500}));
}

struct RefusalCase {
  const char* name;
  std::uint64_t hash;
  RefuseReason reason;
  const char* says;
};

TEST(Session, EveryRefusalNamesItsReasonAndWhatToDo) {
  const RefusalCase cases[] = {
      {"zoe", kHash, RefuseReason::kUnknownUserName, "no user 'zoe'; 'bob', 'eve' can join"},
      {"ann", kHash, RefuseReason::kUserNameTaken, "sits at the host itself"},
      {"bob", kHash + 1, RefuseReason::kOtherScene, "the host runs scene 0000000000abcdef"},
  };
  for (const auto& c : cases) {
    Room room;
    auto& guest = room.join(1, c.name, c.hash);
    room.run(100 * kMs);
    EXPECT_EQ(guest.state(), State::kRefused) << c.name;
    EXPECT_EQ(guest.refusal(), c.reason);
    ASSERT_FALSE(room.guest_events.empty());
    EXPECT_NE(room.guest_events[0].text.find(c.says), std::string::npos)
        << room.guest_events[0].text;
    EXPECT_EQ(room.host.refused(), 1u);
  }
}

TEST(Session, AFullServerSaysSo) {
  Room room;
  room.join(1, "");
  room.join(2, "");
  room.run(50 * kMs);
  auto& late = room.join(3, "");
  room.run(50 * kMs);
  EXPECT_EQ(late.state(), State::kRefused);
  EXPECT_EQ(late.refusal(), RefuseReason::kServerFull);
}

TEST(Session, InAMeshTheUserOfTheLowerIndexHosts) {
  auto options = host_options();
  options.own_sender = 1;
  options.seats = {Seat::kHosts, Seat::kTaken, Seat::kOpen};
  Room room(options);
  auto& ann = room.join(1, "ann");
  auto& eve = room.join(2, "eve");
  room.run(50 * kMs);
  EXPECT_EQ(ann.refusal(), RefuseReason::kWrongRole);
  ASSERT_EQ(eve.state(), State::kJoined);
  EXPECT_EQ(eve.welcome().host_sender, 1u);
}

TEST(Session, AGuestOfAnotherVersionIsToldInAMessageItCanRead) {
  HostSession host(host_options());
  ControlMessage hello;
  hello.version = kProtocolVersion + 1;
  hello.type = ControlType::kHello;
  hello.nonce = 99;
  host.on_datagram(encode_control(hello), LoopbackNetwork::endpoint(1), 0);
  const auto answer = host.next_datagram();
  ASSERT_TRUE(answer);
  const auto message = decode_control(answer->bytes);
  ASSERT_TRUE(message);
  EXPECT_EQ(message->reason, RefuseReason::kWrongVersion);
  EXPECT_EQ(message->nonce, 99u);

  // And the other way: our guest reads a refusal in another version's envelope.
  Room room;
  auto& bob = room.join(1, "bob");
  bob.poll(0);
  const auto our_hello = decode_control(bob.next_datagram()->bytes);
  ASSERT_TRUE(our_hello);
  ControlMessage refusal;
  refusal.version = kProtocolVersion + 1;
  refusal.type = ControlType::kRefuse;
  refusal.nonce = our_hello->nonce;
  refusal.reason = RefuseReason::kWrongVersion;
  bob.on_datagram(encode_control(refusal), kHostAt, kMs);
  EXPECT_EQ(bob.refusal(), RefuseReason::kWrongVersion);
}

TEST(Session, ALiveUserIsNotThrownOutByItsName) {
  Room room;
  auto& bob = room.join(1, "bob");
  room.run(1'000 * kMs);
  auto& impostor = room.join(2, "bob");
  room.run(1'500 * kMs);
  EXPECT_EQ(impostor.state(), State::kRefused);
  EXPECT_EQ(impostor.refusal(), RefuseReason::kUserNameTaken);
  EXPECT_EQ(bob.state(), State::kJoined);
  EXPECT_EQ(room.count(room.host_events, SessionEventKind::kJoined), 1);
}

TEST(Session, AKilledUserIsBackUnderANewPortWithinTwoSeconds) {
  Room room;
  room.join(1, "bob");
  room.run(1'000 * kMs);
  room.kill(0);
  room.run(100 * kMs);
  auto& again = room.join(2, "bob");
  room.run(2'500 * kMs);
  ASSERT_EQ(again.state(), State::kJoined);
  EXPECT_EQ(room.count(room.host_events, SessionEventKind::kJoined), 2);
  EXPECT_NE(room.host_events[0].session, room.host_events[1].session);
}

TEST(Session, FromTheSameAddressAUserIsBackAtOnce) {
  Room room;
  room.join(1, "bob");
  room.run(1'000 * kMs);
  room.kill(0);
  auto& again = room.join(1, "bob");
  room.run(50 * kMs);
  EXPECT_EQ(again.state(), State::kJoined);
  EXPECT_EQ(room.count(room.host_events, SessionEventKind::kJoined), 2);
}

TEST(Session, AfterAnOutageTheGuestJoinsAnewByItself) {
  Room room;
  auto& bob = room.join(1, "bob");
  room.run(500 * kMs);
  room.host_alive = false;
  room.run(3'000 * kMs);
  EXPECT_EQ(bob.state(), State::kHello);
  EXPECT_EQ(room.count(room.guest_events, SessionEventKind::kLost), 1);
  room.host_alive = true;
  room.run(1'500 * kMs);
  EXPECT_EQ(bob.state(), State::kJoined);
  EXPECT_EQ(room.count(room.guest_events, SessionEventKind::kJoined), 2);
}

TEST(Session, ARestartedServerTellsOldGuestsToJoinAgain) {
  Room room;
  auto& bob = room.join(1, "bob");
  room.run(500 * kMs);
  auto options = host_options();
  options.seed = 12;
  room.host = HostSession(options);
  room.run(500 * kMs);  // one keep-alive, one refusal, one HELLO
  EXPECT_EQ(bob.state(), State::kJoined);
  EXPECT_EQ(room.count(room.guest_events, SessionEventKind::kLost), 1);
}

TEST(Session, LeavingFreesTheSeatAndLateJoinersGetIt) {
  Room room;
  auto& bob = room.join(1, "bob");
  room.run(100 * kMs);
  bob.leave();
  room.run(50 * kMs);
  EXPECT_EQ(room.count(room.host_events, SessionEventKind::kLeft), 1);
  auto& other = room.join(2, "bob");
  room.run(50 * kMs);
  EXPECT_EQ(other.state(), State::kJoined);
}

TEST(Session, WhenTheHostLeavesGuestsAreToldAndComeBackToItsSuccessor) {
  Room room;
  auto& bob = room.join(1, "bob");
  room.run(100 * kMs);
  room.host.leave();
  room.run(50 * kMs);
  EXPECT_EQ(room.count(room.guest_events, SessionEventKind::kLeft), 1);
  EXPECT_EQ(bob.state(), State::kHello);
  room.run(1'500 * kMs);
  EXPECT_EQ(bob.state(), State::kJoined);
}

TEST(Session, ASilentSeatIsFreeAfterTenSeconds) {
  Room room;
  room.join(1, "bob");
  room.run(100 * kMs);
  room.kill(0);
  room.run(9'800 * kMs);
  EXPECT_EQ(room.count(room.host_events, SessionEventKind::kLeft), 0);
  room.run(600 * kMs);
  EXPECT_EQ(room.count(room.host_events, SessionEventKind::kLeft), 1);
}

TEST(ControlMessage, TextThatWouldReachATerminalHasNoControlCharacters) {
  ControlMessage m;
  m.type = ControlType::kHello;
  m.nonce = 1;
  m.user_name = "bob\x1b[2J";
  const auto read = decode_control(encode_control(m));
  ASSERT_TRUE(read);
  EXPECT_EQ(read->user_name, "bob [2J");
  // From a program that does not clean: the byte is put back behind our encoder's back.
  auto bytes = encode_control(m);
  *std::find(bytes.begin(), bytes.end(), ' ') = 0x1b;
  EXPECT_FALSE(decode_control(bytes));
}

TEST(Session, MutatedControlPacketsNeverCrashNorThrowAGuestOut) {
  Room room;
  auto& bob = room.join(1, "bob", 0);
  room.run(300 * kMs);
  ASSERT_EQ(bob.state(), State::kJoined);
  ControlMessage m;
  m.session = 4;
  m.nonce = 6;
  m.scene_hash = kHash;
  m.user_name = "bob";
  m.packet_hz = 128;
  m.reason = RefuseReason::kUnknownSession;
  m.total = 50;
  m.chunk = "0123456789";
  std::mt19937_64 random(17);
  for (int i = 0; i < 200'000; ++i) {
    m.type = static_cast<ControlType>(1 + random() % 7);
    auto bytes = encode_control(m);
    for (auto flips = random() % 4; flips > 0; --flips)
      bytes[random() % bytes.size()] ^= static_cast<std::uint8_t>(random());
    if (random() % 4 == 0) bytes.resize(random() % bytes.size());
    room.host.on_datagram(bytes, LoopbackNetwork::endpoint(9), room.now_ns);
    while (room.host.next_datagram()) {
    }
    bob.on_datagram(bytes, kHostAt, room.now_ns);
  }
  EXPECT_EQ(bob.state(), State::kJoined);
  room.run(500 * kMs);
  EXPECT_EQ(bob.state(), State::kJoined);
}

}  // namespace
}  // namespace tandem::net
