#pragma once

#include <bit>
#include <cstdint>

/// Logarithm and exponential from arithmetic alone, so that a law's bits do not hang on the C
/// library of the machine. (Sine and cosine: core/trigonometry.h. std::sqrt is exactly rounded
/// everywhere and is used as it is.)
namespace tandem::core {

/// ln(x) for positive normal x; relative error below 1e-15 away from x = 1, absolute below 1e-16
/// near it. x <= 0 is the caller's mistake and gives a large negative number, never a trap.
[[nodiscard]] inline double natural_log(double x) noexcept {
  if (!(x > 0.0)) return -1e3;
  auto word = std::bit_cast<std::uint64_t>(x);
  if (word < 0x0010000000000000u) {  // denormal: scale up by 2^54 first
    word = std::bit_cast<std::uint64_t>(x * 0x1p54);
    word -= 54ull << 52;
  }
  int exponent = static_cast<int>(word >> 52) - 1023;
  double m = std::bit_cast<double>((word & 0x000fffffffffffffu) | 0x3ff0000000000000u);
  if (m > 1.4142135623730951) {
    m *= 0.5;
    ++exponent;
  }
  // ln m = 2 atanh(s), s = (m - 1)/(m + 1), |s| <= 0.1716: 11 terms reach 2^-53.
  const double s = (m - 1.0) / (m + 1.0), s2 = s * s;
  double sum = 0.0;
  for (int k = 23; k >= 3; k -= 2) sum = (sum + 1.0 / k) * s2;
  return 2.0 * (s + s * sum) + exponent * 0.69314718055994530942;
}

/// e^x for |x| < 700; relative error below 1e-15.
[[nodiscard]] inline double natural_exp(double x) noexcept {
  if (x < -700.0) return 0.0;
  if (x > 700.0) x = 700.0;
  const double scaled = x * 1.4426950408889634074;
  const auto n = static_cast<int>(scaled < 0.0 ? scaled - 0.5 : scaled + 0.5);
  const double r = (x - n * 0.693147180369123816490) - n * 1.90821492927058770002e-10;
  double sum = 1.0;  // Taylor on |r| <= 0.3466: 14 terms
  for (int k = 14; k >= 1; --k) sum = 1.0 + sum * r / k;
  return sum * std::bit_cast<double>(static_cast<std::uint64_t>(n + 1023) << 52);
}

}  // namespace tandem::core
