#include "harness/virtual_run.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <exception>
#include <mutex>
#include <numeric>
#include <stdexcept>
#include <thread>

#include "analysis/drag.h"
#include "analysis/with_loop.h"
#include "harness/tasks.h"

namespace tandem::harness {

namespace {

using core::NetworkModel;
using core::Scene;

core::Vec3 centre(const core::AxisState& b) { return {b.p, 0.0, 0.0}; }
core::Vec3 centre(const core::PlaneBody& b) { return {b.p.x, b.p.y, 0.0}; }
core::Vec3 centre(const core::SpaceBody& b) { return b.p; }
double turned(const core::AxisState&) { return 0.0; }
double turned(const core::PlaneBody& b) { return b.angle; }
double turned(const core::SpaceBody&) { return 0.0; }

template <typename Loop>
inline constexpr bool kIsCentral = requires(const Loop& loop) {
  loop.server();
};

template <typename Loop>
bool is_local(const Loop& loop, int user) {
  if constexpr (kIsCentral<Loop>)
    return loop.server().is_local(user);
  else
    return (static_cast<void>(loop), static_cast<void>(user), true);
}

/// Records one loop; energy by exact increments: a force held while what it acts on moved.
template <typename Loop>
class Recorder {
 public:
  Recorder(const Loop& loop, const Scene& scene, std::size_t ticks) {
    trajectory_.tick = scene.tick();
    trajectory_.ticks_per_packet = static_cast<int>(std::lround(scene.ticks_per_packet()));
    for (int u = 0; u < loop.user_count(); ++u) {
      SiteTrajectory site;
      site.user = scene.users[static_cast<std::size_t>(u)].name;
      site.fingers = loop.hands().count(u);
      site.has_object = !scene.objects.empty() && is_local(loop, u);
      site.has_network_energy = scene.architecture != core::Architecture::kSingle;
      site.samples.reserve(ticks);
      trajectory_.sites.push_back(std::move(site));
    }
    given_.assign(trajectory_.sites.size(), 0.0);
  }

  /// Of the tick about to be run; returns false when a number is no longer finite.
  void before(const Loop& loop) {
    for (std::size_t u = 0; u < trajectory_.sites.size(); ++u) {
      const int user = static_cast<int>(u);
      SiteTrajectory& site = trajectory_.sites[u];
      SiteSample s;
      s.slot = loop.slot();
      for (int f = 0; f < site.fingers; ++f)
        s.hand[f] = core::to_vec3(loop.hands().finger(user, f).position());
      if (site.has_object) {
        s.object = centre(loop.object(user, 0));
        s.angle = turned(loop.object(user, 0));
      }
      site.samples.push_back(s);
    }
    if constexpr (kIsCentral<Loop>)
      if (has_object()) object_before_ = loop.object(0, 0);
  }

  /// Of the same tick, now run: the forces it gave.
  bool after(const Loop& loop) {
    bool finite = true;
    for (std::size_t u = 0; u < trajectory_.sites.size(); ++u) {
      const int user = static_cast<int>(u);
      SiteTrajectory& site = trajectory_.sites[u];
      SiteSample& s = site.samples.back();
      for (int f = 0; f < site.fingers; ++f) {
        s.force[f] = core::to_vec3(loop.output(user).forces[f]);
        const core::Vec3 now = core::to_vec3(loop.hands().finger(user, f).position());
        finite = finite && std::isfinite(now.x + now.y + now.z);
        if (kIsCentral<Loop> && !is_local(loop, user))
          given_[u] += core::inner(s.force[f], now - s.hand[f]);
      }
      if constexpr (kIsCentral<Loop>) {
        if (is_local(loop, user) && has_object())
          for (int v = 0; v < loop.user_count(); ++v)
            if (!is_local(loop, v))
              given_[u] +=
                  Loop::World::work(loop.user_wrench(v, 0), object_before_, loop.object(user, 0));
        s.network_energy = given_[u];
      } else {
        s.network_energy = loop.law(user).site().energy_out - loop.law(user).site().energy_in;
      }
    }
    return finite;
  }

  [[nodiscard]] Trajectory finish(const Loop& loop, const Scene& scene) {
    const auto users = static_cast<std::int64_t>(trajectory_.sites.size());
    for (std::size_t u = 0; u < trajectory_.sites.size(); ++u) {
      SiteTrajectory& site = trajectory_.sites[u];
      std::int64_t receivers = users - 1;
      if (kIsCentral<Loop>) {
        receivers = 1;
        if (is_local(loop, static_cast<int>(u))) {
          receivers = 0;  // the server's replies leave from its first local user's machine
          for (int v = 0; v < loop.user_count() && u == 0; ++v)
            receivers += is_local(loop, v) ? 0 : 1;
        }
      }
      const std::int64_t packets =
          loop.slot() > 0 ? loop.packet_slots().packet_at(loop.slot() - 1) + 1 : 0;
      site.packets_sent = packets * receivers;
      site.bytes_sent = site.packets_sent * packet_bytes(scene);
    }
    return std::move(trajectory_);
  }

 private:
  [[nodiscard]] bool has_object() const {
    return std::any_of(trajectory_.sites.begin(), trajectory_.sites.end(),
                       [](const SiteTrajectory& s) { return s.has_object; });
  }
  Trajectory trajectory_;
  std::vector<double> given_;  ///< by the network to each site [J]
  typename Loop::World::Body object_before_{};
};

template <typename Loop>
void watch(const Loop& loop, double time, StabilityMeter& meter) {
  int which = 0;
  const auto first = loop.object(0, 0);
  for (int u = 0; u < loop.user_count(); ++u) {
    const core::Vec3 object = centre(loop.object(u, 0));
    const core::Vec3 gap = object - centre(first);
    for (int f = 0; f < loop.hands().count(u); ++f) {
      const core::Vec3 hand = core::to_vec3(loop.hands().finger(u, f).position()) - object;
      for (int i = 0; i < core::kComponents<typename Loop::Vector>; ++i)
        meter.add(time, which++, hand[i]);
    }
    for (int i = 0; i < core::kComponents<typename Loop::Vector>; ++i)
      meter.add(time, which++, gap[i]);
  }
}

double stability_seconds(double seconds) { return std::max(seconds, 2.0); }

}  // namespace

Trajectory run_virtual(const Scene& scene, const NetworkModel& network, double seconds) {
  return analysis::with_loop(scene, network, [&](auto& loop) {
    using Loop = std::remove_reference_t<decltype(loop)>;
    const auto ticks = static_cast<std::int64_t>(std::llround(seconds * scene.rates.local_hz));
    Recorder<Loop> recorder(loop, scene, static_cast<std::size_t>(ticks));
    for (std::int64_t k = 0; k < ticks; ++k) {
      recorder.before(loop);
      loop.tick();
      if (!recorder.after(loop)) break;
    }
    return recorder.finish(loop, scene);
  });
}

Stability run_stability(const Scene& scene, const NetworkModel& network, double seconds) {
  if (scene.objects.empty()) return {};
  return analysis::with_loop(scene, network, [&](auto& loop) {
    StabilityMeter meter(seconds, scene.tick() * scene.ticks_per_packet());
    constexpr int kEvery = 2;  // ticks; oscillations faster than that are no slower in their growth
    const auto ticks = static_cast<std::int64_t>(std::llround(seconds * scene.rates.local_hz));
    for (std::int64_t k = 0; k < ticks && !meter.left_bounds(); ++k) {
      if (k % kEvery == 0) watch(loop, loop.time(), meter);
      loop.tick();
    }
    return meter.judge();
  });
}

double search_largest_coupling(const Scene& scene, const NetworkModel& network, double seconds,
                               double* ran) {
  const Scene start = kicked(scene);
  const double now = coupling_of(start);
  if (!(now > 0.0)) return kNotMeasured;
  return largest_stable(now, 1.25, 1.01, [&](double k) {
    if (ran != nullptr) *ran += seconds;
    return run_stability(with_coupling(start, k), network, seconds).stable;
  });
}

double search_delay_boundary(const Scene& scene, double longest, double seconds) {
  const Scene start = kicked(scene);
  const int last = static_cast<int>(longest / scene.tick() + 0.5);
  for (int d = 0; d <= last; ++d) {
    NetworkModel network;
    for (auto& row : network.link)
      for (auto& link : row) link.delay_ticks = d;
    if (!run_stability(start, network, seconds).stable) return d * scene.tick();
  }
  return std::numeric_limits<double>::infinity();
}

Scene ideal_twin(Scene scene) {
  scene.rates.packet_hz = scene.rates.local_hz;
  scene.reconstruction.kind = core::ReconstructionKind::kHold;
  for (auto& object : scene.objects) object.compensation = object.compensation_rotation = 0.0;
  return scene;
}

PointResult run_virtual_point(const SweepPoint& point, const VirtualOptions& options) {
  const auto started = std::chrono::steady_clock::now();
  PointResult out;
  out.point = point;
  FateStore fates;
  const Scene& scene = point.scene;
  const NetworkModel network = modelled_network(point.network, scene, options.seed, fates);
  const NetworkModel ideal;
  const double seconds = stability_seconds(options.seconds);
  const bool axis = scene.space == core::Space::kAxis;

  const double carry_seconds = axis ? 7.5 : 20.0;
  {
    const Scene scene_carried = carried(scene);
    Trajectory session = run_virtual(scene_carried, network, carry_seconds);
    Trajectory twin = run_virtual(ideal_twin(scene_carried), ideal, carry_seconds);
    session.first_slot = twin.first_slot = static_cast<std::int64_t>(scene.rates.local_hz);
    out.session_seconds += 2.0 * carry_seconds;
    if (!has_blown_up(session)) out.measures = measure(session, &twin);
  }
  out.measures.stability = run_stability(kicked(scene), network, seconds);
  out.session_seconds += seconds;

  if (axis && !scene.objects.empty()) {
    const int user = analysis::drag_user(scene);
    constexpr double kPush = 0.1, kPushSeconds = 12.0;
    Trajectory push = run_virtual(pushed(scene, user, kPush), network, kPushSeconds);
    // The other hands are let go and stay behind.
    for (std::size_t u = 0; u < push.sites.size(); ++u)
      if (static_cast<int>(u) != user) push.sites[u].fingers = 0;
    if (judge_stability(push).stable) {
      const MeasuredDrag drag = measure_drag(push, user, kPush);
      out.measures.drag = drag.n_s_per_m;
      out.measures.drag_settled = drag.settled;
    }
    measure_touch(run_virtual(touched(scene, user), network, kTouchSeconds), user, out.measures);
    out.session_seconds += kPushSeconds + kTouchSeconds;
  }
  if (options.search)
    out.largest_coupling = search_largest_coupling(scene, network, seconds, &out.session_seconds);

  const bool steady = is_steady(network);
  const NetworkModel mean = steady_network(scene, network);
  PredictOptions predict_options;
  predict_options.largest_coupling = options.search;
  out.prediction = predict(scene, mean, predict_options);
  out.mean_age = mean_age(scene, mean);
  out.prediction.exact = steady;
  out.wall_seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - started).count();
  return out;
}

std::vector<PointResult> run_virtual_sweep(const Sweep& sweep, const VirtualOptions& options,
                                           const std::function<bool(int, int)>& progress) {
  const int all = static_cast<int>(sweep.points.size());
  std::vector<PointResult> results(sweep.points.size());
  // Those with most users first, or the last one would run alone.
  std::vector<int> order(sweep.points.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
    return sweep.points[a].scene.users.size() > sweep.points[b].scene.users.size();
  });
  std::atomic<int> next = 0;
  int done = 0;
  bool stopped = false;
  std::exception_ptr failure;
  std::mutex mutex;
  const auto work = [&] {
    for (int i = next++; i < all; i = next++) {
      try {
        results[order[i]] = run_virtual_point(sweep.points[order[i]], options);
      } catch (...) {
        const std::lock_guard lock(mutex);
        if (failure == nullptr) failure = std::current_exception();
        next = all;
      }
      const std::lock_guard lock(mutex);
      ++done;
      if (progress && !progress(done, all)) {
        stopped = true;
        next = all;
      }
    }
  };
  const int wanted = options.threads > 0
                         ? options.threads
                         : static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  std::vector<std::thread> threads;
  for (int i = 1; i < std::min(wanted, all); ++i) threads.emplace_back(work);
  work();
  for (std::thread& t : threads) t.join();
  if (failure != nullptr) std::rethrow_exception(failure);
  if (stopped) throw std::runtime_error("stopped");
  return results;
}

}  // namespace tandem::harness
