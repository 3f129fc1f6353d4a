#include <fstream>

#include <gtest/gtest.h>

#include "analysis/reference_check.h"
#include "scene/load_scene.h"

namespace tandem::analysis {
namespace {

void expect_all(const std::string& kind, std::size_t at_least) {
  std::ifstream file(TANDEM_SOURCE_DIR "/tests/analysis/data/reference.txt");
  ASSERT_TRUE(file.is_open());
  const SceneSource shipped = [](const std::string& name, const std::vector<std::string>& sets) {
    return scene::load_scene(name, sets);
  };
  const auto rows = check_against(file, shipped, kind);
  EXPECT_GE(rows.size(), at_least);
  for (const CheckRow& row : rows)
    EXPECT_TRUE(row.passed()) << row.kind << " " << row.name << ": expected " << row.expected
                              << ", found " << row.found << ", off by " << row.deviation;
}

// Ends of stable intervals to 1e-6 relative, and as many intervals: (3.18), Figs 5.1-5.4.
TEST(Reference, StableIntervals) { expect_all("interval ", 500); }

// Stable points of the 100 x 100 grids, rows and columns with more than one interval, exactly.
TEST(Reference, CountsOfStablePoints) { expect_all("count ", 24); }

// Drag by a direct solve to 1e-9: Table 6.2, (6.3), (B.10), (B.11), compensated, and felt inertia.
TEST(Reference, Damping) { expect_all("damping ", 300); }

// Deflated spectral radii to 1e-10: Tables 8.1, 8.2, compensation, delays of single ticks.
TEST(Reference, SpectralRadii) { expect_all("radius ", 300); }

// Frequency responses (6.1) of Figs 6.2, 6.4, 6.5 to 1e-9, magnitude and phase together.
TEST(Reference, FrequencyResponses) { expect_all("response ", 150); }

// Stiffness at rest against a wall, (6.4) as corrected by the reference analysis.
TEST(Reference, EquivalentStiffness) { expect_all("stiffness ", 8); }

}  // namespace
}  // namespace tandem::analysis
