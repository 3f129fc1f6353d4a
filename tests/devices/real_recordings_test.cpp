// The hand recordings of people that Tandem is shown with. They are not part of the repository:
// TANDEM_DATA names their folder; without it ../shared/data beside the checkout is tried.

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "devices/load_recorded_path.h"

namespace tandem::devices {
namespace {

std::filesystem::path data_folder() {
  if (const char* named = std::getenv("TANDEM_DATA")) return named;
  return std::filesystem::path(TANDEM_SOURCE_DIR).parent_path() / "shared" / "data";
}

std::vector<std::string> files_in(const char* folder, const std::string& prefix) {
  std::vector<std::string> files;
  std::error_code missing;
  for (const auto& entry : std::filesystem::directory_iterator(data_folder() / folder, missing)) {
    if (entry.path().filename().string().starts_with(prefix)) files.push_back(entry.path());
  }
  return files;
}

/// Plays a path at 1024 Hz and checks that it is a hand's: within `reach` of the origin, and no
/// faster than `speed`.
void expect_a_hand(const RecordedPath& path, double reach, double speed) {
  Vec3 last = path.at(0.0).position;
  for (std::int64_t slot = 0; slot < 1024 * 30; ++slot) {
    const auto motion = path.at(static_cast<double>(slot) / 1024.0);
    for (int i = 0; i < 3; ++i) {
      ASSERT_LE(std::abs(motion.position[i]), reach) << slot;
      ASSERT_LE(std::abs(motion.position[i] - last[i]) * 1024.0, speed) << slot;
    }
    last = motion.position;
  }
}

// Lever of 75 mm, angles up to half a radian or so; the arm moves by centimetres at up to 2 m/s.
TEST(RealRecordings, EveryLeverTrialPlaysAsAHandInALoop) {
  const auto files = files_in("hand_lever", "m1_");
  if (files.empty()) {
    GTEST_SKIP() << "no folder hand_lever in " << data_folder() << "; set TANDEM_DATA";
  }
  for (const std::string& file : files) {
    SCOPED_TRACE(file);
    const RecordedPath path = load_recorded_path(
        file, parse_column_mapping("time=t_s,x=x_master_rad:rad@0.075,end=loop,origin=first"));
    EXPECT_NEAR(path.mean_rate_hz(), 2000.0, 1.0);
    EXPECT_GT(path.length(), 2.0);
    expect_a_hand(path, 0.08, 2.0);
  }
}

TEST(RealRecordings, TheReferenceHandIsFiveSecondsAndLoops) {
  const auto files = files_in("hand_lever", "handRef_2kHz.csv");
  if (files.empty()) {
    GTEST_SKIP() << "no handRef_2kHz.csv in " << data_folder() / "hand_lever"
                 << "; set TANDEM_DATA";
  }
  const RecordedPath path = load_recorded_path(
      files.front(), parse_column_mapping("time=t_s,x=hand_ref_rad*0.075,end=loop,seam=0.2"));
  EXPECT_NEAR(path.length(), 4.9995, 1e-9);
  expect_a_hand(path, 0.08, 2.0);
}

// Symbols of 0.09 m x 0.15 m drawn by hand-guiding; no time stamps, about 700 rows a second.
TEST(RealRecordings, EveryPandaTrialPlaysAsAHand) {
  const auto files = files_in("hand_panda", "symbol17_rec");
  if (files.empty()) {
    GTEST_SKIP() << "no folder hand_panda in " << data_folder() << "; set TANDEM_DATA";
  }
  for (const std::string& file : files) {
    SCOPED_TRACE(file);
    const RecordedPath path = load_recorded_path(
        file, parse_column_mapping("rate_hz=700,x=px_m,y=py_m,z=pz_m,origin=first"));
    EXPECT_GT(path.length(), 5.0);
    expect_a_hand(path, 0.2, 2.0);
  }
}

}  // namespace
}  // namespace tandem::devices
