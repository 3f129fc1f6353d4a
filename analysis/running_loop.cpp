// Growth and drag of the loop that a scene declares, compiled once.
#include "analysis/drag.h"
#include "analysis/growth.h"
#include "analysis/with_loop.h"

namespace tandem::analysis {

Growth measure_growth(const core::Scene& scene, const core::NetworkModel& network,
                      const GrowthOptions& options) {
  return with_loop(scene, network, [&](auto& loop) { return measure_growth(loop, options); });
}

Drag measure_drag(const core::Scene& scene, const core::NetworkModel& network, int user) {
  if (scene.space != core::Space::kAxis)
    throw std::domain_error("field space: drag is measured of a hand on an AXIS");
  return with_loop_of<core::AxisWorld>(
      scene, network, [&](auto& loop) { return measure_drag(loop, user, scene.tick()); });
}

}  // namespace tandem::analysis
