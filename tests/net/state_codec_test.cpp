#include "net/state_codec.h"

#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "tests/net/allocation_counter.h"

namespace tandem::net {
namespace {

constexpr std::uint64_t kSession = 0x1122334455667788;

core::StatePacket sample(int value_count) {
  core::StatePacket p;
  p.sender = 3;
  p.sequence = 41;
  p.slot = 328;
  p.send_ns = 1'000'000'007;
  p.echo_ns = 999'000'001;
  p.echo_hold_ns = 12'345;
  p.contact_bits = 0xF0000321;
  p.energy_in = 0.25;
  p.energy_out = -1.5;
  p.value_count = value_count;
  for (int i = 0; i < value_count; ++i) p.values[static_cast<std::size_t>(i)] = 0.5 * i - 7.0;
  return p;
}

std::vector<std::uint8_t> bytes_of(std::span<const std::uint8_t> datagram) {
  return {datagram.begin(), datagram.end()};
}

struct Codec {
  StateEncoder encoder;
  StateDecoder decoder;
  core::StatePacket out;

  Codec(int value_count = 6) { decoder.expect(3, kSession, value_count); }
  Decode round_trip(const core::StatePacket& p, std::uint64_t session = kSession) {
    return decoder.decode(encoder.encode(p, session), out);
  }
};

void expect_same(const core::StatePacket& a, const core::StatePacket& b) {
  EXPECT_EQ(a.sender, b.sender);
  EXPECT_EQ(a.sequence, b.sequence);
  EXPECT_EQ(a.slot, b.slot);
  EXPECT_EQ(a.send_ns, b.send_ns);
  EXPECT_EQ(a.echo_ns, b.echo_ns);
  EXPECT_EQ(a.echo_hold_ns, b.echo_hold_ns);
  EXPECT_EQ(a.contact_bits, b.contact_bits);
  EXPECT_EQ(a.energy_in, b.energy_in);
  EXPECT_EQ(a.energy_out, b.energy_out);
  ASSERT_EQ(a.value_count, b.value_count);
  EXPECT_EQ(0, std::memcmp(a.values.data(), b.values.data(),
                           sizeof(double) * static_cast<std::size_t>(a.value_count)));
}

TEST(StateCodec, EveryFieldComesBackBitForBit) {
  for (int count : {0, 1, 6, 44, core::kMaxPacketValues}) {
    Codec codec(count);
    const auto p = sample(count);
    ASSERT_EQ(codec.round_trip(p), Decode::kOk) << count;
    expect_same(p, codec.out);
  }
}

TEST(StateCodec, TheServerIsASenderToo) {
  Codec codec;
  codec.decoder.expect(core::kServerSender, kSession, 6);
  auto p = sample(6);
  p.sender = core::kServerSender;
  EXPECT_EQ(codec.round_trip(p), Decode::kOk);
}

// Written by hand from WIRE_FORMAT.md, not by our encoder: the document is enough to interoperate.
TEST(StateCodec, ReadsTheDatagramPrintedInTheFormatDocument) {
  const std::vector<std::uint8_t> datagram{
      'T',  'N',  'D',  'M',  1,    1,    47,   0,           // prefix, 47 bytes follow
      0x09, 0x88, 0x77, 0x66, 0x55, 0x44, 0x33, 0x22, 0x11,  // session
      0x10, 0x03,                                            // sender 3
      0x19, 41,   0,    0,    0,    0,    0,    0,    0,     // sequence 41
      0x29, 0x07, 0xCA, 0x9A, 0x3B, 0,    0,    0,    0,     // send_ns 1 000 000 007
      0x5A, 16,                                              // values, 16 bytes
      0,    0,    0,    0,    0,    0,    0xF0, 0x3F,        // 1.0
      0,    0,    0,    0,    0,    0,    0xE0, 0xBF};       // -0.5
  Codec codec(2);
  ASSERT_EQ(codec.decoder.decode(datagram, codec.out), Decode::kOk);
  EXPECT_EQ(codec.out.sender, 3u);
  EXPECT_EQ(codec.out.sequence, 41u);
  EXPECT_EQ(codec.out.send_ns, 1'000'000'007);
  EXPECT_EQ(codec.out.echo_ns, 0);
  EXPECT_EQ(codec.out.values[0], 1.0);
  EXPECT_EQ(codec.out.values[1], -0.5);
}

TEST(StateCodec, TheLargestDatagramIsTheOneTheDocumentStates) {
  StateEncoder encoder;
  auto p = sample(core::kMaxPacketValues);
  p.sender = core::kServerSender;
  EXPECT_EQ(encoder.encode(p, kSession).size(), kMaxStateDatagram);
  EXPECT_LT(kMaxStateDatagram, kMaxDatagram);
}

TEST(StateCodec, EveryReasonIsGivenAndCounted) {
  Codec codec;
  const auto good = bytes_of(codec.encoder.encode(sample(6), kSession));
  const auto answer_to = [&](auto edit) {
    auto bytes = good;
    edit(bytes);
    return codec.decoder.decode(bytes, codec.out);
  };
  EXPECT_EQ(answer_to([](auto& b) { b[0] = 'X'; }), Decode::kWrongMagic);
  EXPECT_EQ(answer_to([](auto& b) { b[4] = kProtocolVersion + 1; }), Decode::kWrongVersion);
  EXPECT_EQ(answer_to([](auto& b) { b.clear(); }), Decode::kMalformed);
  EXPECT_EQ(answer_to([](auto& b) { b[5] = 2; }), Decode::kMalformed);
  EXPECT_EQ(answer_to([](auto& b) { b[8] = 0xFF; }), Decode::kMalformed);
  EXPECT_EQ(answer_to([](auto& b) { b.resize(kMaxDatagram + 1); }), Decode::kMalformed);
  EXPECT_EQ(codec.round_trip(sample(6), kSession + 1), Decode::kWrongSession);
  EXPECT_EQ(codec.round_trip(sample(5)), Decode::kWrongCount);

  const auto answer_with = [&](auto edit) {
    auto p = sample(6);
    edit(p);
    return codec.round_trip(p);
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  using P = core::StatePacket&;
  EXPECT_EQ(answer_with([](P p) { p.sender = 4; }), Decode::kUnknownSender);
  EXPECT_EQ(answer_with([](P p) { p.sender = 70000; }), Decode::kUnknownSender);
  EXPECT_EQ(answer_with([&](P p) { p.values[5] = nan; }), Decode::kNotFinite);
  EXPECT_EQ(answer_with([&](P p) { p.values[0] = -inf; }), Decode::kNotFinite);
  EXPECT_EQ(answer_with([&](P p) { p.energy_in = inf; }), Decode::kNotFinite);
  EXPECT_EQ(answer_with([](P p) { p.values[2] = -1000.1; }), Decode::kOutOfRange);
  EXPECT_EQ(answer_with([](P p) { p.energy_out = 1e10; }), Decode::kOutOfRange);
  EXPECT_EQ(answer_with([](P p) { p.sequence = 0; }), Decode::kOutOfRange);
  EXPECT_EQ(answer_with([](P p) { p.sequence = ~0ull; }), Decode::kOutOfRange);
  EXPECT_EQ(answer_with([](P p) { p.send_ns = -1; }), Decode::kOutOfRange);
  EXPECT_EQ(answer_with([](P p) { p.echo_hold_ns = 1ll << 62; }), Decode::kOutOfRange);
  codec.decoder.forget(3);
  EXPECT_EQ(codec.decoder.decode(good, codec.out), Decode::kUnknownSender);

  const DecodeCounts& counts = codec.decoder.counts();
  EXPECT_EQ(counts.of(Decode::kOk), 0u);
  EXPECT_EQ(counts.of(Decode::kWrongMagic), 1u);
  EXPECT_EQ(counts.of(Decode::kWrongVersion), 1u);
  EXPECT_EQ(counts.of(Decode::kMalformed), 4u);
  EXPECT_EQ(counts.of(Decode::kWrongSession), 1u);
  EXPECT_EQ(counts.of(Decode::kWrongCount), 1u);
  EXPECT_EQ(counts.of(Decode::kUnknownSender), 3u);
  EXPECT_EQ(counts.of(Decode::kNotFinite), 3u);
  EXPECT_EQ(counts.of(Decode::kOutOfRange), 6u);
  EXPECT_EQ(counts.rejected(), 20u);
}

TEST(StateCodec, ARejectedPacketLeavesTheLastGoodOneUntouched) {
  Codec codec;
  ASSERT_EQ(codec.round_trip(sample(6)), Decode::kOk);
  auto p = sample(6);
  p.sequence = 42;
  p.values[5] = 1e9;
  ASSERT_EQ(codec.round_trip(p), Decode::kOutOfRange);
  expect_same(codec.out, sample(6));
}

TEST(StateCodec, ATruncatedDatagramIsNeverAccepted) {
  Codec codec;
  const auto good = bytes_of(codec.encoder.encode(sample(6), kSession));
  for (std::size_t n = 0; n < good.size(); ++n)
    EXPECT_EQ(codec.decoder.decode({good.data(), n}, codec.out), Decode::kMalformed) << n;
}

TEST(StateCodec, EncodeAndDecodeAllocateNothing) {
  Codec codec(core::kMaxPacketValues);
  const auto p = sample(core::kMaxPacketValues);
  ASSERT_EQ(codec.round_trip(p), Decode::kOk);
  const auto before = test::allocation_count();
  for (int i = 0; i < 10000; ++i) ASSERT_EQ(codec.round_trip(p), Decode::kOk);
  EXPECT_EQ(test::allocation_count() - before, 0u);
}

/// Deterministic source of bad datagrams: pure noise, noise behind a good prefix, and good
/// datagrams with bytes flipped, cut, inserted, doubles overwritten by nasty bit patterns.
class BadDatagrams {
 public:
  explicit BadDatagrams(std::vector<std::uint8_t> good) : good_(std::move(good)) {}

  const std::vector<std::uint8_t>& next() {
    const auto how = random_() % 8;
    if (how == 0) {
      bytes_.resize(random_() % 1500);
      for (auto& b : bytes_) b = byte();
      return bytes_;
    }
    bytes_ = good_;
    if (how == 1) {
      bytes_.resize(kPrefixBytes + random_() % 300);
      for (std::size_t i = kPrefixBytes; i < bytes_.size(); ++i) bytes_[i] = byte();
    } else if (how <= 4) {
      for (auto flips = 1 + random_() % 4; flips > 0; --flips) bytes_[at()] ^= byte();
    } else if (how == 5) {
      bytes_.resize(at());
    } else if (how == 6) {
      bytes_.insert(bytes_.begin() + static_cast<std::ptrdiff_t>(at()), byte());
    } else {
      static constexpr std::uint64_t kNasty[] = {0x7FF0000000000000, 0xFFF8000000000000,
                                                 0x7FEFFFFFFFFFFFFF, 0x0000000000000001,
                                                 0xFFFFFFFFFFFFFFFF, 0x408F400000000001};
      std::size_t i = at();
      if (random_() % 2 == 0) i = bytes_.size() - 8 * (1 + random_() % 6);  // on a value
      for (std::size_t k = 0; k < 8 && i + k < bytes_.size(); ++k)
        bytes_[i + k] = static_cast<std::uint8_t>(kNasty[which()] >> (8 * k));
      which_ = random_() % std::size(kNasty);
    }
    // Half of those whose length changed get a length field that fits: deeper into the parser.
    if (bytes_.size() >= kPrefixBytes && bytes_.size() <= kMaxDatagram && random_() % 2 == 0) {
      bytes_[6] = static_cast<std::uint8_t>(bytes_.size() - kPrefixBytes);
      bytes_[7] = static_cast<std::uint8_t>((bytes_.size() - kPrefixBytes) >> 8);
    }
    return bytes_;
  }

 private:
  std::size_t which() const { return which_; }
  std::uint8_t byte() { return static_cast<std::uint8_t>(random_()); }
  std::size_t at() { return bytes_.empty() ? 0 : random_() % bytes_.size(); }

  std::vector<std::uint8_t> good_, bytes_;
  std::mt19937_64 random_{20061};
  std::size_t which_ = 0;
};

TEST(StateCodec, AMillionRandomAndMutatedPacketsNeverCrashNorBringInAbsurdValues) {
  Codec codec;
  BadDatagrams bad(bytes_of(codec.encoder.encode(sample(6), kSession)));
  std::uint64_t accepted = 0;
  for (int i = 0; i < 1'000'000; ++i) {
    core::StatePacket out;
    if (codec.decoder.decode(bad.next(), out) != Decode::kOk) {
      ASSERT_EQ(out.value_count, 0) << "a rejected packet was written, number " << i;
      continue;
    }
    ++accepted;  // a flipped bit of a position is still a position
    ASSERT_EQ(out.value_count, 6);
    ASSERT_EQ(out.sender, 3u);
    for (int k = 0; k < 6; ++k) {
      const double v = out.values[static_cast<std::size_t>(k)];
      ASSERT_TRUE(v >= -limits::kMaxMagnitude && v <= limits::kMaxMagnitude) << i;
    }
    ASSERT_TRUE(std::isfinite(out.energy_in) && std::isfinite(out.energy_out)) << i;
    ASSERT_GE(out.sequence, 1u);
    ASSERT_GE(out.send_ns, 0);
    ASSERT_GE(out.echo_hold_ns, 0);
  }
  // The generator reached every check, or the test proves nothing.
  for (int reason = 0; reason <= static_cast<int>(Decode::kOutOfRange); ++reason)
    EXPECT_GT(codec.decoder.counts().of(static_cast<Decode>(reason)), 0u)
        << name_of(static_cast<Decode>(reason));
  RecordProperty("accepted", std::to_string(accepted));
}

}  // namespace
}  // namespace tandem::net
