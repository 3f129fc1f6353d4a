#pragma once

#include <cstdint>

namespace tandem::test {

/// Calls of operator new in this program so far, all threads (allocation_counter.cpp).
[[nodiscard]] std::uint64_t allocation_count() noexcept;

}  // namespace tandem::test
