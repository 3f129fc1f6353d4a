#include "net/peer_link.h"

#include <cmath>

#include <gtest/gtest.h>

#include "net/loopback_link.h"
#include "net/udp_socket.h"
#include "tests/net/peer_link_testing.h"

namespace tandem::net {
namespace {

TEST(PeerLink, AMeshOfThreeReplicasTalksInEveryDirection) {
  PeerLink r0(hosting(0, {Seat::kTaken, Seat::kOpen, Seat::kOpen}));
  auto o1 = joining({address_of(r0)}, "2");
  o1.host = host_options(1, {Seat::kHosts, Seat::kTaken, Seat::kOpen});
  PeerLink r1(o1);
  PeerLink r2(joining({address_of(r0), address_of(r1)}, "3"));
  for (PeerLink* r : {&r2, &r1, &r0}) r->start();  // whoever joins may be up first
  ASSERT_TRUE(r2.wait_until_joined(5).joined);
  ASSERT_TRUE(r1.wait_until_joined(5).joined);
  ASSERT_TRUE(eventually([&] { return r0.connected_peers() == 2 && r1.connected_peers() == 2; }));
  const std::int64_t start = core::monotonic_ns() + 5'000'000;
  ForceLoop f0(r0, 0, {1, 2}, start), f1(r1, 1, {0, 2}, start), f2(r2, 2, {0, 1}, start);
  ASSERT_TRUE(eventually([&] {
    return r0.statistics(1).accepted > 20 && r0.statistics(2).accepted > 20 &&
           r1.statistics(0).accepted > 20 && r1.statistics(2).accepted > 20 &&
           r2.statistics(0).accepted > 20 && r2.statistics(1).accepted > 20;
  }));
  for (ForceLoop* f : {&f0, &f1, &f2}) f->stop();
  expect_consistent(f0.received[1], 2);
  expect_consistent(f1.received[0], 0);
  expect_consistent(f2.received[1], 1);
}

TEST(PeerLink, RefusalsAndSilenceAreSaidInWords) {
  PeerLink server(hosting(core::kServerSender, {Seat::kOpen, Seat::kOpen}));
  server.start();
  PeerLink one(joining({address_of(server)}, "1"));
  one.start();
  ASSERT_TRUE(one.wait_until_joined(5).joined);

  PeerLink again(joining({address_of(server)}, "1"));
  again.start();
  const JoinResult twice = again.wait_until_joined(5);
  EXPECT_FALSE(twice.joined);
  EXPECT_NE(twice.error.find("already here"), std::string::npos) << twice.error;

  PeerLink other(joining({address_of(server)}, "2", kHash + 1));
  other.start();
  EXPECT_NE(other.wait_until_joined(5).error.find("other scene"), std::string::npos);
  // Whoever has read the messages is still told: a node that runs ends itself by this.
  EXPECT_FALSE(other.take_messages().empty());
  EXPECT_EQ(other.wait_until_joined(0).error, "refused");

  UdpLink nobody("127.0.0.1:0");  // a bound port where nothing answers
  auto options = joining({to_string(nobody.local())}, "1");
  options.times.give_up = 300'000'000;
  PeerLink lonely(options);
  lonely.start();
  const std::string error = lonely.wait_until_joined(5).error;
  EXPECT_NE(error.find("no answer from " + to_string(nobody.local())), std::string::npos) << error;

  EXPECT_THROW(PeerLink(joining({address_of(server), address_of(server)}, "1")),
               std::invalid_argument);
}

TEST(PeerLink, LeavingIsToldToTheForceLoopOfTheOther) {
  PeerLink server(hosting(core::kServerSender, {Seat::kOpen}));
  server.start();
  auto one = std::make_unique<PeerLink>(joining({address_of(server)}, "1"));
  one->start();
  ASSERT_TRUE(one->wait_until_joined(5).joined);
  const std::int64_t start = core::monotonic_ns();
  ForceLoop s(server, core::kServerSender, {0}, start);
  {
    ForceLoop a(*one, 0, {core::kServerSender}, start);
    ASSERT_TRUE(eventually([&] { return server.statistics(0).accepted > 10; }));
  }
  one.reset();
  ASSERT_TRUE(eventually([&] { return server.connected_peers() == 0; }));
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  s.stop();
  ASSERT_FALSE(s.received[0].empty());
  EXPECT_TRUE(s.received[0].back().left);
  EXPECT_FALSE(server.status(0).connected);
}

TEST(PeerLink, AClientThatIsReadyLateHasNeitherLostNorRejectedAnything) {
  PeerLink server(hosting(core::kServerSender, {Seat::kOpen}));
  server.start();
  PeerLink one(joining({address_of(server)}, "1"));
  one.start();
  ASSERT_TRUE(one.wait_until_joined(5).joined);
  const std::int64_t start = core::monotonic_ns();
  ForceLoop s(server, core::kServerSender, {0}, start);
  ASSERT_TRUE(eventually([&] { return server.statistics(0).packets_sent > 20; }));
  ForceLoop a(one, 0, {core::kServerSender}, start);
  ASSERT_TRUE(eventually([&] { return one.statistics(core::kServerSender).accepted > 10; }));
  const LinkSnapshot t = one.statistics(core::kServerSender);
  EXPECT_EQ(t.lost, 0u);
  EXPECT_EQ(t.by_reason.rejected(), 0u);
  EXPECT_EQ(one.strays().rejected(), 0u);
}

// Over the in-process network with a cable that can be cut: silence, loss, copies, all at will.
TEST(PeerLink, ACutCableMeansANewEpochAndANewSessionAfterwards) {
  std::atomic<bool> cut{false};
  LoopbackNetwork network([&](auto&&...) { return cut ? 0 : 1; });
  SessionTimes quick;
  quick.lost = 300'000'000;
  auto server_options = hosting(core::kServerSender, {Seat::kOpen});
  auto one_options = joining({"127.0.0.1:7000"}, "1");
  server_options.times = one_options.times = quick;
  PeerLink server(server_options, network.open(7000));
  PeerLink one(one_options, network.open(7001));
  server.start();
  one.start();
  ASSERT_TRUE(one.wait_until_joined(5).joined);
  const std::int64_t start = core::monotonic_ns();
  ForceLoop s(server, core::kServerSender, {0}, start);
  ForceLoop a(one, 0, {core::kServerSender}, start);
  ASSERT_TRUE(eventually([&] { return one.statistics(core::kServerSender).accepted > 10; }));
  cut = true;
  ASSERT_TRUE(eventually([&] { return !one.status(core::kServerSender).connected; }));
  cut = false;
  ASSERT_TRUE(eventually(
      [&] { return server.status(0).epoch == 2 && one.status(core::kServerSender).epoch == 2; }));
  const auto before = server.statistics(0).accepted;
  ASSERT_TRUE(eventually([&] { return server.statistics(0).accepted > before + 10; }));
  s.stop();
  a.stop();
  expect_consistent(s.received[0], 0);
  expect_consistent(a.received[0], core::kServerSender);
  EXPECT_EQ(s.received[0].back().epoch, 2u);
  EXPECT_FALSE(s.received[0].back().left);
}

TEST(PeerLink, LostAndDoubledPacketsAreCountedAsSuch) {
  std::uint64_t state_packets = 0, lost = 0, doubled = 0;  // under the network's lock
  LoopbackNetwork network([&](const Endpoint& from, auto&&, std::span<const std::uint8_t> d) {
    if (from.port != 7001 || d[5] != static_cast<std::uint8_t>(Kind::kState)) return 1;
    ++state_packets;
    if (state_packets % 10 == 3) return ++lost, 0;
    if (state_packets % 10 == 6) return ++doubled, 2;
    return 1;
  });
  PeerLink server(hosting(core::kServerSender, {Seat::kOpen}), network.open(7000));
  PeerLink one(joining({"127.0.0.1:7000"}, "1"), network.open(7001));
  server.start();
  one.start();
  ASSERT_TRUE(one.wait_until_joined(5).joined);
  const std::int64_t start = core::monotonic_ns();
  ForceLoop s(server, core::kServerSender, {0}, start, true);
  ForceLoop a(one, 0, {core::kServerSender}, start);
  ASSERT_TRUE(eventually([&] { return server.statistics(0).accepted > 60; }));
  a.stop();
  one.stop();
  server.stop();
  const LinkSnapshot t = server.statistics(0);
  EXPECT_GE(lost, 6u);
  EXPECT_GE(t.lost + 1, lost);  // the last one lost shows only when a later one arrives
  EXPECT_LE(t.lost, lost);
  EXPECT_EQ(t.duplicates, doubled);
  EXPECT_EQ(t.by_reason.of(Decode::kDuplicate), doubled);
  EXPECT_EQ(t.packets_received, state_packets - lost + doubled);
}

TEST(PeerLink, BadPacketsAreCountedAndNoneIsFelt) {
  PeerLink server(hosting(core::kServerSender, {Seat::kOpen}));
  server.start();
  ForceLoop s(server, core::kServerSender, {0}, core::monotonic_ns(), true);
  UdpLink stranger("127.0.0.1:0");
  const Endpoint to = server.local();
  StateEncoder encoder;
  core::StatePacket packet;
  packet.sequence = 1;
  packet.value_count = kValues;
  stranger.send(to, encoder.encode(packet, 1));                     // unknown sender
  std::vector<std::uint8_t> bytes{'T', 'N', 'D', 'M', 9, 1, 0, 0};  // another version
  stranger.send(to, bytes);
  stranger.send(to, std::vector<std::uint8_t>{'G', 'E', 'T', ' ', '/'});
  stranger.send(to, std::vector<std::uint8_t>(1400, 'T'));
  stranger.send(to, {});
  ASSERT_TRUE(eventually([&] { return server.strays().rejected() == 5; }));
  const DecodeCounts strays = server.strays();
  EXPECT_EQ(strays.of(Decode::kUnknownSender), 1u);
  EXPECT_EQ(strays.of(Decode::kWrongVersion), 1u);
  EXPECT_EQ(strays.of(Decode::kWrongMagic), 2u);
  EXPECT_EQ(strays.of(Decode::kMalformed), 1u);
  PeerSample sample;
  EXPECT_FALSE(server.inbox(0).fetch(sample));
}

// A guest that holds a true session and sends nonsense over it: the worst a broken peer can do.
TEST(PeerLink, NonsenseFromAJoinedPeerIsCountedByReasonAndNotFelt) {
  PeerLink server(hosting(core::kServerSender, {Seat::kOpen}));
  server.start();
  ForceLoop s(server, core::kServerSender, {0}, core::monotonic_ns(), true);
  UdpLink socket("127.0.0.1:0");
  GuestOptions options;
  options.host = server.local();
  options.user_name = "1";
  options.scene_hash = kHash;
  GuestSession guest(options);
  std::array<std::uint8_t, 1300> buffer;
  Endpoint from;
  ASSERT_TRUE(eventually([&] {
    guest.poll(core::monotonic_ns());
    while (auto d = guest.next_datagram()) socket.send(d->to, d->bytes);
    while (auto n = socket.receive(from, buffer))
      guest.on_datagram({buffer.data(), *n}, from, core::monotonic_ns());
    return guest.state() == GuestSession::State::kJoined;
  }));
  const std::uint64_t session = guest.welcome().session;
  StateEncoder encoder;
  const auto send = [&](auto edit, std::uint64_t in_session) {
    core::StatePacket p;
    p.sequence = 5;
    p.value_count = kValues;
    p.send_ns = core::monotonic_ns();
    edit(p);
    socket.send(server.local(), encoder.encode(p, in_session));
  };
  using P = core::StatePacket&;
  send([](P) {}, session);
  send([](P) {}, session);                                 // duplicate
  send([](P p) { p.sequence = 4; }, session);              // old
  send([](P) {}, session ^ 1);                             // wrong session
  send([](P p) { p.values[3] = std::nan(""); }, session);  // not finite
  send([](P p) { p.values[3] = 1e6; }, session);           // out of range
  send([](P p) { p.sequence = 1ull << 40; }, session);     // out of range, by the gate
  send([](P p) { p.value_count = 3; }, session);           // wrong count
  ASSERT_TRUE(eventually([&] { return server.statistics(0).packets_received == 8; }));
  const LinkSnapshot t = server.statistics(0);
  EXPECT_EQ(t.by_reason.of(Decode::kOk), 1u);
  EXPECT_EQ(t.by_reason.of(Decode::kDuplicate), 1u);
  EXPECT_EQ(t.by_reason.of(Decode::kStaleSequence), 1u);
  EXPECT_EQ(t.by_reason.of(Decode::kWrongSession), 1u);
  EXPECT_EQ(t.by_reason.of(Decode::kNotFinite), 1u);
  EXPECT_EQ(t.by_reason.of(Decode::kOutOfRange), 2u);
  EXPECT_EQ(t.by_reason.of(Decode::kWrongCount), 1u);
  EXPECT_EQ(t.accepted, 1u);
  PeerSample sample;
  ASSERT_TRUE(server.inbox(0).fetch(sample));
  EXPECT_EQ(sample.packet.sequence, 5u);
  EXPECT_FALSE(server.inbox(0).fetch(sample));
}

}  // namespace
}  // namespace tandem::net
