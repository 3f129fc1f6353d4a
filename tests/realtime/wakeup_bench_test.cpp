#include <cstdlib>
#include <stdexcept>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "bench/wakeup.h"

namespace tandem::bench {
namespace {

TEST(WakeupBench, ReportsEveryWayOfWaitingAndWhatANodeDoes) {
  const auto json = to_json(run_wakeup_bench({.seconds = 0.2, .rounds = 2}));
  int defaults = 0;
  ASSERT_GE(json.at("variants").size(), 5u);
  for (const auto& row : json.at("variants")) {
    if (row.at("name") == "cyclictest") continue;
    EXPECT_LE(row.at("p50_us"), row.at("p99_us"));
    EXPECT_LE(row.at("p99_us"), row.at("p999_us"));
    EXPECT_LE(row.at("p999_us"), row.at("max_us"));
    // 0.2 s at 1024 Hz in two rounds of 103: each slot woke or was missed; the last wake-up of a
    // round may skip beyond its end.
    EXPECT_GE(row.at("wakeups").get<int>() + row.at("missed").get<int>(), 206);
    EXPECT_GT(row.at("processor_fraction"), 0.0);
    if (row.at("node_default").get<bool>()) {
      ++defaults;
      EXPECT_EQ(row.at("p99_us"), json.at("p99_us"));
    }
  }
  EXPECT_EQ(defaults, 1);
}

TEST(WakeupBench, WithoutCyclictestItSaysSoAndTheKeyIsNull) {
  const std::string path = std::getenv("PATH");
  setenv("PATH", "/nonexistent", 1);
  const auto results = run_wakeup_bench({.seconds = 0.1, .rounds = 1});
  setenv("PATH", path.c_str(), 1);
  EXPECT_TRUE(to_json(results).at("cyclictest_p99_us").is_null());
  EXPECT_NE(results.cyclictest.find("not installed (Debian package rt-tests)"), std::string::npos)
      << results.cyclictest;
}

TEST(WakeupBench, RefusesImpossibleOptions) {
  EXPECT_THROW(static_cast<void>(run_wakeup_bench({.seconds = 0.0})), std::invalid_argument);
  EXPECT_THROW(static_cast<void>(run_wakeup_bench({.priority = 100})), std::invalid_argument);
}

}  // namespace
}  // namespace tandem::bench
