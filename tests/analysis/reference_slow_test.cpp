#include <fstream>

#include <gtest/gtest.h>

#include "analysis/reference_check.h"
#include "scene/load_scene.h"

namespace tandem::analysis {
namespace {

// Every cell of the 24 maps, and of the four grids that show Fig 5.1 empty, by eigenvalues: how
// near the nearest radius is to one, and the smallest there is. What the Routh test of the other
// tests cannot say.
TEST(SlowReference, RadiiOfWholeGrids) {
  const SceneSource shipped = [](const std::string& name, const std::vector<std::string>& sets) {
    return scene::load_scene(name, sets);
  };
  for (const char* kind : {"nearest ", "least "}) {
    std::ifstream file(TANDEM_SOURCE_DIR "/tests/analysis/data/reference.txt");
    ASSERT_TRUE(file.is_open());
    const auto rows = check_against(file, shipped, kind);
    EXPECT_GE(rows.size(), 4u);
    for (const CheckRow& row : rows)
      EXPECT_TRUE(row.passed()) << row.kind << " " << row.name << ": expected " << row.expected
                                << ", found " << row.found << ", off by " << row.deviation;
  }
}

}  // namespace
}  // namespace tandem::analysis
