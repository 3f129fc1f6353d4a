// Rates whose ratio is not whole: 1024 Hz with 100 packets a second, 1000 Hz with 128.

#include <cmath>
#include <complex>
#include <string>
#include <vector>

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "analysis/drag.h"
#include "analysis/growth.h"
#include "analysis/lifted.h"
#include "analysis/resampled.h"
#include "analysis/response.h"
#include "analysis/stability.h"
#include "analysis/with_loop.h"
#include "scene/load_scene.h"

namespace tandem::analysis {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

core::Scene rated(const char* name, double local_hz, double packet_hz,
                  std::vector<std::string> sets = {}) {
  core::Scene scene = scene::load_scene(name, sets);
  scene.rates.local_hz = local_hz;
  scene.rates.packet_hz = packet_hz;
  return scene;
}

core::NetworkModel round_trip(const core::Scene& scene, double packets,
                              core::PacketTimer timer = core::PacketTimer::kForceLoop) {
  core::NetworkModel network;
  network.set_round_trip(packets, scene.ticks_per_packet());
  network.packet_timer = timer;
  return network;
}

core::Scene with_gains(core::Scene scene, core::Gain own, core::Gain other, core::Gain object) {
  for (auto& c : scene.couplers) c.gain = c.user.empty() ? object : c.user == c.copy ? own : other;
  return scene;
}

// ---- The independent answer: thesis (4.28) in time, written out for two users. --------------

enum class Sampling {
  kFirstTickAfter,  ///< tick ceil(k r / p), used at once: the rule of core/packet_slots.h
  kLastTickBefore,  ///< tick floor(k r / p), used from tick ceil: reference H8 "tick"
  kExact,           ///< at k r / p between the ticks, used from tick ceil: reference H8 "exact"
};

/// The map over r ticks with p packets. States: x1 v1 (hand 1), X1 V1 (copy 1), the same of user 2,
/// what is held of the other site at 1 and at 2, and queues that move one place a tick.
class Recurrence {
 public:
  Recurrence(const core::Scene& scene, long r, long p, Sampling sampling, long delay_12 = 0)
      : scene_(scene),
        T_(1.0 / scene.rates.local_hz),
        delay_{0, delay_12},
        places_(delay_12 + 2),
        n_(16 + 8 * places_) {
    const MatrixXd tick = moved(T_).topLeftCorner(16, 16);
    const MatrixXd now = MatrixXd::Identity(8, 16);
    std::vector<char> full[2];
    full[0] = full[1] = std::vector<char>(static_cast<std::size_t>(places_), 0);
    const auto take = [&](const MatrixXd& at, long late) {  // the other site's state, into a queue
      for (int to = 0; to < 2; ++to) {
        const long place = delay_[to] + late;
        const MatrixXd other = at.middleRows(4 * (1 - to), 4) * map_.topRows(16);
        map_.middleRows(queue(to, place), 4) = other;
        full[to][static_cast<std::size_t>(place)] = 1;
      }
    };
    for (long t = -r * (1 + delay_12 / r); t < r; ++t) {  // the rounds before fill the queues
      if (t == 0) map_ = MatrixXd::Identity(n_, n_);
      const long after = ((t + 100 * r) * p) % r;  // p times the time since the last instant
      if (sampling == Sampling::kFirstTickAfter ? after < p : after == 0) take(now, 0);
      for (int to = 0; to < 2; ++to)
        if (full[to][0] != 0) {
          const MatrixXd arrived = map_.middleRows(queue(to, 0), 4);
          map_.middleRows(8 + 4 * to, 4) = arrived;
        }
      // An instant between this tick and the next: used from the next tick on.
      if (sampling != Sampling::kFirstTickAfter && after > 0 && after + p > r) {
        const double part = static_cast<double>(r - after) / static_cast<double>(p);
        take(sampling == Sampling::kExact ? MatrixXd(moved(part * T_).topLeftCorner(8, 16)) : now,
             1);
      }
      const MatrixXd next = tick * map_.topRows(16), on = map_.bottomRows(n_ - 24);
      map_.topRows(16) = next;
      map_.middleRows(16, n_ - 24) = on;
      map_.bottomRows(8).setZero();
      for (auto& f : full) f.erase(f.begin()), f.push_back(0);
    }
  }

  [[nodiscard]] const MatrixXd& map() const { return map_; }

 private:
  [[nodiscard]] Eigen::Index queue(int to, long place) const { return 16 + 8 * place + 4 * to; }

  /// Everything after time t under the forces of now (exact for held forces).
  [[nodiscard]] MatrixXd moved(double t) const {
    MatrixXd A = MatrixXd::Identity(n_, n_);
    const auto gain = [&](const char* name) {
      return scene_.couplers.at(core::index_of(scene_.couplers, name)).gain;
    };
    const auto spring = [](VectorXd& f, int on, int from, core::Gain k) {
      f(from) += k.stiffness, f(from + 1) += k.damping;
      f(on) -= k.stiffness, f(on + 1) -= k.damping;
    };
    for (int site = 0; site < 2; ++site) {
      const int x = 4 * site, X = x + 2, held = 8 + 4 * site;
      VectorXd hand = VectorXd::Zero(n_), copy = VectorXd::Zero(n_);
      spring(hand, x, X, gain(site == 0 ? "k11" : "k22"));
      spring(copy, X, x, gain(site == 0 ? "k11" : "k22"));
      spring(copy, X, held, gain(site == 0 ? "k12" : "k21"));
      spring(copy, X, held + 2, gain(site == 0 ? "ko1" : "ko2"));
      const auto move = [&](int at, double m, const VectorXd& f) {
        A(at, at + 1) += t;
        A.row(at) += t * t / (2.0 * m) * f.transpose();
        A.row(at + 1) += t / m * f.transpose();
      };
      move(x, scene_.users[site].mass, hand);
      move(X, scene_.objects[0].mass, copy);
    }
    return A;
  }

  const core::Scene& scene_;
  double T_;
  long delay_[2];
  long places_;
  Eigen::Index n_;
  MatrixXd map_ = MatrixXd::Identity(n_, n_);
};

MatrixXd recurrence(const core::Scene& scene, long r, long p, Sampling sampling,
                    long delay_12 = 0) {
  return Recurrence(scene, r, p, sampling, delay_12).map();
}

/// Largest modulus per packet without the translation, which has eigenvalue one.
double radius_of(const MatrixXd& M, long p) {
  const Eigen::Index n = M.rows();
  VectorXd t = VectorXd::Zero(n);
  for (Eigen::Index i = 0; i < n; i += 2) t(i) = 1.0;
  const MatrixXd R = (M - t * M.row(0)).bottomRightCorner(n - 1, n - 1);
  return std::pow(R.eigenvalues().cwiseAbs().maxCoeff(), 1.0 / static_cast<double>(p));
}

struct H8 {
  double local_hz, packet_hz;
  long r, p;
  const char* gains;
  double exact, tick;
};

// Reference analysis, section 6, H8: spectral radius per packet period, full digits.
const H8 kReference[] = {
    {1024, 100, 256, 25, "T6.1", 0.9380761836580304, 0.933596947745744},
    {1024, 100, 256, 25, "T8.2N", 0.9426422717990859, 0.9508135418526101},
    {1024, 100, 256, 25, "Fig5.2", 1.0118760172748602, 1.027963449817393},
    {1000, 128, 125, 16, "T6.1", 0.9615785095864324, 0.9577441264778218},
    {1000, 128, 125, 16, "T8.2N", 0.9430767830711542, 0.948346438030341},
    {1000, 128, 125, 16, "Fig5.2", 0.9835817869739669, 0.9980357455420908},
    {1000, 150, 20, 3, "T6.1", 0.9727518902901398, 0.9703465163121632},
    {1000, 150, 20, 3, "T8.2N", 0.9596977812352961, 0.9560192318767784},
    {1000, 150, 20, 3, "Fig5.2", 0.9685792268322222, 0.977667650703409},
    {1024, 102.4, 10, 1, "Fig5.2", 0.991621264068136, 0.991621264068136},
};

core::Scene scene_of(const H8& h) {
  core::Scene scene = rated("axis_distributed", h.local_hz, h.packet_hz);
  const std::string gains = h.gains;
  if (gains == "T6.1") return with_gains(scene, {3000, 20}, {400, 2}, {300, 10});
  if (gains == "T8.2N") return with_gains(scene, {800, 3}, {800, 3}, {400, 8});
  return with_gains(scene, {2000, 10}, {3000, 10}, {1000, 10});
}

// First the recurrence above against the reference: then it may stand for it elsewhere.
TEST(UnevenRates, TheRecurrenceReproducesTheReferenceForBothWaysOfSampling) {
  for (const H8& h : kReference) {
    const core::Scene scene = scene_of(h);
    EXPECT_NEAR(radius_of(recurrence(scene, h.r, h.p, Sampling::kExact), h.p), h.exact, 1e-11)
        << h.local_hz << ":" << h.packet_hz << " " << h.gains;
    EXPECT_NEAR(radius_of(recurrence(scene, h.r, h.p, Sampling::kLastTickBefore), h.p), h.tick,
                1e-11)
        << h.local_hz << ":" << h.packet_hz << " " << h.gains;
  }
}

// A packet timer of its own is what the reference calls "tick".
TEST(UnevenRates, TheLoopWithAPacketTimerOfItsOwnHasTheReferencesRadius) {
  for (const H8& h : kReference) {
    const core::Scene scene = scene_of(h);
    const Judgement j =
        judge(measured_system(scene, round_trip(scene, 0.0, core::PacketTimer::kOwn)));
    EXPECT_NEAR(j.radius, h.tick, 1e-10) << h.local_hz << ":" << h.packet_hz << " " << h.gains;
  }
}

TEST(UnevenRates, TheLoopThatSendsInItsOwnTicksFollowsTheRecurrence) {
  for (const H8& h : kReference) {
    const core::Scene scene = scene_of(h);
    EXPECT_NEAR(judge(measured_system(scene, round_trip(scene, 0.0))).radius,
                radius_of(recurrence(scene, h.r, h.p, Sampling::kFirstTickAfter), h.p), 1e-11)
        << h.local_hz << ":" << h.packet_hz << " " << h.gains;
    for (const int ticks : {3, 9, 21}) {  // delays that are no whole number of packet periods
      core::NetworkModel network;
      network.link[0][1].delay_ticks = ticks;
      EXPECT_NEAR(judge(measured_system(scene, network)).radius,
                  radius_of(recurrence(scene, h.r, h.p, Sampling::kFirstTickAfter, ticks), h.p),
                  1e-11)
          << h.local_hz << ":" << h.packet_hz << " " << h.gains << " " << ticks;
    }
  }
}

// The k12 where it becomes unstable at k11 = 2000, k_o = 1000, b = 10 (H8): below those of both
// whole ratios beside it, 3095.76 with 10 ticks and 2936.29 with 11, for a timer of its own.
TEST(UnevenRates, TheBoundaryAtARatioOf10Point24IsTheReferences) {
  struct Boundary {
    double local_hz, packet_hz;
    core::PacketTimer timer;
    double k12;
  };
  const Boundary all[] = {{1024, 100, core::PacketTimer::kOwn, 2694.5399940013885},
                          {1000, 128, core::PacketTimer::kOwn, 3027.370125055313},
                          {1024, 102.4, core::PacketTimer::kForceLoop, 3095.76016664505},
                          {1024, 1024.0 / 11, core::PacketTimer::kForceLoop, 2936.2893104553223},
                          {1000, 100, core::PacketTimer::kForceLoop, 3050.199419260025}};
  for (const Boundary& b : all) {
    core::Scene scene = with_gains(rated("axis_distributed", b.local_hz, b.packet_hz), {2000, 10},
                                   {1000, 10}, {1000, 10});
    StabilityJudge judge(scene, round_trip(scene, 0.0, b.timer));
    IntervalOptions options;
    options.samples = 24;
    options.tolerance = 1e-10;
    const Knob knob(scene, "coupler.k12.stiffness,coupler.k21.stiffness");
    const auto stable = stable_intervals(judge, scene, knob, 1000.0, 4500.0, options);
    ASSERT_FALSE(stable.empty());
    // The reference halved 1000 .. 4500 some 25 times.
    EXPECT_NEAR(stable.front().high / b.k12, 1.0, 1e-7) << b.local_hz << ":" << b.packet_hz;
  }
}

// The running loop's own answers, with hands pushed and deviations followed: growth per packet to
// 2e-5 (a mean over 6000 packets with a rest of oscillation), drag to 1e-8 (settled to 1e-11).
TEST(UnevenRates, GrowthAndDragOfTheRunningLoopAreThePredictedOnes) {
  for (const auto& [local, packets] : {std::pair{1024.0, 100.0}, {1000.0, 128.0}})
    for (const double delay : {0.0, 1.0, 0.7}) {
      const core::Scene scene = rated("axis_distributed", local, packets);
      const core::NetworkModel network = round_trip(scene, delay);
      const LiftedSystem system = measured_system(scene, network);
      const double growth = measure_growth(scene, network).per_packet;
      EXPECT_NEAR(growth, judge(system).radius, 2e-5) << local << ":" << packets << " " << delay;

      const core::Scene alone = with_one_hand(scene, "1");
      const Drag drag = measure_drag(alone, network, 0);
      ASSERT_TRUE(drag.n_s_per_m.has_value());
      const LiftedSystem one = measured_system(alone, network);
      EXPECT_NEAR(*drag.n_s_per_m, free_motion(one, one.ports[0]).mean_damping, 1e-8)
          << local << ":" << packets << " " << delay;
    }
}

// Of the loop itself, driven by a held cosine: the part of the velocity at that frequency over one
// second, which is whole cycles (5) and whole repeats (8). A real force is half of e^{jwt} and half
// of its mirror image, whose side bands at -5 + 8 m Hz are other frequencies and add up to nothing.
TEST(UnevenRates, TheAdmittanceIsThatOfTheDrivenLoop) {
  const core::Scene scene = rated("axis_distributed", 1000.0, 128.0);
  const core::NetworkModel network = round_trip(scene, 1.0);
  const double omega = 2.0 * 3.14159265358979323846 * 5.0;
  const LiftedSystem system = measured_system(scene, network);
  const std::complex<double> predicted = admittance(system, system.ports[0], omega);
  const std::complex<double> driven =
      with_loop_of<core::AxisWorld>(scene, network, [&](auto& loop) {
        std::complex<double> sum = 0.0;
        int packets = 0;
        while (loop.time() < 40.0) {
          const std::complex<double> phase = std::polar(1.0, omega * loop.time());
          if (loop.time() >= 39.0) {  // 128 packets
            sum += loop.hands().finger(0, 0).velocity() * std::conj(phase);
            ++packets;
          }
          loop.hands().finger(0, 0).set_external_force(phase.real());
          loop.advance_packet_period();
        }
        return 2.0 * sum / static_cast<double>(packets);
      });
  // Free motion has died out after 39 s; what is left is rounding of sums.
  EXPECT_NEAR(std::abs(driven - predicted) / std::abs(predicted), 0.0, 1e-6);
}

TEST(UnevenRates, RatesThatRepeatOnlyAfterTooLongAreRefusedInWords) {
  const core::Scene scene = rated("axis_distributed", 1024.0, 1024.0 / 3.14159265358979);
  try {
    (void)measured_system(scene, {});
    FAIL();
  } catch (const std::domain_error& e) {
    EXPECT_NE(std::string(e.what()).find("rates.local_hz / rates.packet_hz"), std::string::npos);
  }
}

}  // namespace
}  // namespace tandem::analysis
