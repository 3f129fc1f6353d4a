#include "core/allocation_counter.h"

#include <cstdlib>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

namespace tandem::core {
namespace {

/// Keeps the compiler from removing an allocation whose result nobody reads.
void keep(void* memory) { asm volatile("" : : "g"(memory) : "memory"); }

TEST(AllocationCounter, TheHookIsLinkedIntoThisProgram) { EXPECT_TRUE(allocation_hook_linked()); }

TEST(AllocationCounter, CountsEachOperatorNewOfAMarkedThread) {
  const std::uint64_t before = counted_allocations();
  {
    const CountAllocations marked;
    for (int i = 0; i < 10; ++i) {
      const auto memory = std::make_unique<double[]>(32);
      keep(memory.get());
    }
  }
  EXPECT_EQ(counted_allocations() - before, 10u);
}

TEST(AllocationCounter, CountsOverAlignedAndArrayForms) {
  struct alignas(256) Wide {
    char bytes[256];
  };
  const std::uint64_t before = counted_allocations();
  {
    const CountAllocations marked;
    const auto one = std::make_unique<Wide>();
    keep(one.get());
    const auto many = std::make_unique<Wide[]>(3);
    keep(many.get());
  }
  EXPECT_EQ(counted_allocations() - before, 2u);
}

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
TEST(AllocationCounter, CountsMallocOfCCodeToo) {
  const std::uint64_t before = counted_allocations();
  {
    const CountAllocations marked;
    void* memory = std::malloc(100);
    keep(memory);
    memory = std::realloc(memory, 100'000);
    keep(memory);
    std::free(memory);
    memory = std::calloc(10, 10);
    keep(memory);
    std::free(memory);
    ASSERT_EQ(posix_memalign(&memory, 64, 1000), 0);
    keep(memory);
    std::free(memory);
  }
  EXPECT_EQ(counted_allocations() - before, 4u);
}
#endif

TEST(AllocationCounter, DoesNotCountUnmarkedCodeOrOtherThreads) {
  const std::uint64_t before = counted_allocations();
  keep(std::make_unique<int>(1).get());
  std::uint64_t at_end_of_marked = 0;
  std::thread unmarked([&] {
    for (int i = 0; i < 1000; ++i) keep(std::make_unique<int>(i).get());
  });
  {
    const CountAllocations marked;
    volatile double sum = 0.0;
    for (int i = 0; i < 100'000; ++i) sum = sum + i;
    at_end_of_marked = counted_allocations();
  }
  unmarked.join();
  EXPECT_EQ(at_end_of_marked - before, 0u);
  EXPECT_EQ(counted_allocations() - before, 0u);
}

TEST(AllocationCounter, NestedMarksEndWithTheOuterOne) {
  const std::uint64_t before = counted_allocations();
  {
    const CountAllocations outer;
    { const CountAllocations inner; }
    keep(std::make_unique<int>(1).get());
  }
  keep(std::make_unique<int>(1).get());
  EXPECT_EQ(counted_allocations() - before, 1u);
}

}  // namespace
}  // namespace tandem::core
