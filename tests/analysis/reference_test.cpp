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
TEST(Reference, StableIntervals) { expect_all("interval ", 540); }

// Stable points of the 100 x 100 grids, rows and columns with more than one interval, pieces and
// holes, exactly.
TEST(Reference, CountsOfStablePoints) { expect_all("count ", 24); }

// The rest of section 3: folds of Fig 5.2, the damping that empties Fig 5.1 (on the reference's own
// grid), boundaries on the running loop, scale limits.
TEST(Reference, FoldsScansAndEdges) {
  expect_all("fold ", 4);
  expect_all("scan ", 20);
  expect_all("edge ", 4);
  expect_all("excess ", 80);
}

// Drag by a direct solve to 1e-9: Table 6.2 and its scan, (6.3), (B.10), (B.11), compensated, with
// unequal links, with dead reckoning, what a packet of delay adds, and felt inertia.
TEST(Reference, Damping) {
  expect_all("damping ", 630);
  expect_all("root ", 4);
  expect_all("slope ", 18);
}

// Closed forms by themselves, and whether they are the direct solve at other numbers.
TEST(Reference, ClosedForms) {
  expect_all("closed ", 70);
  expect_all("identity ", 7);
}

// Deflated spectral radii to 1e-10: Tables 8.1, 8.2, compensation, delays of single ticks.
TEST(Reference, SpectralRadii) { expect_all("radius ", 450); }

// Section 1: the example's matrix and mode; section 2: roads to random plants agree.
TEST(Reference, RoadsAndModes) {
  expect_all("matrix ", 1);
  expect_all("eigenvalues ", 1);
  expect_all("jury ", 1);
  expect_all("roads ", 6);
  expect_all("traces ", 2);
}

// Frequency responses (6.1) of Figs 6.2, 6.4, 6.5 to 1e-9, magnitude and phase together; with the
// force held over a packet, over a tick, and of ideal masses.
TEST(Reference, FrequencyResponses) { expect_all("response ", 400); }

// Stiffness at rest against a wall, (6.4) as corrected by the reference analysis.
TEST(Reference, EquivalentStiffness) {
  expect_all("stiffness 6.4 corrected", 6);
  expect_all("stiffness 4.5", 10);
}

}  // namespace
}  // namespace tandem::analysis
