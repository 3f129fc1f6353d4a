#pragma once

#include <bit>
#include <cstdint>

namespace tandem::core {

struct SinCos {
  double sin = 0.0;
  double cos = 1.0;
};

/// Sine and cosine of an angle [rad] from arithmetic alone, so that a law's bits do not hang on the
/// C library of the machine. Below one unit in the last place for |angle| < 1e5; beyond, the
/// reduction loses about one digit a decade. Not finite in: not finite out.
///
/// pi/2 is subtracted in three parts of 33, 33 and 53 bits (products with the quadrant number are
/// exact), then the polynomials of fdlibm's k_sin.c and k_cos.c (Sun Microsystems, 1993) are
/// evaluated on [-pi/4, pi/4] with the low part of the reduced angle.
[[nodiscard]] inline SinCos sin_cos(double angle) noexcept {
  constexpr double kTwoOverPi = 6.36619772367581382433e-01;
  constexpr double kPiOver2High = 1.57079632673412561417e+00;
  constexpr double kPiOver2Middle = 6.07710050630396597660e-11;
  constexpr double kPiOver2Low = 2.02226624879595063154e-21;
  constexpr double kRound = 0x1.8p52;  // adding it rounds to a whole number, in the low bits

  const double shifted = angle * kTwoOverPi + kRound;
  const double n = shifted - kRound;
  const auto quadrant = std::bit_cast<std::uint64_t>(shifted) & 3u;

  const double first = angle - n * kPiOver2High;
  const double middle = n * kPiOver2Middle;
  const double second = first - middle;
  const double lost = n * kPiOver2Low - ((first - second) - middle);
  const double x = second - lost;
  const double tail = (second - x) - lost;

  const double z = x * x;
  const double s_poly =
      8.33333333332248946124e-03 +
      z * (-1.98412698298579493134e-04 +
           z * (2.75573137070700676789e-06 +
                z * (-2.50507602534068634195e-08 + z * 1.58969099521155010221e-10)));
  const double cube = z * x;
  const double sine =
      x - ((z * (0.5 * tail - cube * s_poly) - tail) - cube * -1.66666666666666324348e-01);

  const double c_poly =
      z * (4.16666666666666019037e-02 +
           z * (-1.38888888888741095749e-03 +
                z * (2.48015872894767294178e-05 +
                     z * (-2.75573143513906633035e-07 +
                          z * (2.08757232129817482790e-09 + z * -1.13596475577881948265e-11)))));
  const double half = 0.5 * z;
  const double one_less = 1.0 - half;
  const double cosine = one_less + (((1.0 - one_less) - half) + (z * c_poly - x * tail));

  // Quadrants 0..3: (s, c), (c, -s), (-s, -c), (-c, s); signs flipped by bit, without branches.
  const double a = (quadrant & 1u) ? cosine : sine;
  const double b = (quadrant & 1u) ? sine : cosine;
  const std::uint64_t sin_sign = (quadrant & 2u) << 62;
  const std::uint64_t cos_sign = ((quadrant + 1u) & 2u) << 62;
  return {std::bit_cast<double>(std::bit_cast<std::uint64_t>(a) ^ sin_sign),
          std::bit_cast<double>(std::bit_cast<std::uint64_t>(b) ^ cos_sign)};
}

}  // namespace tandem::core
