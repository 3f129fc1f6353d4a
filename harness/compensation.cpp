#include "harness/compensation.h"

#include <cmath>

#include "harness/prediction.h"

namespace tandem::harness {

double tuned_compensation(core::Scene scene, const LinkConditions& conditions) {
  FateStore fates;
  const core::NetworkModel network =
      steady_network(scene, modelled_network(conditions, scene, 1, fates));
  const auto drag = [&](double compensation) {
    for (auto& object : scene.objects) object.compensation = compensation;
    return predicted_drag(scene, network);
  };
  const double uncompensated = drag(0.0);
  if (!(uncompensated > 1e-9)) return 0.0;
  const double wanted = kDragLeft * uncompensated;
  // Nearly linear: a few secants.
  double c0 = 0.0, b0 = uncompensated;
  double c1 = 0.5 * uncompensated, b1 = drag(c1);
  for (int i = 0; i < 8 && std::abs(b1 - wanted) > 1e-9 * uncompensated && b1 != b0; ++i) {
    const double c = c1 + (wanted - b1) * (c1 - c0) / (b1 - b0);
    c0 = c1, b0 = b1;
    c1 = c, b1 = drag(c);
  }
  return std::isfinite(c1) && c1 > 0.0 ? c1 : 0.0;
}

}  // namespace tandem::harness
