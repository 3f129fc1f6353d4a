// Boundaries and maps over two numbers of a scene, and the sweeps they run as.

#include "analysis/boundary.h"

#include <cmath>
#include <cstring>
#include <map>
#include <set>

#include <gtest/gtest.h>

#include "scene/load_scene.h"

namespace tandem::analysis {
namespace {

const char* const kOwn = "coupler.k11.stiffness,coupler.k22.stiffness";
const char* const kOther = "coupler.k12.stiffness,coupler.k21.stiffness";
const char* const kCopies = "coupler.ko1.stiffness,coupler.ko2.stiffness";

/// A scene of Figs 5.1-5.4: all dampings 10 N s/m, one pair of stiffnesses fixed.
struct Case {
  core::Scene scene;
  core::NetworkModel network;

  Case(const char* name, double delay, const char* fixed = nullptr, double stiffness = 0.0)
      : scene(scene::load_scene(name)) {
    for (auto& c : scene.couplers) c.gain.damping = 10.0;
    if (fixed != nullptr) Knob(scene, fixed).set(scene, stiffness);
    network.set_round_trip(delay, scene.ticks_per_packet());
  }
  [[nodiscard]] Boundary boundary(const char* x, Axis across, const char* y, Axis up,
                                  int threads = 1, int levels = 1) const {
    const StabilityJudge judge(scene, network);
    ThreadedRunner runner(threads);
    BoundaryOptions options;
    options.levels = levels;
    return stability_boundary(judge, scene, Knob(scene, x), across, Knob(scene, y), up, runner,
                              options);
  }
};

/// Where the boundary crosses the vertical line at x, which is a line of its grid.
std::vector<double> crossings_at_x(const Boundary& boundary, double x) {
  std::set<double> found;  // both squares beside the line end there, in the same bits
  for (const Segment& s : boundary.segments) {
    if (std::abs(s.x0 - x) < 1e-9 * x) found.insert(s.y0);
    if (std::abs(s.x1 - x) < 1e-9 * x) found.insert(s.y1);
  }
  return {found.begin(), found.end()};
}
std::vector<double> crossings_at_y(const Boundary& boundary, double y) {
  std::set<double> found;
  for (const Segment& s : boundary.segments) {
    if (std::abs(s.y0 - y) < 1e-9 * y) found.insert(s.x0);
    if (std::abs(s.y1 - y) < 1e-9 * y) found.insert(s.x1);
  }
  return {found.begin(), found.end()};
}

void expect_near_all(const std::vector<double>& found, const std::vector<double>& expected) {
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < found.size(); ++i)
    EXPECT_NEAR(found[i] / expected[i], 1.0, 1e-6);  // what the boundary promises
}

// Within 2400 <= k12 <= 3600 the region of Fig 5.2, d = 1 is two pieces that do not touch (they
// meet at k12 = 2023): the lower one is narrower than a square of the grid. A bisection from 0.5
// finds one end of the three. Expected: the reference analysis.
TEST(Boundary, ARegionInTwoPiecesHasAllItsEnds) {
  const Case c("axis_distributed", 1, kCopies, 1000.0);
  const Boundary b = c.boundary(kOther, {2400, 3600, 16}, kOwn, {0, 26000, 16});
  expect_near_all(crossings_at_x(b, 3000.0),
                  {530.6252209641849, 9383.21522226496, 21704.05635593064});
}

// Fig 5.1, d = 1 above k2 = 440: an island between two columns of the grid, all whose points are
// outside. Expected: the reference analysis.
TEST(Boundary, AnIslandSmallerThanASquareIsFound) {
  const Case c("axis_central", 1);
  const Boundary b =
      c.boundary("coupler.k1.stiffness", {1, 25001, 16}, "coupler.k2.stiffness", {440, 600, 16});
  EXPECT_GT(b.found_between, 0);
  expect_near_all(crossings_at_y(b, 440.0), {574.537810887372, 1470.49982845767});
}

// Every end is on the boundary: by eigenvalues the sign changes within 1e-6 of it along one of the
// two axes. And the boundary closes: every end inside the window belongs to two segments.
TEST(Boundary, EveryEndIsExactAndTheCurveCloses) {
  for (const int d : {0, 1, 2, 3}) {
    const Case c("axis_distributed", d, kCopies, 1000.0);
    const Axis across{60, 6000, 16}, up{250, 25000, 16};
    const Boundary b = c.boundary(kOther, across, kOwn, up);
    ASSERT_GT(b.segments.size(), 10u);
    StabilityJudge judge(c.scene, c.network);
    core::Scene edited = c.scene;
    const Knob x(c.scene, kOther), y(c.scene, kOwn);
    const auto stable = [&](double at_x, double at_y) {
      x.set(edited, at_x);
      y.set(edited, at_y);
      return judge.radius(edited) < 1.0;
    };
    std::map<std::pair<double, double>, int> ends;
    for (const Segment& s : b.segments)
      for (const auto& [px, py] : {std::pair{s.x0, s.y0}, std::pair{s.x1, s.y1}}) {
        ++ends[{px, py}];
        EXPECT_TRUE(stable(px * (1 - 1e-6), py) != stable(px * (1 + 1e-6), py) ||
                    stable(px, py * (1 - 1e-6)) != stable(px, py * (1 + 1e-6)))
            << "d " << d << " at " << px << " " << py;
      }
    for (const auto& [end, times] : ends) {
      const bool at_rim = end.first == across.from || end.first == across.to ||
                          end.second == up.from || end.second == up.to;
      EXPECT_EQ(times, at_rim ? 1 : 2) << "d " << d << " at " << end.first << " " << end.second;
    }
  }
}

TEST(Boundary, BitsDoNotDependOnTheNumberOfThreads) {
  const Case c("axis_distributed", 1, kOther, 300.0);
  const auto traced = [&](int threads) {
    return c.boundary(kOwn, {0, 25000, 16}, kCopies, {0, 6000, 16}, threads, 2);
  };
  const Boundary one = traced(1), three = traced(3);
  ASSERT_EQ(one.segments.size(), three.segments.size());
  EXPECT_EQ(std::memcmp(one.segments.data(), three.segments.data(),
                        one.segments.size() * sizeof(Segment)),
            0);
  EXPECT_EQ(one.evaluations, three.evaluations);
}

// The boundary costs a tenth of the map of Fig 5.4, d = 1 it bounds.
TEST(Boundary, TakesATenthOfTheEvaluationsOfAMap) {
  const Case c("axis_distributed", 1, kOwn, 2000.0);
  const Boundary b = c.boundary(kCopies, {0, 6000, 16}, kOther, {0, 6000, 16});
  EXPECT_LT(b.evaluations, 1000);
}

// One point in a hundred, as many as there are; the two roads agree to rounding (5e-11 were seen
// between the reference analysis' own).
TEST(Map, IsCheckedOnTheRunningLoop) {
  const Case c("axis_distributed", 1, kOwn, 2000.0);
  const StabilityJudge judge(c.scene, c.network);
  ThreadedRunner runner(2);
  const StabilityMap map = stability_map(judge, c.scene, Knob(c.scene, kCopies), {0, 6000, 50},
                                         Knob(c.scene, kOther), {0, 6000, 40}, runner, 100);
  EXPECT_EQ(map.check.points, 20);
  EXPECT_EQ(map.check.differ, 0);
  EXPECT_LT(map.check.largest_difference, 1e-10);
  EXPECT_GT(map.check.largest_difference, 0.0) << "two roads do not round alike";
}

TEST(Map, SaysWhereTheRunningLoopDiffers) {
  LoopCheck check;
  check.add(0.9, 0.9, true);
  check.add(1.0 - 1e-12, 1.0 + 1e-12, true);  // rounding decides: no fault
  EXPECT_EQ(check.differ, 0);
  check.add(0.9, 1.2, true);
  EXPECT_EQ(check.differ, 1);
  EXPECT_EQ(check.points, 3);
  EXPECT_NEAR(check.largest_difference, 0.25, 1e-12);  // relative to 1.2
}

// Items are done once each whoever does them; a stop leaves the rest, an exception comes through.
TEST(Sweep, DoesEveryItemOnce) {
  std::vector<std::int64_t> items;
  for (int i = 0; i < 1000; ++i) items.push_back(3 * i);
  std::set<std::int64_t> seen;
  const auto make_work = [] {
    return [](std::int64_t item) { return SweepRow{static_cast<double>(item)}; };
  };
  EXPECT_TRUE(do_items(items, 4, make_work, [&](std::int64_t item, SweepRow&& row) {
    EXPECT_EQ(row.front(), static_cast<double>(item));
    EXPECT_TRUE(seen.insert(item).second);
  }));
  EXPECT_EQ(seen.size(), items.size());
}

TEST(Sweep, StopsAndPassesOnWhatWentWrong) {
  const std::vector<std::int64_t> items{0, 1, 2, 3, 4, 5, 6, 7, 8, 9};
  int done = 0;
  const auto make_work = [] { return [](std::int64_t) { return SweepRow{0.0}; }; };
  const auto count = [&](std::int64_t, SweepRow&&) { ++done; };
  EXPECT_FALSE(do_items(items, 1, make_work, count, [&] { return done == 4; }));
  EXPECT_EQ(done, 4);
  const auto failing = [] {
    return [](std::int64_t item) {
      if (item == 5) throw std::domain_error("item 5");
      return SweepRow{0.0};
    };
  };
  EXPECT_THROW(do_items(items, 3, failing, [](std::int64_t, SweepRow&&) {}), std::domain_error);
}

TEST(Boundary, RefusesRangesThatAreNone) {
  const Case c("axis_distributed", 1);
  EXPECT_THROW((void)c.boundary(kOwn, {100, 100, 16}, kOther, {0, 1, 4}), std::invalid_argument);
  EXPECT_THROW((void)c.boundary(kOwn, {0, 1, 0}, kOther, {0, 1, 4}), std::invalid_argument);
  EXPECT_THROW((void)c.boundary(kOwn, {0, NAN, 4}, kOther, {0, 1, 4}), std::invalid_argument);
}

}  // namespace
}  // namespace tandem::analysis
