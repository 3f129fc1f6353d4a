#include <atomic>
#include <cstdint>
#include <memory>
#include <thread>

#include <gtest/gtest.h>

#include "core/latest_value.h"
#include "core/spsc_ring.h"
#include "tests/realtime/checksummed_payload.h"

namespace tandem::core {
namespace {

using test::ChecksummedPayload;
using test::intact;
using test::payload;

TEST(LatestValue, NothingIsFetchedBeforeTheFirstPublish) {
  LatestValue<int> value;
  int out = 17;
  EXPECT_FALSE(value.fetch(out));
  EXPECT_EQ(out, 17);
}

TEST(LatestValue, OnlyTheNewestOfSeveralPublishesIsFetchedAndOnlyOnce) {
  LatestValue<int> value;
  int out = 0;
  for (int round = 0; round < 10; ++round) {
    for (int i = 0; i < 5; ++i) value.publish(10 * round + i);
    ASSERT_TRUE(value.fetch(out));
    EXPECT_EQ(out, 10 * round + 4);
    EXPECT_FALSE(value.fetch(out));
  }
}

// The writer publishes 1, 2, 3, ... as fast as it can: whatever the reader sees must be whole,
// newer than what it saw before, and the last value must arrive.
TEST(LatestValueTwoThreads, NoValueIsTornOldOrLostAtTheEnd) {
  constexpr std::uint64_t kPublishes = 200'000;
  LatestValue<ChecksummedPayload> value;
  std::atomic<bool> done{false};
  std::thread writer([&] {
    for (std::uint64_t n = 1; n <= kPublishes; ++n) value.publish(payload(n));
    done = true;
  });
  std::uint64_t last = 0, torn = 0, backwards = 0;
  bool finished = false;
  while (true) {
    ChecksummedPayload seen;
    if (value.fetch(seen)) {
      if (!intact(seen)) ++torn;
      if (seen.number <= last) ++backwards;
      last = seen.number;
    } else if (finished) {
      break;
    } else {
      finished = done;  // one more fetch after the writer ended
    }
  }
  writer.join();
  EXPECT_EQ(torn, 0u);
  EXPECT_EQ(backwards, 0u);
  EXPECT_EQ(last, kPublishes);
}

TEST(SpscRing, GivesBackWhatWasPushedInOrder) {
  SpscRing<int, 8> ring;
  int out = -1;
  EXPECT_FALSE(ring.pop(out));
  EXPECT_EQ(out, -1);
  int pushed = 0, popped = 0;
  for (int round = 0; round < 20; ++round) {  // goes round the eight slots many times
    for (int i = 0; i < 5; ++i) ASSERT_TRUE(ring.push(pushed++));
    for (int i = 0; i < 5; ++i) {
      ASSERT_TRUE(ring.pop(out));
      EXPECT_EQ(out, popped++);
    }
    EXPECT_FALSE(ring.pop(out));
  }
  EXPECT_EQ(ring.dropped(), 0u);
}

TEST(SpscRing, DropsAndCountsTheNewestWhenFull) {
  SpscRing<int, 4> ring;
  for (int i = 0; i < 4; ++i) EXPECT_TRUE(ring.push(i));
  EXPECT_FALSE(ring.push(4));
  EXPECT_FALSE(ring.push(5));
  EXPECT_EQ(ring.dropped(), 2u);
  int out = -1;
  for (int i = 0; i < 4; ++i) {
    ASSERT_TRUE(ring.pop(out));
    EXPECT_EQ(out, i);
  }
  EXPECT_FALSE(ring.pop(out));
  EXPECT_TRUE(ring.push(6));  // room again
  ASSERT_TRUE(ring.pop(out));
  EXPECT_EQ(out, 6);
  EXPECT_EQ(ring.dropped(), 2u);
}

// A ring of 64 and a writer that never waits: every number either arrives, whole and in order, or
// is counted as dropped. Received + dropped = pushed.
TEST(SpscRingTwoThreads, EveryValueArrivesWholeAndInOrderOrIsCounted) {
  constexpr std::uint64_t kPushes = 200'000;
  SpscRing<ChecksummedPayload, 64> ring;
  std::atomic<bool> done{false};
  std::thread writer([&] {
    for (std::uint64_t n = 1; n <= kPushes; ++n) ring.push(payload(n));
    done = true;
  });
  std::uint64_t last = 0, received = 0, torn = 0, backwards = 0;
  bool finished = false;
  while (true) {
    ChecksummedPayload seen;
    if (ring.pop(seen)) {
      ++received;
      if (!intact(seen)) ++torn;
      if (seen.number <= last) ++backwards;
      last = seen.number;
    } else if (finished) {
      break;
    } else {
      finished = done;
    }
  }
  writer.join();
  EXPECT_EQ(torn, 0u);
  EXPECT_EQ(backwards, 0u);
  EXPECT_GT(received, 0u);
  EXPECT_EQ(received + ring.dropped(), kPushes);
}

}  // namespace
}  // namespace tandem::core
