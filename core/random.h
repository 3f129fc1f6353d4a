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

  /// netem's table `pareto` (iproute2): 4/3 (u^(-1/3) - 3/2), cut at 4.
  [[nodiscard]] double netem_pareto() noexcept { return pareto_at(1.0 - uniform()); }

  /// netem's table `paretonormal`: a quarter of the normal, three of the Pareto quantile, of one
  /// number, cut at 4.
  [[nodiscard]] double netem_pareto_normal() noexcept {
    const double u = uniform() + 0x1p-54;
    const double x = 0.25 * normal_quantile(u) + 0.75 * pareto_at(1.0 - u);
    return x < 4.0 ? x : 4.0;
  }

 private:
  [[nodiscard]] static double pareto_at(double u) noexcept {
    const double x = 4.0 / 3.0 * (natural_exp(natural_log(u) * (-1.0 / 3.0)) - 1.5);
    return x < 4.0 ? x : 4.0;
  }

  /// Inverse of the normal distribution for 0 < p < 1, absolute error below 4.5e-4 (Hastings 1955,
  /// 26.2.23 in Abramowitz and Stegun), cut at +-4 as netem's table is.
  [[nodiscard]] static double normal_quantile(double p) noexcept {
    const double tail = p < 0.5 ? p : 1.0 - p;
    const double t = std::sqrt(-2.0 * natural_log(tail));
    double x = t - (2.515517 + t * (0.802853 + t * 0.010328)) /
                       (1.0 + t * (1.432788 + t * (0.189269 + t * 0.001308)));
    if (x > 4.0) x = 4.0;
    return p < 0.5 ? -x : x;
  }

  std::uint64_t state_;
};

}  // namespace tandem::core
