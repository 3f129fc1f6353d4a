#include "view/interpolate.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "arch_distributed/distributed_loop.h"
#include "core/link_model.h"
#include "core/plane_world.h"
#include "core/space_rotation.h"
#include "scene/load_scene.h"
#include "view/spectator.h"

namespace tandem::view {
namespace {

// A cubic is its own Hermite interpolant: p = 1 + 2 t - 3 t^2 + 4 t^3 on [0, 0.5].
TEST(Hermite, ReproducesACubic) {
  const auto p = [](double t) { return 1 + 2 * t - 3 * t * t + 4 * t * t * t; };
  const auto v = [](double t) { return 2 - 6 * t + 12 * t * t; };
  for (const double t : {0.0, 0.1, 0.25, 0.4, 0.5})
    EXPECT_NEAR(hermite({p(0), 0, 0}, {v(0), 0, 0}, {p(0.5), 0, 0}, {v(0.5), 0, 0}, t / 0.5, 0.5).x,
                p(t), 1e-14);
}

// A steady rotation about one axis: half way in time is half way round.
TEST(Hermite, TurnsSteadilyAboutAnAxis) {
  const Vec3 omega{0.0, 0.0, 2.0};
  const Quat q0(1, 0, 0, 0), q1 = core::rotation_by({0, 0, 1.0});
  const Quat middle = hermite(q0, omega, q1, omega, 0.5, 0.5);
  EXPECT_NEAR(core::rotation_vector(middle).z, 0.5, 1e-14);
}

TEST(SiteBuffer, AGuessBeyondTheNewestStateEndsAtRest) {
  SiteBuffer buffer;
  Site site;
  site.fingers[0].v = {1.0, 0, 0};
  buffer.add(0.0, site);
  Site out;
  ASSERT_TRUE(buffer.at(10.0, 1, 0, out));
  // The speed dies away over kMostAhead: half of v kMostAhead is gone.
  EXPECT_NEAR(out.fingers[0].p.x, 0.5 * SiteBuffer::kMostAhead, 1e-15);
  EXPECT_NEAR(out.fingers[0].v.x, 0.0, 1e-15);
}

TEST(SiteBuffer, TakesStatesInAnyOrder) {
  SiteBuffer buffer;
  for (const double t : {0.0, 0.2, 0.1, 0.1}) {
    Site site;
    site.fingers[0].p = {t, 0, 0};
    site.fingers[0].v = {1, 0, 0};
    buffer.add(t, site);
  }
  Site out;
  ASSERT_TRUE(buffer.at(0.05, 1, 0, out));
  EXPECT_NEAR(out.fingers[0].p.x, 0.05, 1e-15);
}

TEST(PlaybackClock, DrawsABufferBehindAndNeverBackwards) {
  PlaybackClock clock(0.020);
  double before = -1e9;
  for (int k = 0; k < 2000; ++k) {
    // Packets every 8 ms, 5 ms on the way, every seventh 4 ms more.
    const double sent = 0.008 * k, now = sent + 0.005 + (k % 7 == 0 ? 0.004 : 0.0);
    clock.arrived(sent, now);
    const double shown = clock.at(now);
    EXPECT_GE(shown, before);
    before = shown;
    // After a while: the quickest packets' way, 5 ms, and the buffer; the offset is let go by
    // 2 ms a second between quick packets, 0.1 ms here at most.
    if (k > 100) {
      EXPECT_NEAR(now - shown, 0.025, 2e-4);
    }
  }
}

struct Shown {
  double worst_error = 0.0, worst_jump = 0.0, widest_error_box = 0.0, guessed = 0.0;
};

/// Two users carry the box in virtual time; snapshots of replica 1 go over a lossy modelled link to
/// a spectator that draws at 60 Hz. What it draws is compared with what the replica had.
Shown watch(double loss, double jitter_ticks) {
  const core::Scene scene = scene::load_scene("box_distributed");
  distributed::DistributedLoop<core::PlaneWorld> loop(scene);
  SpectatorPicture picture(scene, 0);
  core::LinkModelParameters way;
  way.delay_ticks = 20;
  way.loss = loss;
  way.jitter = core::JitterKind::kUniform;
  way.jitter_ticks = jitter_ticks;
  way.seed = 7;
  core::LinkModel<core::StatePacket> link(way);

  const double T = scene.tick();
  std::vector<Vec3> box, finger;  // the truth, by slot
  Shown shown;
  Vec3 last{0.0};
  double last_time = -1.0;
  std::uint64_t sequence = 0;
  double next_picture = 0.5;
  for (int k = 0; k < 12 * 1024; ++k) {
    loop.tick();
    const auto& law = loop.law(0);
    const core::PlaneBody& b = law.object(0);
    box.push_back({b.p.x, b.p.y, 0});
    finger.push_back({law.site().fingers[0].p.x, law.site().fingers[0].p.y, 0});
    if (k % 8 == 0) {
      core::TappedTick tick;
      tick.tick.slot = k;
      for (int f = 0; f < 2; ++f) {
        tick.tick.hands[f] = {core::to_vec3(law.site().fingers[f].p),
                              core::to_vec3(law.site().fingers[f].v)};
      }
      const double values[] = {b.p.x, b.p.y, b.angle, b.v.x, b.v.y, b.omega};
      std::copy(std::begin(values), std::end(values), tick.tick.objects[0].begin());
      core::StatePacket packet;
      core::pack_spectator(tick, picture.layout(), packet);
      packet.sender = 0;
      packet.sequence = ++sequence;
      link.push(packet, k);
    }
    link.deliver(k, [&](const core::StatePacket& p, std::int64_t, std::uint64_t) {
      picture.take(p, k * T);
    });
    const double now = k * T;
    if (now < next_picture) continue;
    next_picture += 1.0 / 60.0;
    Snapshot seen;
    if (!picture.at(now, seen)) continue;
    // The truth at the time that is drawn, between its ticks.
    const double slot = seen.time / T;
    const auto i = static_cast<std::size_t>(slot);
    const Vec3 truth = box[i] + (box[i + 1] - box[i]) * (slot - static_cast<double>(i));
    const Vec3 truth_f = finger[i] + (finger[i + 1] - finger[i]) * (slot - static_cast<double>(i));
    shown.worst_error =
        std::max({shown.worst_error, glm::length(seen.sites[0].fingers[0].p - truth_f)});
    shown.widest_error_box =
        std::max(shown.widest_error_box, glm::length(seen.sites[0].objects[0].p - truth));
    // A jump: more than the truth moved in that time.
    if (last_time >= 0.0) {
      const auto j = static_cast<std::size_t>(last_time / T);
      const double moved = glm::length(seen.sites[0].objects[0].p - last);
      shown.worst_jump = std::max(shown.worst_jump, moved - glm::length(box[i] - box[j]));
    }
    last = seen.sites[0].objects[0].p;
    last_time = seen.time;
  }
  return shown;
}

// Hermite between samples 8 ticks apart: error (h^4 / 384) x'''' (h = 7.8 ms). The carry, 50 mm at
// 2 rad/s, gives 8e-12 m; what is left is contact, 30-70 Hz of some hundredths of a millimetre.
TEST(Spectator, DrawsWhatTheReplicaHadOverAPerfectWay) {
  const Shown s = watch(0.0, 0.0);
  RecordProperty("box_error_m", std::to_string(s.widest_error_box));
  RecordProperty("finger_error_m", std::to_string(s.worst_error));
  EXPECT_LT(s.widest_error_box, 1e-4);
  EXPECT_LT(s.worst_error, 4e-4);
}

// One lost packet doubles the span, which Hermite still bridges; a buffer of 2.5 packets runs dry
// only when three in a row are lost (once in 8000), and then the guess is led back without a step.
TEST(Spectator, DoesNotJumpUnderFivePercentLossAndJitter) {
  const Shown s = watch(0.05, 4.0);
  RecordProperty("box_error_m", std::to_string(s.widest_error_box));
  RecordProperty("jump_m", std::to_string(s.worst_jump));
  EXPECT_LT(s.widest_error_box, 3e-4);
  // The drawn time may go a tenth faster than the true one: 0.1 m/s / 60 / 10 and the error above.
  EXPECT_LT(s.worst_jump, 4e-4);
}

}  // namespace
}  // namespace tandem::view
