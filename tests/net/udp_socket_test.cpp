#include "net/udp_socket.h"

#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>

#include "net/loopback_link.h"
#include "tests/net/allocation_counter.h"

namespace tandem::net {
namespace {

const std::vector<std::uint8_t> kHello{'h', 'e', 'l', 'l', 'o'};

std::string error_of(const auto& action) {
  try {
    action();
  } catch (const std::exception& e) {
    return e.what();
  }
  return "no error";
}

TEST(UdpLink, CarriesDatagramsAndSaysWhereTheyCameFrom) {
  UdpLink a("127.0.0.1:0"), b("127.0.0.1:0");
  std::array<std::uint8_t, 100> buffer;
  Endpoint from;
  EXPECT_FALSE(b.receive(from, buffer));
  ASSERT_TRUE(a.send(b.local(), kHello));
  ASSERT_TRUE(a.send(b.local(), {}));
  b.wait(1'000'000'000);
  EXPECT_EQ(b.receive(from, buffer), kHello.size());
  EXPECT_EQ(from, a.local());
  EXPECT_TRUE(std::equal(kHello.begin(), kHello.end(), buffer.begin()));
  b.wait(1'000'000'000);
  EXPECT_EQ(b.receive(from, buffer), 0u);  // an empty datagram is a datagram
  EXPECT_FALSE(b.receive(from, buffer));
}

TEST(UdpLink, WorksOverIPv6) {
  std::unique_ptr<UdpLink> a, b;
  try {
    a = std::make_unique<UdpLink>("[::1]:0");
    b = std::make_unique<UdpLink>("[::1]:0");
  } catch (const std::exception& e) {
    GTEST_SKIP() << "no IPv6 here: " << e.what();
  }
  ASSERT_TRUE(a->send(b->local(), kHello));
  b->wait(1'000'000'000);
  std::array<std::uint8_t, 100> buffer;
  Endpoint from;
  EXPECT_EQ(b->receive(from, buffer), kHello.size());
  EXPECT_EQ(from, a->local());
  EXPECT_EQ(to_string(from).substr(0, 6), "[::1]:");
}

TEST(UdpLink, SendingAndReceivingAllocatesNothing) {
  UdpLink a("127.0.0.1:0"), b("127.0.0.1:0");
  std::array<std::uint8_t, 100> buffer;
  Endpoint from;
  const auto before = test::allocation_count();
  for (int i = 0; i < 1000; ++i) {
    ASSERT_TRUE(a.send(b.local(), kHello));
    b.wait(1'000'000'000);
    ASSERT_TRUE(b.receive(from, buffer));
  }
  EXPECT_EQ(test::allocation_count() - before, 0u);
}

TEST(UdpLink, ErrorsSayWhatIsWrongAndWhatToDo) {
  UdpLink taken("127.0.0.1:0");
  const std::string same = to_string(taken.local());
  EXPECT_NE(error_of([&] { UdpLink again(same); }).find("in use"), std::string::npos);
  // 192.0.2.0/24 is reserved for documentation (RFC 5737): never an address of this machine.
  EXPECT_NE(error_of([&] { UdpLink b("192.0.2.1:0"); }).find("not an address of this machine"),
            std::string::npos);
  // ".invalid" never resolves (RFC 6761); a label over 63 characters fails without a name server.
  const std::string name(70, 'x');
  EXPECT_NE(error_of([&] { UdpLink b(name + ":0"); }).find("cannot be resolved"),
            std::string::npos);
  EXPECT_NE(error_of([&] { (void)taken.resolve(name + ":7000"); }).find("cannot be resolved"),
            std::string::npos);
  EXPECT_NE(error_of([&] { (void)taken.resolve("127.0.0.1:0"); }).find("port 0"),
            std::string::npos);
}

TEST(UdpLink, ResolvesNamesAndNumbers) {
  UdpLink link("127.0.0.1:0");
  EXPECT_EQ(to_string(link.resolve("127.0.0.1:7000")), "127.0.0.1:7000");
  EXPECT_EQ(to_string(link.resolve("localhost:7000")), "127.0.0.1:7000");
}

TEST(HostPort, MisspeltAddressesAreRefusedWithTheReason) {
  EXPECT_NE(error_of([] { (void)parse_host_port("host"); }).find("port is missing"),
            std::string::npos);
  EXPECT_NE(error_of([] { (void)parse_host_port(":7"); }).find("host is missing"),
            std::string::npos);
  for (const char* bad : {"h:", "h:x", "h:70000", "h:-1", "h:7 "})
    EXPECT_NE(error_of([&] { (void)parse_host_port(bad); }).find("not a number"), std::string::npos)
        << bad;
  EXPECT_NE(error_of([] { (void)parse_host_port("::1:7"); }).find("brackets"), std::string::npos);
  EXPECT_EQ(parse_host_port("[::1]:7").host, "::1");
  EXPECT_EQ(parse_host_port("a.b:65535").port, 65535);
}

TEST(LoopbackLink, DeliversLosesAndDuplicatesAsToldTo) {
  int count = 0;
  LoopbackNetwork network([&](auto&&...) { return count++ % 3; });  // lost, once, twice
  auto a = network.open(1), b = network.open(2);
  for (int i = 0; i < 3; ++i) a->send(b->local(), kHello);
  std::array<std::uint8_t, 100> buffer;
  Endpoint from;
  int arrived = 0;
  while (b->receive(from, buffer)) ++arrived;
  EXPECT_EQ(arrived, 3);
  EXPECT_EQ(from, a->local());
}

}  // namespace
}  // namespace tandem::net
