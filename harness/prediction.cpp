#include "harness/prediction.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

#include <fmt/format.h>

#include "analysis/drag.h"
#include "analysis/lifted.h"
#include "analysis/resampled.h"
#include "analysis/response.h"
#include "analysis/stability.h"
#include "harness/tasks.h"

namespace tandem::harness {

namespace {

using analysis::LiftedSystem;
using core::NetworkModel;
using core::Scene;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
/// Calls `change` with every link that the scene uses.
template <typename Change>
void each_link(const Scene& scene, NetworkModel& network, Change&& change) {
  const int users = static_cast<int>(scene.users.size());
  constexpr int kServer = NetworkModel::kServer;
  for (int i = 0; i < users; ++i) {
    if (scene.architecture == core::Architecture::kCentral) {
      if (scene.users[i].local) continue;
      change(network.link[i][kServer]);
      change(network.link[kServer][i]);
      continue;
    }
    for (int j = 0; j < users; ++j)
      if (j != i) change(network.link[i][j]);
  }
}

/// Delays in whole ticks, and how ages are reckoned; nothing else.
template <typename Round>
NetworkModel whole_ticks(const Scene& scene, const NetworkModel& network, Round&& round) {
  NetworkModel out;
  out.phase_ticks = network.phase_ticks;
  out.link = network.link;
  each_link(scene, out, [&](core::LinkModelParameters& link) {
    core::LinkModelParameters steady;
    steady.delay_ticks = std::max(0.0, round(link.delay_ticks));
    steady.age_error_ticks = link.age_error_ticks;
    link = steady;
  });
  return out;
}

double nearest(double x) { return std::floor(x + 0.5); }
/// A hair above a whole tick is that tick.
double up(double x) { return std::ceil(x - 1e-6); }

/// The route by forces, where it applies, has fewer states.
LiftedSystem lift(const Scene& scene, const NetworkModel& network) {
  return analysis::why_not_resampled(scene, network).empty()
             ? analysis::resampled_system(scene, network)
             : analysis::measured_system(scene, network);
}

bool fits(const Scene& scene, const NetworkModel& network) {
  double longest = 0.0;
  NetworkModel copy = network;
  each_link(scene, copy, [&](const core::LinkModelParameters& link) {
    longest = std::max(longest, link.delay_ticks);
  });
  return longest / scene.ticks_per_packet() < 60.0;  // of the modelled link's 64 packets
}

double drag_at(const Scene& linear, const NetworkModel& network) {
  const int user = analysis::drag_user(linear);
  const Scene alone = analysis::with_one_hand(linear, linear.users[user].name);
  const LiftedSystem system = lift(alone, network);
  if (system.grounded) return kNaN;
  const auto& who = alone.users[user];
  return analysis::free_motion(system,
                               analysis::port_named(system, who.name + "." + who.fingers[0].name))
      .mean_damping;
}

bool moves_coupling(const Scene& scene, const core::CouplerParameters& c) {
  if (scene.architecture != core::Architecture::kCentral) return c.user.empty();
  const int u = core::index_of(scene.users, c.user);
  return u >= 0 && !scene.users[u].local;
}

/// Upper end of the stable interval around the coupling or, where that is not stable, of the next
/// one below.
double interval_end(const Scene& linear, const NetworkModel& network, int states,
                    double precision = 1.0 + 1e-4) {
  const double now = coupling_of(linear);
  if (!(now > 0.0)) return kNaN;
  analysis::StabilityJudge judge(linear, network);
  // Large maps cost seconds: a coarser scan.
  const double ratio = states > 120 ? 1.6 : states > 60 ? 1.3 : 1.12;
  return largest_stable(now, ratio, precision,
                        [&](double k) { return judge.margin(with_coupling(linear, k)) > 0.0; });
}

/// Two networks of whole ticks, and where the one in question lies between them, in the mean of the
/// links that are between: 0 is below.
struct Between {
  NetworkModel below, above;
  double share = 0.0;
};

/// Closer to a whole tick than a twentieth is that tick.
Between between(const Scene& scene, const NetworkModel& network) {
  constexpr double kSnap = 0.05;
  Between out;
  const auto snapped = [](double x) { return std::abs(x - nearest(x)) < kSnap ? nearest(x) : x; };
  out.below = whole_ticks(scene, network, [&](double x) { return std::floor(snapped(x)); });
  out.above = whole_ticks(scene, network, [&](double x) { return std::ceil(snapped(x)); });
  int links = 0;  // that are between
  NetworkModel copy = network;
  each_link(scene, copy, [&](const core::LinkModelParameters& link) {
    const double x = snapped(link.delay_ticks);
    if (x == std::floor(x)) return;
    out.share += x - std::floor(x);
    ++links;
  });
  if (links > 0) out.share /= links;
  return out;
}

/// Boundaries of two networks, and one between: largest couplings go about as one over the delay.
double coupling_between(double below, double above, double share) {
  if (share <= 0.0) return below;
  if (!(below > 0.0) || !(above > 0.0)) return share < 0.5 ? below : above;
  return 1.0 / ((1.0 - share) / below + share / above);  // infinite ones are 0 here
}

bool is_stable(const Scene& linear, const NetworkModel& network) {
  return analysis::judge(lift(linear, network)).stable();
}

bool is_near_boundary(const Scene& linear, const NetworkModel& network, bool stable) {
  for (const double factor : {0.9, 1.1}) {
    if (is_stable(with_coupling(linear, factor * coupling_of(linear)), network) != stable)
      return true;
    NetworkModel later = network;
    double change = 0.0;
    each_link(linear, later, [&](core::LinkModelParameters& link) {
      const double d = nearest(factor * link.delay_ticks);
      change += std::abs(d - link.delay_ticks);
      link.delay_ticks = d;
    });
    if (change == 0.0) {  // at least a tick of one direction
      bool done = false;
      each_link(linear, later, [&](core::LinkModelParameters& link) {
        if (done || (factor < 1.0 && link.delay_ticks < 1.0)) return;
        link.delay_ticks += factor < 1.0 ? -1.0 : 1.0;
        done = linear.users.size() == 2;
      });
    }
    if (fits(linear, later) && is_stable(linear, later) != stable) return true;
  }
  return false;
}

}  // namespace

std::string coupling_name(const Scene& scene) {
  return scene.architecture == core::Architecture::kCentral ? "k_2" : "k_o";
}

double coupling_of(const Scene& scene) {
  for (const auto& c : scene.couplers)
    if (moves_coupling(scene, c)) return c.gain.stiffness;
  return kNaN;
}

Scene with_coupling(Scene scene, double stiffness) {
  const double factor = stiffness / coupling_of(scene);
  for (auto& c : scene.couplers)
    if (moves_coupling(scene, c)) {
      c.gain.stiffness *= factor;
      c.tangential.stiffness *= factor;
      c.rotation.stiffness *= factor;
    }
  return scene;
}

double largest_stable(double now, double ratio, double precision,
                      const std::function<bool(double)>& stable) {
  constexpr double kRange = 64.0;
  double low = now, high = now;
  if (stable(now)) {
    for (;;) {
      if (low >= now * kRange) return std::numeric_limits<double>::infinity();
      high = std::min(low * ratio, now * kRange);
      if (!stable(high)) break;
      low = high;
    }
  } else {
    for (;;) {
      if (high <= now / kRange) return 0.0;
      low = std::max(high / ratio, now / kRange);
      if (stable(low)) break;
      high = low;
    }
  }
  while (high > precision * low) {
    const double middle = std::sqrt(low * high);
    (stable(middle) ? low : high) = middle;
  }
  return std::sqrt(low * high);
}

bool stable_alone(const Scene& scene, const NetworkModel& given) {
  try {
    const Scene linear = analysis::linear_scene(scene).scene;
    const Scene alone =
        analysis::with_one_hand(linear, linear.users[analysis::drag_user(linear)].name);
    return is_stable(alone, whole_ticks(alone, given, nearest));
  } catch (const std::exception&) {
    return false;
  }
}

double predicted_coupling(const Scene& scene, const NetworkModel& network) {
  try {
    const Scene linear = analysis::linear_scene(scene).scene;
    const Between b = between(linear, network);
    if (!fits(linear, b.above)) return kNaN;
    const int states = lift(linear, b.below).states();
    const double below = interval_end(linear, b.below, states, 1.001);
    return b.share <= 0.0
               ? below
               : coupling_between(below, interval_end(linear, b.above, states, 1.001), b.share);
  } catch (const std::exception&) {
    return kNaN;
  }
}

double predicted_drag(const Scene& scene, const NetworkModel& network) {
  if (scene.space != core::Space::kAxis || scene.objects.empty()) return kNaN;
  try {
    const Scene linear = analysis::linear_scene(scene).scene;
    const Between b = between(linear, network);
    const double below = drag_at(linear, b.below);
    return b.share <= 0.0 ? below : below + b.share * (drag_at(linear, b.above) - below);
  } catch (const std::exception&) {
    return kNaN;
  }
}

double predicted_stiffness(const Scene& scene, const NetworkModel& network) {
  if (scene.space != core::Space::kAxis || scene.objects.empty()) return kNaN;
  try {
    const Scene linear = analysis::linear_scene(scene).scene;
    const int user = analysis::drag_user(linear);
    // The mover's own muscle is not what it feels.
    Scene held = linear;
    held.users[user].fingers[0].hand = {};
    const LiftedSystem system = lift(held, whole_ticks(held, network, nearest));
    if (!system.grounded) return kNaN;
    const auto& who = held.users[user];
    return analysis::equivalent_stiffness(
        system, analysis::port_named(system, who.name + "." + who.fingers[0].name));
  } catch (const std::exception&) {
    return kNaN;
  }
}

double predicted_delay_boundary(const Scene& scene, double longest) {
  const Scene linear = analysis::linear_scene(scene).scene;
  const int last = static_cast<int>(longest / scene.tick() + 0.5);
  for (int d = 0; d <= last; ++d) {
    NetworkModel network;
    each_link(linear, network, [&](core::LinkModelParameters& link) { link.delay_ticks = d; });
    if (!fits(linear, network)) break;
    if (!is_stable(linear, network)) return d * scene.tick();
  }
  return std::numeric_limits<double>::infinity();
}

Prediction predict(const Scene& scene, const NetworkModel& given, const PredictOptions& options) {
  Prediction p;
  p.coupling = coupling_of(scene);
  try {
    const analysis::LinearScene made = analysis::linear_scene(scene);
    const Scene& linear = made.scene;
    p.note = fmt::format("{}", fmt::join(made.assumptions, "; "));
    const NetworkModel network = whole_ticks(linear, given, nearest);
    if (!fits(linear, network)) {
      p.note = "more packets in flight than a modelled link holds";
      return p;
    }
    const LiftedSystem system = lift(linear, network);
    const analysis::Judgement judged = analysis::judge(system);
    p.stable = judged.stable();
    p.growth_per_packet = judged.radius;
    p.judged = true;
    // Where one hand alone is not stable there is no steady motion to feel a drag in; but a
    // negative drag is an instability of its own, slow, and felt.
    const double drag = predicted_drag(scene, given);
    if (drag < 0.0 || stable_alone(scene, given)) p.drag = drag;
    if (scene.space == core::Space::kAxis)
      p.stiffness = predicted_stiffness(touched(scene, analysis::drag_user(scene)), given);
    if (options.largest_coupling)
      p.largest_coupling = interval_end(linear, network, system.states());
    p.near_boundary = is_near_boundary(linear, network, p.stable);
    if (options.between_ticks) {
      const Between b = between(linear, given);
      if (b.share > 0.0) {
        p.near_boundary =
            p.near_boundary || is_stable(linear, b.below) != is_stable(linear, b.above);
        if (options.largest_coupling)
          p.largest_coupling =
              coupling_between(interval_end(linear, b.below, system.states()),
                               interval_end(linear, b.above, system.states()), b.share);
      }
    }
  } catch (const std::exception& e) {
    p.judged = false;
    p.note = e.what();
  }
  return p;
}

double mean_age(const Scene& scene, const NetworkModel& steady) {
  NetworkModel network = steady;
  double sum = 0.0;
  int links = 0;
  each_link(scene, network, [&](const core::LinkModelParameters& link) {
    sum += link.delay_ticks;
    ++links;
  });
  const double waiting = 0.5 * (scene.ticks_per_packet() - 1);
  return (links > 0 ? sum / links + waiting : 0.0) * scene.tick();
}

bool is_steady(const NetworkModel& network) {
  for (const auto& row : network.link)
    for (const auto& link : row)
      if (link.jitter != core::JitterKind::kNone || link.loss > 0.0 || link.burst_enter > 0.0 ||
          link.duplicate > 0.0 || link.reorder > 0.0 || link.service_ticks > 0.0 ||
          link.outage_length > 0 || !link.recorded.empty())
        return false;
  return true;
}

NetworkModel steady_network(const Scene& scene, const NetworkModel& network, int packets) {
  NetworkModel out = network;
  const core::PacketSlots slots = scene.packet_slots();
  const auto mean_delay = [&](core::LinkModelParameters p) {
    p.outage_length = 0;
    core::LinkModel<int> link(p);
    std::uint64_t newest = 0;
    std::int64_t sent = 0;
    double sum = 0.0;
    std::int64_t ticks = 0;
    for (std::int64_t slot = 0; slot < slots.tick_of(packets); ++slot) {
      if (slots.sends(slot)) link.push(0, slot);
      link.deliver(slot, [&](int, std::int64_t send_slot, std::uint64_t sequence) {
        if (sequence <= newest) return;
        newest = sequence;
        sent = send_slot;
      });
      if (newest == 0) continue;
      sum += static_cast<double>(slot - sent);
      ++ticks;
    }
    // A steady link of d ticks has a mean age of d + (N - 1) / 2.
    const double waiting = 0.5 * (scene.ticks_per_packet() - 1.0);
    return ticks > 0 ? std::max(0.0, sum / static_cast<double>(ticks) - waiting) : 0.0;
  };
  // Links of one direction differ in their seed only: one of each will do, but for the recorded.
  std::vector<std::pair<core::LinkModelParameters, double>> known;
  each_link(scene, out, [&](core::LinkModelParameters& link) {
    const auto alike = [&](const core::LinkModelParameters& a) {
      return a.delay_ticks == link.delay_ticks && a.jitter == link.jitter &&
             a.jitter_ticks == link.jitter_ticks && a.loss == link.loss &&
             a.burst_enter == link.burst_enter && a.burst_leave == link.burst_leave &&
             a.burst_loss == link.burst_loss && a.reorder == link.reorder &&
             a.service_ticks == link.service_ticks && a.recorded.data() == link.recorded.data();
    };
    const auto become_steady = [&](double delay) {
      core::LinkModelParameters simple;
      simple.delay_ticks = delay;
      simple.age_error_ticks = link.age_error_ticks;
      link = simple;
    };
    for (const auto& [parameters, delay] : known)
      if (alike(parameters)) return become_steady(delay);
    const bool steady = link.jitter == core::JitterKind::kNone && link.loss == 0.0 &&
                        link.burst_enter == 0.0 && link.reorder == 0.0 &&
                        link.service_ticks == 0.0 && link.recorded.empty();
    const double delay = steady ? up(link.delay_ticks) : mean_delay(link);
    known.emplace_back(link, delay);
    become_steady(delay);
  });
  return out;
}

}  // namespace tandem::harness
