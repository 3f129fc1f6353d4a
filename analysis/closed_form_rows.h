#pragma once

#include <string>
#include <vector>

#include "core/scene.h"

namespace tandem::analysis {

/// A closed form of the thesis beside the direct solve of the same damping.
struct ClosedFormRow {
  std::string name;                  ///< "(6.3)"
  std::string assumes;               ///< "force on both copies, N = 2, n = 0, sampled velocity"
  double formula = 0.0;              ///< with the gains, masses and tick of the scene [N s/m]
  double direct = 0.0;               ///< direct solve under exactly these assumptions [N s/m]
  double here = 0.0;                 ///< direct solve of the same model of the scene as it is
  std::vector<std::string> outside;  ///< what of the scene is outside them; empty: it holds here
};

struct ClosedForms {
  std::vector<ClosedFormRow> rows;
  std::string why_none;  ///< set where no formula covers the scene: walls, other integrators...
};

/// (6.3), (B.11)-(B.13) as printed and as corrected by the reference analysis for a distributed
/// scene, (B.10) for a central one, each beside the direct solve. `round_trip` in packet periods.
[[nodiscard]] ClosedForms closed_form_rows(const core::Scene& scene, double round_trip);

}  // namespace tandem::analysis
