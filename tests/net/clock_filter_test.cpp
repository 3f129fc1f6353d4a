#include "net/clock_filter.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <random>

#include <gtest/gtest.h>

namespace tandem::net {
namespace {

constexpr std::int64_t kMs = 1'000'000;
constexpr std::int64_t kPeriod = 7'812'500;  // 128 Hz

/// Two clocks and the path between them, with the truth known: true time is ours, the peer's clock
/// is offset + (1 + skew) t. Both send once a period, the peer half a period later.
struct Path {
  std::int64_t offset = -123'456'789'012;
  double skew = 0.0;
  std::int64_t forth = 300'000, back = 300'000;  // fixed delays [ns]
  double jitter = 0.0;                           // mean of the exponential part [ns]
  std::mt19937_64 random{3};
  std::int64_t now = 5'000 * kMs;

  std::int64_t peer_clock(std::int64_t t) const {
    return t + offset + static_cast<std::int64_t>(skew * static_cast<double>(t - 5'000 * kMs));
  }
  std::int64_t extra() {
    const double u = (static_cast<double>(random() >> 11) + 0.5) * 0x1p-53;
    return static_cast<std::int64_t>(-jitter * std::log(u));
  }
  ClockStamps exchange() {
    ClockStamps s;
    s.echo_ns = now;
    const std::int64_t t2 = now + forth + extra();
    const std::int64_t t3 = t2 + kPeriod / 2;
    s.echo_hold_ns = peer_clock(t3) - peer_clock(t2);
    s.send_ns = peer_clock(t3);
    s.arrival_ns = t3 + back + extra();
    true_age = s.arrival_ns - t3;
    now += kPeriod;
    return s;
  }
  std::int64_t true_offset(std::int64_t t) const { return peer_clock(t) - t; }
  std::int64_t true_age = 0;
};

TEST(ClockFilter, IsExactOnASymmetricPathFromTheFirstExchange) {
  Path path;
  ClockFilter filter;
  EXPECT_FALSE(filter.valid());
  EXPECT_EQ(filter.age_ns(1, 2), 0);
  const auto s = path.exchange();
  EXPECT_EQ(filter.update(s), ClockAnswer::kUsed);
  EXPECT_EQ(filter.offset_ns(), path.offset);
  EXPECT_EQ(filter.age_ns(s.send_ns, s.arrival_ns), 300'000);
  EXPECT_EQ(filter.round_trip_ns(), 600'000);
}

TEST(ClockFilter, WithoutAnEchoNothingIsKnown) {
  ClockFilter filter;
  EXPECT_EQ(filter.update({.send_ns = 5, .arrival_ns = 7}), ClockAnswer::kNoEcho);
  EXPECT_FALSE(filter.valid());
}

// The bound must hold at every exchange, on every path, with skew: that is what "hard" means.
TEST(ClockFilter, TheErrorNeverLeavesTheBoundWhateverAsymmetryJitterAndSkew) {
  for (const double skew : {-100e-6, 0.0, 100e-6})
    for (const std::int64_t back : {50'000ll, 300'000ll, 5'000'000ll})
      for (const double jitter : {0.0, 100e3, 2e6}) {
        Path path;
        path.skew = skew;
        path.back = back;
        path.jitter = jitter;
        ClockFilter filter;
        for (int i = 0; i < 20'000; ++i) {
          const auto s = path.exchange();
          ASSERT_EQ(filter.update(s), ClockAnswer::kUsed) << i;
          const auto error = filter.offset_ns() - path.true_offset(s.arrival_ns);
          ASSERT_LE(std::abs(error), filter.bound_ns(s.arrival_ns))
              << "exchange " << i << " skew " << skew << " back " << back << " jitter " << jitter;
          const auto later = s.arrival_ns + 3 * kPeriod;
          ASSERT_LE(std::abs(filter.offset_ns() - path.true_offset(later)), filter.bound_ns(later));
        }
      }
}

// Asymmetry of 2 ms: the error is exactly half of it, inside the bound, and no filter can do
// better.
TEST(ClockFilter, AsymmetryIsHalfOfItselfAsErrorAndCoveredByTheBound) {
  Path path;
  path.back = path.forth + 2 * kMs;
  ClockFilter filter;
  ClockStamps s;
  for (int i = 0; i < 100; ++i) filter.update(s = path.exchange());
  const auto error = filter.offset_ns() - path.true_offset(s.arrival_ns);
  EXPECT_EQ(error, -1 * kMs);
  EXPECT_LE(kMs, filter.bound_ns(s.arrival_ns));
  // round trip 2.6 ms: half is 1.3 ms, plus 300 ppm of a period and a round trip: 2 us
  EXPECT_NEAR(static_cast<double>(filter.bound_ns(s.arrival_ns)), 1.3e6, 3e3);
}

TEST(ClockFilter, AKnownLeastDelayTightensTheBoundByIt) {
  Path path;
  path.jitter = 200e3;
  ClockFilter loose, tight({.min_one_way = 300'000});
  ClockStamps s;
  for (int i = 0; i < 200; ++i) {
    s = path.exchange();
    loose.update(s);
    tight.update(s);
    ASSERT_LE(std::abs(tight.offset_ns() - path.true_offset(s.arrival_ns)),
              tight.bound_ns(s.arrival_ns));
  }
  EXPECT_NEAR(static_cast<double>(loose.bound_ns(s.arrival_ns) - tight.bound_ns(s.arrival_ns)),
              300e3, 2.0);  // 2 ns: rounding up of both
}

// 100 ppm for 5 minutes is 30 ms; exponential jitter of 0.5 ms a direction. The spec of the
// reference analysis is 0.2 ms after the start; slewing at 500 ppm follows 100 ppm and averages the
// jitter.
TEST(ClockFilter, FollowsSkewWithinAFifthOfAMillisecondUnderJitter) {
  for (const double skew : {-100e-6, 100e-6}) {
    Path path;
    path.skew = skew;
    path.jitter = 0.5e6;
    ClockFilter filter;
    double worst = 0.0;
    for (int i = 0; i < 5 * 60 * 128; ++i) {
      const auto s = path.exchange();
      filter.update(s);
      if (i > 1280)  // 10 s: the start may be wrong by its bound and slews in
        worst = std::max(worst, std::abs(static_cast<double>(filter.offset_ns() -
                                                             path.true_offset(s.arrival_ns))));
    }
    EXPECT_LT(worst, 0.2e6) << "skew " << skew;
    EXPECT_EQ(filter.restarts(), 0u);
    RecordProperty(skew < 0 ? "worst_ns_minus" : "worst_ns_plus", std::to_string(worst));
  }
}

TEST(ClockFilter, AfterTheStartItSlewsAndNeverSteps) {
  Path path;
  path.jitter = 1e6;
  ClockFilter filter;
  std::int64_t before = 0, before_at = 0;
  for (int i = 0; i < 10'000; ++i) {
    const auto s = path.exchange();
    filter.update(s);
    // 500 ppm of the time passed, of which a pause counts 100 ms, and a nanosecond of rounding.
    const auto passed = std::clamp<std::int64_t>(s.arrival_ns - before_at, 0, 100 * kMs);
    if (i >= 8) {
      ASSERT_LE(std::abs(static_cast<double>(filter.offset_ns() - before)),
                500e-6 * static_cast<double>(passed) + 1.0)
          << i;
    }
    before = filter.offset_ns();
    before_at = std::max(before_at, s.arrival_ns);
    if (i == 5000) path.now += 10'000 * kMs;  // an outage gives no right to step
  }
}

TEST(ClockFilter, AJumpOfThePeersClockRestartsItAtOnceAndAgesStaySane) {
  for (const std::int64_t jump : {1'000 * kMs, -1'000 * kMs}) {
    Path path;
    path.jitter = 100e3;
    ClockFilter filter;
    for (int i = 0; i < 200; ++i) filter.update(path.exchange());
    path.offset += jump;
    const auto s = path.exchange();
    EXPECT_EQ(filter.update(s), ClockAnswer::kRestarted);
    EXPECT_LE(std::abs(filter.age_ns(s.send_ns, s.arrival_ns) - path.true_age),
              filter.bound_ns(s.arrival_ns));
    for (int i = 0; i < 200; ++i) EXPECT_EQ(filter.update(path.exchange()), ClockAnswer::kUsed);
    EXPECT_EQ(filter.restarts(), 1u);
  }
}

TEST(ClockFilter, AJumpWhileThePeerHoldsOurStampIsNotBelieved) {
  Path path;
  ClockFilter filter;
  for (int i = 0; i < 20; ++i) filter.update(path.exchange());
  const auto before = filter.offset_ns();
  auto s = path.exchange();
  s.echo_hold_ns += 1'000 * kMs;
  s.send_ns += 1'000 * kMs;
  EXPECT_EQ(filter.update(s), ClockAnswer::kImpossible);
  EXPECT_EQ(filter.offset_ns(), before);
  EXPECT_EQ(filter.age_ns(s.send_ns, s.arrival_ns), 0);  // from the future: never negative
}

TEST(ClockFilter, AbsurdStampsWithinTheCodecsLimitsDoNotOverflow) {
  const std::int64_t top = (1ll << 62) - 1;
  std::mt19937_64 random(1);
  ClockFilter filter;
  for (int i = 0; i < 100'000; ++i) {
    const auto any = [&] {
      const std::int64_t choices[] = {0, 1, top, static_cast<std::int64_t>(random() >> 2)};
      return choices[random() % 4];
    };
    const ClockStamps s{
        .echo_ns = any(), .echo_hold_ns = any(), .send_ns = any(), .arrival_ns = any()};
    (void)filter.update(s);
    ASSERT_GE(filter.age_ns(s.send_ns, s.arrival_ns), 0);
  }
}

}  // namespace
}  // namespace tandem::net
