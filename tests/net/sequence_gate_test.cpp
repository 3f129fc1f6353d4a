#include "core/sequence_gate.h"

#include <random>
#include <set>

#include <gtest/gtest.h>

namespace tandem::core {
namespace {

TEST(SequenceGate, NewestWinsAndLatecomersAreOldOnceAndDuplicateAfter) {
  SequenceGate gate;
  EXPECT_EQ(gate.admit(1), Gate::kAccept);
  EXPECT_EQ(gate.admit(4), Gate::kAccept);
  EXPECT_EQ(gate.lost(), 2u);
  EXPECT_EQ(gate.admit(3), Gate::kOld);
  EXPECT_EQ(gate.admit(3), Gate::kDuplicate);
  EXPECT_EQ(gate.admit(4), Gate::kDuplicate);
  EXPECT_EQ(gate.admit(5), Gate::kAccept);
  EXPECT_EQ(gate.lost(), 1u);
  EXPECT_EQ(gate.counts().accepted, 3u);
  EXPECT_EQ(gate.counts().old, 1u);
  EXPECT_EQ(gate.counts().duplicate, 2u);
}

TEST(SequenceGate, ZeroIsNeverASequenceNumber) {
  SequenceGate gate;
  EXPECT_NE(gate.admit(0), Gate::kAccept);
  EXPECT_EQ(gate.admit(1), Gate::kAccept);
}

TEST(SequenceGate, OneAbsurdNumberDoesNotLockOutThePeer) {
  SequenceGate gate;
  EXPECT_EQ(gate.admit(10), Gate::kAccept);
  EXPECT_EQ(gate.admit(1ull << 60), Gate::kLeap);
  EXPECT_EQ(gate.admit(11), Gate::kAccept);
}

TEST(SequenceGate, WhoeverStartsToListenLateHasLostNothing) {
  SequenceGate gate;
  EXPECT_EQ(gate.lost(), 0u);
  EXPECT_EQ(gate.admit(50), Gate::kAccept);
  EXPECT_EQ(gate.lost(), 0u);
  EXPECT_EQ(gate.admit(52), Gate::kAccept);
  EXPECT_EQ(gate.lost(), 1u);
  EXPECT_EQ(gate.admit(48), Gate::kOld);
  EXPECT_EQ(gate.lost(), 2u);  // 49 and 51
}

TEST(SequenceGate, ANewSessionStartsAtOneAgainAndKeepsTheCounts) {
  SequenceGate gate;
  EXPECT_EQ(gate.admit(1), Gate::kAccept);
  EXPECT_EQ(gate.admit(1000), Gate::kAccept);
  gate.reset();
  EXPECT_EQ(gate.admit(1), Gate::kAccept);
  EXPECT_EQ(gate.admit(2), Gate::kAccept);
  EXPECT_EQ(gate.counts().accepted, 4u);
  EXPECT_EQ(gate.lost(), 998u);
  gate.reset(true);
  EXPECT_EQ(gate.lost(), 0u);
  EXPECT_EQ(gate.counts().accepted, 0u);
}

// The answer is known from a set of all numbers that arrived, which the gate does not keep.
TEST(SequenceGate, AgreesWithASetOfEverythingThatArrived) {
  SequenceGate gate;
  std::mt19937_64 random(7);
  std::set<std::uint64_t> arrived;
  std::uint64_t newest = 0;
  for (int i = 0; i < 200000; ++i) {
    // Around the newest: mostly ahead, sometimes back within the window, now and then a far jump.
    const std::uint64_t back = random() % 300;
    std::uint64_t sequence = newest + 1 + random() % 3;
    if (random() % 3 == 0) sequence = newest > back ? newest - back : 1;
    if (random() % 1000 == 0) sequence = newest + 1000;
    Gate expected = Gate::kOld;
    if (sequence > newest)
      expected = Gate::kAccept;
    else if (arrived.count(sequence) != 0 || newest - sequence >= SequenceGate::kWindow)
      expected = Gate::kDuplicate;
    ASSERT_EQ(gate.admit(sequence), expected) << "packet " << i << " number " << sequence;
    if (expected != Gate::kDuplicate) arrived.insert(sequence);
    newest = std::max(newest, sequence);
  }
  EXPECT_EQ(gate.lost(), newest - *arrived.begin() + 1 - arrived.size());
}

}  // namespace
}  // namespace tandem::core
