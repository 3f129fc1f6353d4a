#pragma once

#include <cmath>
#include <cstdint>

#include "core/elementary.h"

namespace tandem::core {

/// Seeded numbers whose bits do not depend on a library: splitmix64 (Steele, Lea, Flood 2014), and
/// distributions made by hand. Trivially copyable, so a copied loop repeats the same fates.
class Random {
 public:
  explicit Random(std::uint64_t seed = 1) noexcept : state_(seed) {}

  [[nodiscard]] std::uint64_t bits() noexcept {
    std::uint64_t z = (state_ += 0x9e3779b97f4a7c15u);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
  }

  /// Uniform in [0, 1), 53 bits.
  [[nodiscard]] double uniform() noexcept { return static_cast<double>(bits() >> 11) * 0x1p-53; }

  /// Uniform in [low, high).
  [[nodiscard]] double uniform(double low, double high) noexcept {
    return low + (high - low) * uniform();
  }

  /// Exponential with the given mean.
  [[nodiscard]] double exponential(double mean) noexcept {
    return -mean * natural_log(1.0 - uniform());
  }

  /// Standard normal, by Marsaglia's polar method; the second number of each pair is dropped so
  /// that the state is one word.
  [[nodiscard]] double normal() noexcept {
    for (;;) {
      const double x = uniform(-1.0, 1.0), y = uniform(-1.0, 1.0);
      const double s = x * x + y * y;
      if (s > 0.0 && s < 1.0) return x * std::sqrt(-2.0 * natural_log(s) / s);
    }
  }

 private:
  std::uint64_t state_;
};

}  // namespace tandem::core
