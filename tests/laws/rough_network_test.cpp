#include <cmath>
#include <map>

#include <gtest/gtest.h>

#include "analysis/with_loop.h"
#include "core/link_model.h"
#include "scene/load_scene.h"

namespace tandem {
namespace {

TEST(LinkModel, LosesTheDeclaredShareWithinItsBinomialInterval) {
  core::LinkModelParameters p;
  p.loss = 0.05;
  core::LinkModel<int> link(p);
  const int n = 200000;
  int arrived = 0;
  for (int k = 0; k < n; ++k) {
    link.push(k, k);
    link.deliver(k, [&](int, std::int64_t, std::uint64_t) { ++arrived; });
  }
  const double sd = std::sqrt(n * 0.05 * 0.95);
  EXPECT_NEAR(n - arrived, 0.05 * n, 4 * sd);  // four standard deviations
}

TEST(LinkModel, DelaysByWholeTicksAndASubTickDelayActsAsTheNextTick) {
  for (const auto& [delay, expected] :
       {std::pair{0.0, 0}, {0.2, 1}, {1.0, 1}, {8.0, 8}, {9.4, 10}}) {
    core::LinkModelParameters p;
    p.delay_ticks = delay;
    core::LinkModel<int> link(p);
    link.push(7, 100);
    for (int slot = 100; slot < 120; ++slot)
      link.deliver(slot, [&](int message, std::int64_t sent, std::uint64_t) {
        EXPECT_EQ(message, 7);
        EXPECT_EQ(slot - sent, expected) << delay;
      });
    EXPECT_EQ(link.in_flight(), 0);
  }
}

// Moments of the distributions made by hand: mean and standard deviation within 4 standard errors.
TEST(LinkModel, JitterHasTheDeclaredSpread) {
  core::Random random(3);
  const int n = 400000;
  double sum = 0, square = 0, exponential = 0;
  for (int i = 0; i < n; ++i) {
    const double x = random.normal();
    sum += x;
    square += x * x;
    exponential += random.exponential(2.5);
  }
  EXPECT_NEAR(sum / n, 0.0, 4 / std::sqrt(n));
  EXPECT_NEAR(square / n, 1.0, 4 * std::sqrt(2.0 / n));
  EXPECT_NEAR(exponential / n, 2.5, 4 * 2.5 / std::sqrt(n));
}

TEST(LinkModel, ReordersWithJitterUnlessFirstInFirstOut) {
  for (const bool fifo : {false, true}) {
    core::LinkModelParameters p;
    p.delay_ticks = 20;
    p.jitter = core::JitterKind::kUniform;
    p.jitter_ticks = 15;
    p.first_in_first_out = fifo;
    core::LinkModel<int> link(p);
    int last = -1, reordered = 0, arrived = 0;
    for (int slot = 0; slot < 20000; ++slot) {
      if (slot % 4 == 0) link.push(slot, slot);
      link.deliver(slot, [&](int message, std::int64_t, std::uint64_t) {
        ++arrived;
        reordered += message < last;
        last = std::max(last, message);
      });
    }
    EXPECT_GT(arrived, 4980);
    if (fifo)
      EXPECT_EQ(reordered, 0);
    else
      EXPECT_GT(reordered, 500);
  }
}

TEST(LinkModel, DropsTheOldestWhenMoreIsInFlightThanFits) {
  core::LinkModelParameters p;
  p.delay_ticks = 1e6;
  core::LinkModel<int, 8> link(p);
  for (int k = 0; k < 20; ++k) link.push(k, k);
  EXPECT_EQ(link.in_flight(), 8);
  EXPECT_EQ(link.overflowed(), 12);
}

// Two users carry the box over a bad network: every force stays within the device's limit, every
// state finite, and the copies are together again once the hands have let go.
TEST(RoughNetwork, ForcesStayWithinTheDeviceAndTheCopiesFindEachOther) {
  for (const char* name : {"box_distributed", "box_distributed_split"})
    for (const char* kind : {"HOLD", "EXTRAPOLATE"}) {
      core::LinkModelParameters p;
      p.delay_ticks = 4;
      p.jitter = core::JitterKind::kExponential;
      p.jitter_ticks = 3;
      p.loss = 0.1;
      p.duplicate = 0.05;
      p.burst_enter = 0.002;
      p.burst_leave = 0.05;
      core::NetworkModel network;
      network.set_all(p);
      const core::Scene scene = scene::load_scene(
          name, std::vector<std::string>{std::string("reconstruction.kind=") + kind});
      distributed::DistributedLoop<core::PlaneWorld> loop(scene, network);
      const double limit = scene.devices[0].max_force;
      double largest = 0.0;
      while (loop.time() < 20.0) {
        loop.tick();
        for (int u = 0; u < 2; ++u)
          for (int f = 0; f < 2; ++f) {
            const auto& force = loop.output(u).forces[f];
            ASSERT_TRUE(std::isfinite(force.x) && std::isfinite(force.y)) << name << kind;
            largest = std::max(largest, std::sqrt(core::inner(force, force)));
          }
      }
      EXPECT_LE(largest, limit * (1 + 1e-12)) << name << kind;
      EXPECT_GT(largest, 1.0) << name << kind;  // they did hold it
      const auto gap = loop.object(0, 0).p - loop.object(1, 0).p;
      EXPECT_LT(std::sqrt(core::inner(gap, gap)), 1e-3) << name << kind;
    }
}

}  // namespace
}  // namespace tandem
