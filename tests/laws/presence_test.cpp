#include "core/presence.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "analysis/with_loop.h"
#include "scene/load_scene.h"
#include "tests/laws/many_users.h"

namespace tandem {
namespace {

constexpr double kT = 1.0 / 1024.0;

TEST(Presence, WithoutParametersThePeerIsThereFromTheStartForEver) {
  core::Presence presence(std::nullopt, kT);
  for (int slot = 0; slot < 5000; ++slot) {
    presence.update(false, slot);
    ASSERT_EQ(presence.gain(), 1.0);
  }
}

TEST(Presence, StartsAtNothingAndFadesAndComesBackWithinTheDeclaredTimes) {
  core::Presence presence(core::SilenceParameters{0.1, 0.1, 0.4}, kT);
  EXPECT_EQ(presence.gain(), 0.0);
  double previous = 0.0, largest_step = 0.0;
  const auto run = [&](int from, int to, bool packets) {
    for (int slot = from; slot < to; ++slot) {
      presence.update(packets && slot % 8 == 0, slot);
      largest_step = std::max(largest_step, std::abs(presence.gain() - previous));
      previous = presence.gain();
    }
  };
  run(0, 420, true);
  EXPECT_EQ(presence.gain(), 1.0);  // 0.4 s = 410 ticks
  run(420, 420 + 90, false);
  EXPECT_EQ(presence.gain(), 1.0);  // silent for less than 0.1 s
  run(510, 420 + 103 + 103, false);
  EXPECT_EQ(presence.gain(), 0.0);  // gone 0.1 s after the time-out
  run(626, 626 + 430, true);
  EXPECT_EQ(presence.gain(), 1.0);
  // 3 s^2 - 2 s^3 is steepest in the middle, 1.5 times the mean slope of the 0.1 s fade.
  EXPECT_LT(largest_step, 1.5 * kT / 0.1 * 1.01);
}

// A replica whose peer stops in the middle of the carry: the peer's force is gone within 200 ms
// after 100 ms of silence, nothing jumps, and the rejoin starts from zero stretch.
TEST(Presence, OfASilentPeerLeavesNoForceAndNoJumpBehind) {
  const core::Scene scene = scene::load_scene("box_distributed");
  core::NetworkModel network;
  const auto slot = [](double seconds) { return static_cast<std::int64_t>(seconds * 1024.0); };
  // User 2 is cut off both ways from 4 s to 6 s.
  for (auto [i, j] : {std::pair{0, 1}, std::pair{1, 0}}) {
    network.link[i][j].outage_start = slot(4.0);
    network.link[i][j].outage_length = slot(2.0);
  }
  distributed::DistributedLoop<core::PlaneWorld> loop(scene, network);
  core::PlaneBody before = loop.object(0, 0);
  double worst_jump = 0.0;
  while (loop.time() < 9.0) {
    loop.tick();
    const double gain = loop.law(0).peer_gain(1);
    if (loop.time() > 4.3 && loop.time() < 6.0) {
      EXPECT_EQ(gain, 0.0) << loop.time();
    }
    // Velocity of the copy per tick: bounded by the force of four fingers on 0.7 kg.
    const core::PlaneBody now = loop.object(0, 0);
    const auto dv = now.v - before.v;
    worst_jump = std::max(worst_jump, std::sqrt(core::inner(dv, dv)));
    before = now;
  }
  EXPECT_LT(worst_jump, 40.0 / 0.7 * kT);
  EXPECT_EQ(loop.law(0).peer_gain(1), 1.0);
  const auto gap = loop.object(0, 0).p - loop.object(1, 0).p;
  EXPECT_LT(std::sqrt(core::inner(gap, gap)), 1e-3);
}

// The fault says that somebody who was there is not heard; who never came is not missed.
TEST(Presence, ASilentPeerIsAFaultUntilItIsHeardAgain) {
  core::Scene scene = tests::axis_users(2, false, {900, 8}, {60, 1}, {120, 6});
  scene.silence = core::SilenceParameters{0.1, 0.1, 0.4};
  distributed::ReplicaLaw<core::AxisWorld> law(scene, 0);
  const core::SiteState<core::AxisWorld> there{};
  const auto stale_at = [&](std::int64_t slot, bool packet) {
    distributed::ReplicaInputs<core::AxisWorld> inputs;
    if (packet) inputs.fresh[1] = &there;
    (void)law.observe({});
    return has(law.tick(slot, inputs).faults, core::Fault::kStalePeer);
  };
  for (int slot = 0; slot < 500; ++slot) EXPECT_FALSE(stale_at(slot, false));
  EXPECT_FALSE(stale_at(500, true));
  for (int slot = 501; slot <= 602; ++slot) EXPECT_FALSE(stale_at(slot, false)) << slot;
  EXPECT_TRUE(stale_at(603, false));  // 0.1 s are 102 ticks
  EXPECT_FALSE(stale_at(604, true));
}

// Joins a replica whose copy rests at the origin to a peer whose site is `there`, waits until it
// has settled, lets the peer fall silent, and returns the fastest motion from the join
// (`from_join`) or from the last packet on.
template <typename World, typename Speed>
double fastest(const core::Scene& scene, const core::SiteState<World>& there, bool from_join,
               Speed&& speed) {
  distributed::ReplicaLaw<World> law(scene, 0);
  const core::HandSample<typename World::Vector> hand = law.site().fingers;
  double largest = 0.0;
  for (std::int64_t slot = 0; slot < 8 * 1024; ++slot) {
    const bool talks = slot < 6 * 1024;
    distributed::ReplicaInputs<World> inputs;
    if (talks && slot % 8 == 0) inputs.fresh[1] = &there;
    law.observe(hand);
    (void)law.tick(slot, inputs);
    if (from_join || !talks) largest = std::max(largest, speed(law.object(0)));
  }
  return largest;
}

// A peer that came late found the copies 0.1 m apart. Once they are together that is history: its
// going is a fade of a coupler without stretch, which moves nothing.
TEST(Presence, AFadeDoesNotBringBackTheStretchOfTheJoin) {
  core::Scene scene = tests::axis_users(2, true, {0, 0}, {0, 0}, {400, 20});
  scene.silence = core::SilenceParameters{0.1, 0.1, 0.4};
  core::SiteState<core::AxisWorld> there;
  there.objects[0].p = 0.1;
  const auto speed = [](const core::AxisState& b) { return std::abs(b.v); };
  // 0.4 kg, 400 N/m, 20 N s/m: settled to e^-(25 x 5) before the silence.
  EXPECT_LT(fastest(scene, there, false, speed), 1e-9);
  EXPECT_GT(fastest(scene, there, true, speed), 0.1);  // it was drawn there by the coupler
}

// A copy that has spun a full turn on while nobody heard of it lies where the other lies: the
// rejoin finds no stretch and turns nothing.
TEST(Presence, ARejoinAFullTurnApartWindsNothingBack) {
  const core::Scene scene = scene::load_scene(
      "box_distributed_split", std::vector<std::string>{"object.box.ground_friction_rotation=0"});
  const distributed::ReplicaLaw<core::PlaneWorld> peer(scene, 1);
  core::SiteState<core::PlaneWorld> there = peer.site();
  there.objects[0].angle = 2.0 * 3.14159265358979323846;
  // Rounding of 2 pi turns the box by some 1e-16 rad, at 10 N m/rad on some 1e-3 kg m^2.
  EXPECT_LT(fastest(scene, there, true, [](const core::PlaneBody& b) { return std::abs(b.omega); }),
            1e-9);
}

}  // namespace
}  // namespace tandem
