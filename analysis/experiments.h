#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/network_model.h"
#include "core/scene.h"

/// The experiments of thesis chapter 8 in virtual time. The papers give neither the box nor which
/// pantograph belongs to whom; each function says what was chosen.
namespace tandem::analysis {

/// Columns of equal length, for CSV and pictures.
struct Table {
  std::vector<std::string> columns;
  std::vector<std::vector<double>> rows;
};

/// Loads a shipped scene with edits; given by the caller because this folder reads no files.
using SceneSource =
    std::function<core::Scene(const std::string& name, const std::vector<std::string>& sets)>;

/// Fig 8.1: Table 8.1 against Table 8.2 with D = 1 round-trip packet period.
struct Fig81 {
  double central_growth_per_packet = 0.0;      ///< at the linearised grasp, box_central_table_8_1
  double distributed_growth_per_packet = 0.0;  ///< the same, box_distributed
  Table central_run, distributed_run;          ///< contact forces and path, non-linear
};
[[nodiscard]] Fig81 run_fig_8_1(const SceneSource& scenes, double seconds = 20.0);

/// Fig 8.3: one user's two fingers hold the box at its two y faces; finger a is led along
/// 0.05 sin(2 t) m by a spring and damper, finger b presses against it with a constant force. No
/// ground friction, D = 1. Net force of these fingers on the user's own copy, against m a of the
/// ideal path.
struct Fig83 {
  double ideal = 0.0, hold = 0.0, compensated = 0.0, extrapolated = 0.0;  ///< RMS [N]
  double central_local = 0.0;                                             ///< RMS [N]
  Table forces;
};
[[nodiscard]] Fig83 run_fig_8_3(const SceneSource& scenes);

/// Fig 8.4: one free finger with a damper of 2 N s/m presses the box against the wall with
/// max(0, 1.5 sin 3 t) N. Peak finger travel after finger, box and wall first all touch [m].
struct Fig84 {
  double central_local = 0.0, central_remote = 0.0, distributed = 0.0;
  Table travel;
};
[[nodiscard]] Fig84 run_fig_8_4(const SceneSource& scenes);

}  // namespace tandem::analysis
