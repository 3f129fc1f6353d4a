// Loss and jitter: the mean square lifted exactly, against closed forms and against the session.

#include "analysis/random_network.h"

#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "analysis/lifted.h"
#include "analysis/mean_square.h"
#include "analysis/packet_fates.h"
#include "analysis/period_probe.h"
#include "analysis/with_loop.h"
#include "scene/load_scene.h"

namespace tandem::analysis {
namespace {

Matrix scalar(double a) {
  Matrix m(1, 1);
  m(0, 0) = a;
  return m;
}

// x+ = a x with a drawn each time: E[x^2] grows by E[a^2].
TEST(MeanSquare, OfAScalarIsTheMeanOfItsSquare) {
  const JumpSystem system{{1},
                          {scalar(1.5), scalar(0.5), scalar(-0.9)},
                          {{0, 0, 0, 0.2}, {0, 0, 1, 0.5}, {0, 0, 2, 0.3}}};
  EXPECT_NEAR(second_moment(system).radius, 0.2 * 2.25 + 0.5 * 0.25 + 0.3 * 0.81, 1e-15);
}

// Two modes: in mode 0 a^2 = 2, left with chance 1/2; in mode 1 a^2 = 1/2, left with chance 1/4.
// The second moments of the modes go by  [1 1/8; 1 3/8], whose eigenvalues solve
// z^2 - 11/8 z + 1/4 = 0: z = (11 + sqrt(57)) / 16, more than one, while the mean of ln |a| over
// the chain's stay (1/3, 2/3) is -ln(2) / 6.
TEST(MeanSquare, OfTwoModesIsTheHandComputedOne) {
  const JumpSystem system{{1, 1},
                          {scalar(std::sqrt(2.0)), scalar(std::sqrt(0.5))},
                          {{0, 0, 0, 0.5}, {0, 1, 0, 0.5}, {1, 0, 1, 0.25}, {1, 1, 1, 0.75}}};
  EXPECT_NEAR(second_moment(system).radius, (11.0 + std::sqrt(57.0)) / 16.0, 1e-14);
}

// A rotation by 90 degrees that also grows or shrinks: every direction alike, so E[a^2] again, now
// with half-vectorised matrices; and 30 copies of it are too many for the dense way.
TEST(MeanSquare, AppliedAndDenseAgreeOnTurnsOfKnownGrowth) {
  for (const int copies : {1, 30}) {
    JumpSystem system{{2 * copies}, {}, {{0, 0, 0, 0.3}, {0, 0, 1, 0.7}}};
    for (const double a : {1.2, 0.9}) {
      Matrix m(2 * copies, 2 * copies);
      for (int c = 0; c < copies; ++c) m(2 * c, 2 * c + 1) = a, m(2 * c + 1, 2 * c) = -a;
      system.maps.push_back(m);
    }
    const SecondMoment found = second_moment(system);
    EXPECT_EQ(found.dense, copies == 1);
    EXPECT_TRUE(found.converged);
    EXPECT_NEAR(found.radius, 0.3 * 1.44 + 0.7 * 0.81, 1e-12);
  }
}

TEST(PacketFates, AreTheChancesOfWholeTicks) {
  core::LinkModelParameters link;
  link.delay_ticks = 4.0;
  link.jitter = core::JitterKind::kUniform;
  link.jitter_ticks = 2.0;  // 2 .. 6, used at the next whole tick: 3, 4, 5, 6 alike
  FatesOfLink fates = fates_of(link);
  ASSERT_EQ(fates.fates.delays.size(), 4u);
  for (int i = 0; i < 4; ++i) {
    EXPECT_EQ(fates.fates.delays[i].ticks, 3 + i);
    EXPECT_NEAR(fates.fates.delays[i].probability, 0.25, 1e-12);
  }
  link.jitter = core::JitterKind::kExponential;
  link.delay_ticks = 0.0;
  fates = fates_of(link);
  EXPECT_NEAR(fates.fates.delays[0].probability, 1.0 - std::exp(-0.5), 1e-11);
  const std::vector<double> recorded = {0.2, 0.9, -1.0, 3.0, 3.5};
  core::LinkModelParameters from_record;
  from_record.recorded = recorded;
  fates = fates_of(from_record);
  EXPECT_NEAR(fates.fates.loss, 0.2, 1e-12);
  ASSERT_EQ(fates.fates.delays.size(), 3u);
  EXPECT_NEAR(fates.fates.delays[0].probability, 0.5, 1e-12);  // two of four within a tick
}

core::Scene gains(double own, double other, double object, double b = 3.0) {
  core::Scene scene = scene::load_scene("axis_distributed");
  for (auto& c : scene.couplers)
    c.gain = {c.user.empty() ? object : c.user == c.copy ? own : other, c.user.empty() ? 8.0 : b};
  return scene;
}

core::NetworkModel lossy(double loss, double delay_packets = 0.0) {
  core::LinkModelParameters link;
  link.loss = loss;
  core::NetworkModel network;
  network.set_all(link);
  network.set_round_trip(delay_packets, 8.0);
  return network;
}

// Nothing random: the second moment grows by the square of the spectral radius.
TEST(RandomNetwork, WithoutLossTheMeanSquareIsTheSquareOfTheRadius) {
  for (const double delay : {0.0, 1.0, 1.5}) {
    const core::Scene scene = scene::load_scene("axis_distributed");
    const core::NetworkModel network = lossy(0.0, delay);
    const RandomSession session = random_session(scene, network);
    ASSERT_EQ(session.why_not, "");
    const double rho = judge(measured_system(scene, network)).radius;
    // The balanced eigenvalues of the squared map keep some 1e-12.
    EXPECT_NEAR(second_moment(session.system).radius, rho * rho, 1e-9) << delay;
  }
  core::Scene uneven = scene::load_scene("axis_distributed");
  uneven.rates.packet_hz = 100.0;
  const RandomSession session = random_session(uneven, {});
  ASSERT_EQ(session.why_not, "");
  const double rho = judge(measured_system(uneven, {})).radius;
  EXPECT_NEAR(second_moment(session.system).radius, rho * rho, 1e-9);
}

/// Mean over many sessions of |x|^2 after `packets`, from one given deviation, each with its own
/// fates drawn by its links; with its standard error.
struct Sampled {
  double mean = 0.0, error = 0.0;
};

Sampled sample(const core::Scene& scene, core::NetworkModel network, int packets, int runs) {
  Sampled out;
  double squares = 0.0;
  core::Random seeds(5);
  for (int run = 0; run < runs; ++run) {
    for (auto& row : network.link)
      for (auto& link : row) link.seed = seeds.bits();
    const double x = with_loop_of<core::AxisWorld>(scene, network, [&](auto& loop) {
      auto entries = states_of(loop);
      *entries[1].value = 1.0;  // velocity of the first hand
      for (int k = 0; k < packets; ++k) loop.advance_packet_period();
      entries = states_of(loop);
      double sum = 0.0;  // hands only, against the first position: translation does not count
      for (int i = 0; i < 4; ++i) {
        const double d = entries[i].kind == StateKind::kPosition
                             ? *entries[i].value - *entries[0].value
                             : *entries[i].value;
        sum += d * d;
      }
      return sum;
    });
    out.mean += x / runs;
    squares += x * x / runs;
  }
  out.error = std::sqrt(std::max(0.0, squares - out.mean * out.mean) / runs);
  return out;
}

double exact(const core::Scene& scene, const core::NetworkModel& network, int packets) {
  const RandomSession session = random_session(scene, network);
  EXPECT_EQ(session.why_not, "");
  std::vector<Matrix> moment;
  for (const int n : session.system.states) moment.emplace_back(n, n);
  moment.front()(0, 0) = 1.0;  // the first hand's velocity: its position is taken out
  for (int k = 0; k < packets; ++k) moment = advance_second_moment(session.system, moment);
  double sum = 0.0;
  for (const Matrix& m : moment)
    for (int i = 0; i < 3; ++i) sum += m(i, i);
  return sum;
}

// The exact second moment of the hands after some packets is the mean over 8000 sessions: links
// that draw for themselves, no matrix. 4.5 standard errors: one in 10^5 tests fails by chance, and
// the seed is fixed.
TEST(RandomNetwork, TheSecondMomentIsTheMeanOverManySessions) {
  struct Case {
    double loss, enter, leave, jitter, delay_packets;
    int packets;
  };
  for (const Case& c : {Case{0.3, 0.0, 1.0, 0.0, 0.0, 12}, Case{0.2, 0.0, 1.0, 0.0, 1.0, 12},
                        Case{0.0, 0.1, 0.3, 0.0, 0.0, 12}, Case{0.1, 0.0, 1.0, 3.0, 1.0, 8}}) {
    const core::Scene scene = gains(800, 800, 400);
    core::NetworkModel network = lossy(c.loss, c.delay_packets);
    for (auto& row : network.link)
      for (auto& link : row) {
        link.burst_enter = c.enter;
        link.burst_leave = c.leave;
        if (c.jitter > 0.0 && link.delay_ticks > 0.0) {
          link.jitter = core::JitterKind::kUniform;
          link.jitter_ticks = c.jitter;  // 5 .. 11 ticks: reordered across packet periods
        }
      }
    const Sampled sampled = sample(scene, network, c.packets, 8000);
    EXPECT_NEAR(exact(scene, network, c.packets), sampled.mean, 4.5 * sampled.error)
        << c.loss << " " << c.enter << " " << c.jitter;
    EXPECT_LT(sampled.error, 0.1 * sampled.mean);
  }
}

/// Share of loss at which the mean square begins to grow, between two shares.
double boundary(const core::Scene& scene, double stable, double unstable) {
  for (int i = 0; i < 12; ++i) {
    const double middle = 0.5 * (stable + unstable);
    const double radius = second_moment(random_session(scene, lossy(middle)).system).radius;
    (radius < 1.0 ? stable : unstable) = middle;
  }
  return 0.5 * (stable + unstable);
}

// Around the share of loss where the second moment begins to grow, the mean over many sessions
// grows or dies out between packets 6 and 18 on the side that the radius says.
TEST(RandomNetwork, SessionsGrowInTheMeanOnTheSideThatTheRadiusSays) {
  const core::Scene scene = gains(800, 800, 400);
  const double at = boundary(scene, 0.0, 0.9);
  ASSERT_GT(at, 0.05);
  ASSERT_LT(at, 0.85);
  for (const double loss : {0.8 * at, std::min(0.95, 1.2 * at)}) {
    const core::NetworkModel network = lossy(loss);
    const double radius = second_moment(random_session(scene, network).system).radius;
    const Sampled early = sample(scene, network, 6, 8000), late = sample(scene, network, 18, 8000);
    ASSERT_GT(std::abs(late.mean - early.mean), 4.0 * (late.error + early.error)) << loss;
    EXPECT_EQ(late.mean > early.mean, radius > 1.0) << loss;
  }
}

// Without loss a run grows by the spectral radius; the first 400 packets are left out.
TEST(RandomNetwork, TheSampledExponentWithoutLossIsTheLogarithmOfTheRadius) {
  const core::Scene scene = scene::load_scene("axis_distributed");
  LyapunovOptions options;
  options.runs = 3;
  options.packets = 600;
  const Lyapunov typical = sampled_exponent(scene, lossy(0.0, 1.0), options);
  // One real mode is left by then, so that only rounding differs.
  EXPECT_NEAR(typical.exponent, std::log(0.9324125603192328), 1e-9);
  EXPECT_TRUE(typical.surely_stable());
}

// Just beyond the share of loss where the mean square begins to grow, a typical run still dies out:
// rare long losses carry the mean. Jensen: E ln|x|^2 <= ln E|x|^2.
TEST(RandomNetwork, TheMeanSquareMayGrowWhileTypicalRunsDieOut) {
  const core::Scene scene = gains(800, 800, 400);
  const double loss = 1.03 * boundary(scene, 0.0, 0.9);
  const core::NetworkModel network = lossy(loss);
  EXPECT_GT(second_moment(random_session(scene, network).system).radius, 1.0) << loss;
  LyapunovOptions options;
  options.runs = 10;
  options.packets = 1000;
  const Lyapunov typical = sampled_exponent(scene, network, options);
  EXPECT_TRUE(typical.surely_stable()) << typical.exponent << " +- " << typical.half_width;
}

// What cannot be lifted exactly says why; a delay of up to 60 packets would have too many modes.
TEST(RandomNetwork, WhatIsTooMuchToLiftSaysWhy) {
  const core::Scene scene = scene::load_scene("axis_distributed");
  core::LinkModelParameters link;
  link.jitter = core::JitterKind::kExponential;
  link.jitter_ticks = 20.0;
  core::NetworkModel network;
  network.set_all(link);
  EXPECT_NE(random_session(scene, network).why_not.find("too many"), std::string::npos);
  link.first_in_first_out = true;
  network.set_all(link);
  EXPECT_NE(random_session(scene, network).why_not.find("first-in-first-out"), std::string::npos);
}

}  // namespace
}  // namespace tandem::analysis
