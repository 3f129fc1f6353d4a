#pragma once

#include <algorithm>
#include <cmath>
#include <utility>

/// Zeros and maxima of one number's function, kept in brackets.
namespace tandem::analysis {

/// Zero of `f` between a and b, where f(a) and f(b) differ in sign: secants kept in the bracket
/// (Anderson and Bjorck), halved whenever three of them did not halve it. Returns the last bracket.
template <typename F>
std::pair<double, double> bracket_zero(F&& f, double a, double fa, double b, double fb,
                                       double tolerance) {
  double width = std::abs(b - a);
  for (int i = 0, slow = 0; i < 200; ++i) {
    if (std::abs(b - a) <= tolerance * std::max(std::abs(a), std::abs(b))) break;
    double x = b - fb * (b - a) / (fb - fa);
    const double least = 0.25 * tolerance * std::max(std::abs(a), std::abs(b));
    const double low = std::min(a, b), high = std::max(a, b);
    if (slow >= 3 || !(x > low && x < high)) x = 0.5 * (a + b), slow = 0;
    x = std::clamp(x, low + least, high - least);
    if (!(x > low && x < high)) break;
    const double fx = f(x);
    if ((fx > 0.0) == (fb > 0.0)) {
      const double m = 1.0 - fx / fb;
      fa *= m > 0.0 ? m : 0.5;
    } else {
      a = b, fa = fb;
    }
    b = x, fb = fx;
    if (std::abs(b - a) <= 0.5 * width)
      width = std::abs(b - a), slow = 0;
    else
      ++slow;
  }
  return {a, b};
}

/// Maximum of f in [a, b] by golden section, or the first point found where f > 0.
template <typename F>
std::pair<double, double> climb(F&& f, double a, double b) {
  constexpr double kGolden = 0.6180339887498949;
  double x1 = b - kGolden * (b - a), x2 = a + kGolden * (b - a), f1 = f(x1), f2 = f(x2);
  for (int i = 0; i < 60 && f1 <= 0.0 && f2 <= 0.0; ++i) {
    if (std::abs(b - a) < 1e-13 * std::max(std::abs(a), std::abs(b))) break;
    if (f1 > f2) {
      b = x2, x2 = x1, f2 = f1;
      x1 = b - kGolden * (b - a), f1 = f(x1);
    } else {
      a = x1, x1 = x2, f1 = f2;
      x2 = a + kGolden * (b - a), f2 = f(x2);
    }
  }
  return f1 > f2 ? std::pair{x1, f1} : std::pair{x2, f2};
}

/// Zero of `f` between a and b, where f(a) and f(b) differ in sign: the parabola through the last
/// three points where it is safe (Chandrupatla 1997), else the middle, always within the bracket.
/// Ends when the next step would be below a twentieth of `tolerance`, relative; the error is of the
/// order of that step's square over the bracket, as f is smooth at its zero.
template <typename F>
double zero_between(F&& f, double a, double fa, double b, double fb, double tolerance) {
  double c = a, fc = fa;
  double t = fa / (fa - fb);
  const double small = 1e-3 * std::max(std::abs(fa), std::abs(fb));
  for (int i = 0; i < 100; ++i) {
    const double x = a + t * (b - a);
    const double enough = 0.05 * tolerance * std::abs(x);
    if (i > 0 && std::abs(x - a) <= enough && std::abs(fa) < small) return x;
    if (std::abs(b - a) <= 2.0 * enough || x == a || x == b) return x;
    const double fx = f(x);
    if (fx == 0.0) return x;
    if ((fx > 0.0) == (fa > 0.0)) {
      c = a, fc = fa;
    } else {
      c = b, fc = fb;
      b = a, fb = fa;
    }
    a = x, fa = fx;
    // a is newest, root between a and b; c beyond one of them.
    const double xi = (a - b) / (c - b), phi = (fa - fb) / (fc - fb);
    if (phi * phi < xi && (1.0 - phi) * (1.0 - phi) < 1.0 - xi)
      t = fa / (fb - fa) * fc / (fb - fc) + (c - a) / (b - a) * fa / (fc - fa) * fb / (fc - fb);
    else
      t = 0.5;
  }
  return 0.5 * (a + b);
}

}  // namespace tandem::analysis
