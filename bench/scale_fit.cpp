#include "bench/scale_fit.h"

#include <algorithm>
#include <cmath>

namespace tandem::bench {

namespace {

constexpr double kReach = 100.0;  // a law says nothing about what is this many times further

}  // namespace

PowerLaw fit_power_law(const std::vector<ScalePoint>& points, double from) {
  double count = 0.0, sx = 0.0, sy = 0.0, sxx = 0.0, sxy = 0.0;
  for (const ScalePoint& p : points) {
    if (p.n < from || !(p.y > 0.0)) continue;
    const double x = std::log(p.n), y = std::log(p.y);
    count += 1.0, sx += x, sy += y, sxx += x * x, sxy += x * y;
  }
  PowerLaw law;
  law.points = static_cast<int>(count);
  const double determinant = count * sxx - sx * sx;
  if (count < 2.0 || !(determinant > 1e-12 * count * sxx)) return law;
  law.exponent = (count * sxy - sx * sy) / determinant;
  law.factor = std::exp((sy - law.exponent * sx) / count);
  for (const ScalePoint& p : points)
    if (p.n >= from && p.y > 0.0)
      law.spread =
          std::max(law.spread, std::abs(p.y / (law.factor * std::pow(p.n, law.exponent)) - 1.0));
  return law;
}

Knee find_knee(const std::vector<ScalePoint>& points, const PowerLaw& law, double budget) {
  for (std::size_t i = 0; i < points.size(); ++i) {
    const ScalePoint& p = points[i];
    if (p.y < budget) continue;
    if (i == 0) return {p.n, true};
    const ScalePoint& q = points[i - 1];
    const double part = std::log(budget / q.y) / std::log(p.y / q.y);
    return {q.n * std::pow(p.n / q.n, part), true};
  }
  if (points.empty() || !(law.exponent > 0.0) || !(law.factor > 0.0)) return {};
  const double last = points.back().n;
  const double n = std::max(last, std::pow(budget / law.factor, 1.0 / law.exponent));
  return n > kReach * last ? Knee{} : Knee{n, false};
}

}  // namespace tandem::bench
