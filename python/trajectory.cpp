#include "python/trajectory.h"

#include "analysis/with_loop.h"

namespace tandem::python {
namespace {

void append_pose(const core::AxisState& b, std::vector<double>& out) { out.push_back(b.p); }
void append_pose(const core::PlaneBody& b, std::vector<double>& out) {
  out.insert(out.end(), {b.p.x, b.p.y, b.angle});
}
void append_pose(const core::SpaceBody& b, std::vector<double>& out) {
  out.insert(out.end(), {b.p.x, b.p.y, b.p.z, b.q.w, b.q.x, b.q.y, b.q.z});
}

template <typename Vector>
void append(const Vector& v, std::vector<double>& out) {
  for (int i = 0; i < core::kComponents<Vector>; ++i) out.push_back(core::component(v, i));
}

}  // namespace

Trajectory run_session(const core::Scene& scene, const core::NetworkModel& network, double seconds,
                       int every, const std::function<bool()>& go_on) {
  Trajectory t;
  t.users = scene.users.size();
  t.objects = scene.objects.size();
  t.pose_width = scene.space == core::Space::kAxis ? 1 : scene.space == core::Space::kPlane ? 3 : 7;
  for (const core::UserParameters& user : scene.users)
    for (const core::FingerParameters& finger : user.fingers)
      t.fingers.push_back(user.name + "." + finger.name);
  analysis::with_loop(scene, network, [&](auto& loop) {
    using Loop = std::remove_reference_t<decltype(loop)>;
    t.components = core::kComponents<typename Loop::Vector>;
    // Time from the tick count, never summed up.
    const auto ticks = static_cast<std::int64_t>(seconds * scene.rates.local_hz + 0.5);
    for (std::int64_t k = 1; k <= ticks; ++k) {
      loop.tick();
      if (k % 1024 == 0 && !go_on()) break;
      if (k % every != 0) continue;
      t.time.push_back(loop.time());
      for (int u = 0; u < loop.user_count(); ++u) {
        for (std::size_t o = 0; o < t.objects; ++o)
          append_pose(loop.object(u, static_cast<int>(o)), t.poses);
        for (int f = 0; f < loop.hands().count(u); ++f) {
          append(loop.hands().finger(u, f).position(), t.positions);
          append(loop.output(u).forces[f], t.forces);
        }
      }
    }
    t.sent = loop.packets_sent();
    t.accepted = loop.packets_accepted();
  });
  return t;
}

}  // namespace tandem::python
