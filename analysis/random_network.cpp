#include "analysis/random_network.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>

#include "analysis/growth.h"
#include "analysis/lifted.h"
#include "analysis/packet_fates.h"
#include "analysis/period_probe.h"
#include "analysis/with_loop.h"

namespace tandem::analysis {

namespace {

struct Link {
  int from = 0, to = 0;
  PacketFates fates;
};

/// What one packet of a link may meet: its delay, or loss.
struct Outcome {
  core::PacketFate fate;
  double in_good = 0.0, in_burst = 0.0;  ///< chance by the link's state when it is sent
};

std::vector<Outcome> outcomes_of(const PacketFates& f) {
  std::vector<Outcome> out;
  for (const PacketFates::Delay& d : f.delays)
    out.push_back({{.given = true, .lost = false, .delay_ticks = static_cast<double>(d.ticks)},
                   (1.0 - f.loss) * d.probability,
                   0.0});
  if (f.loss > 0.0 || f.has_bursts())
    out.push_back({{.given = true, .lost = true, .delay_ticks = 0.0}, f.loss, 1.0});
  std::erase_if(out, [](const Outcome& o) { return o.in_good + o.in_burst <= 0.0; });
  return out;
}

/// A direction of moving alike, taken out of a map between two modes: in both it is one at every
/// position, and the first hand's position is the pivot.
Matrix without_translation(const Matrix& m, const std::vector<double>& before,
                           const std::vector<double>& after) {
  const std::vector<double> moved = multiply(m, before);
  double largest = 1.0;
  for (const double x : m.values) largest = std::max(largest, std::abs(x));
  for (int i = 0; i < m.rows; ++i)
    if (!(std::abs(moved[i] - after[i]) <= 1e-10 * largest))
      throw std::domain_error(
          "the scene has no spring to the ground, yet moving everything alike does not move "
          "everything alike: a coupler breaks translation invariance");
  Matrix r(m.rows - 1, m.cols - 1);
  for (int i = 1; i < m.rows; ++i)
    for (int j = 1; j < m.cols; ++j) r(i - 1, j - 1) = m(i, j) - after[i] * m(0, j);
  return r;
}

/// Follows a loop through every way its packets can fare.
template <typename Loop>
class Explorer {
 public:
  Explorer(Loop loop, const core::Scene& scene, const core::NetworkModel& network,
           const RandomSessionLimits& limits)
      : scene_(scene), limits_(limits) {
    loop.visit_links([&](int from, int to, auto&) {
      const FatesOfLink link = fates_of(network.link[from][to]);
      if (!link.why.empty()) out_.why_not = link.why;
      links_.push_back({from, to, link.fates});
    });
    if (scene.reconstruction.kind != core::ReconstructionKind::kHold)
      out_.why_not = "extrapolation depends on how old a sample is, which no loss bounds";
    for (const int phase : network.phase_ticks)
      if (phase != 0) out_.why_not = "packets leave at different phases";
    if (network.packet_timer != core::PacketTimer::kForceLoop)
      out_.why_not = "packets leave between ticks";
    if (out_.why_not.empty()) explore(std::move(loop));
  }

  [[nodiscard]] RandomSession take() { return std::move(out_); }

 private:
  using Pattern = std::vector<std::int64_t>;
  struct Flight {
    Loop loop;
    std::vector<std::pair<int, int>> next;  ///< for each joint outcome: map, number of the pattern
    std::vector<double> moved;              ///< everything moved alike
  };

  void set_fates(Loop& loop, int joint) const {
    std::size_t l = 0;
    loop.visit_links([&](int, int, auto& port) {
      const auto& all = outcomes_[l++];
      port.link().set_fate(all[static_cast<std::size_t>(joint) % all.size()].fate);
      joint /= static_cast<int>(all.size());
    });
  }

  /// What the loop does next depends on the tick's place in the repeat and what is in flight.
  [[nodiscard]] Pattern key_of(Loop& loop) const {
    const std::int64_t now = loop.slot();
    Pattern key{now % loop.packet_slots().ticks};
    loop.visit_links([&](int, int, auto& port) {
      key.push_back(port.link().in_flight());
      port.link().visit_flights([&](std::int64_t sent, double arrival) {
        key.push_back(now - sent);
        key.push_back(static_cast<std::int64_t>(std::ceil(arrival)) - now);
      });
    });
    return key;
  }

  /// Number of the pattern a loop stands in; a new one if it is.
  int enter(const Loop& loop) {
    Loop copy = loop;
    const auto [found, is_new] = known_.emplace(key_of(copy), static_cast<int>(flights_.size()));
    if (is_new) {
      std::vector<double> moved;
      for (const StateEntry& e : states_of(copy))
        moved.push_back(e.kind == StateKind::kPosition ? 1.0 : 0.0);
      flights_.push_back({std::move(copy), {}, std::move(moved)});
    }
    return found->second;
  }

  void explore(Loop loop) {
    joint_count_ = 1;
    double joint = 1.0;
    for (const Link& link : links_) {
      outcomes_.push_back(outcomes_of(link.fates));
      joint *= static_cast<double>(outcomes_.back().size());
      if (link.fates.has_bursts()) bursty_.push_back(static_cast<int>(&link - links_.data()));
    }
    if (joint > limits_.maps || bursty_.size() > 10)
      return refuse(joint, "ways for the packets of one period to fare");
    joint_count_ = static_cast<int>(joint);
    for (int i = 0; i < 64; ++i) {  // links filled, with what is least delayed
      set_fates(loop, 0);
      loop.advance_packet_period();
    }
    const bool grounded = has_spring_to_ground(scene_);
    (void)enter(loop);
    for (std::size_t p = 0; p < flights_.size(); ++p) {
      if (flights_.size() > static_cast<std::size_t>(limits_.modes))
        return refuse(static_cast<double>(flights_.size()), "sets of packets in flight and more");
      for (int j = 0; j < joint_count_; ++j) {
        if (out_.system.maps.size() >= static_cast<std::size_t>(limits_.maps))
          return refuse(static_cast<double>(limits_.maps), "maps and more");
        Loop start = flights_[p].loop;
        set_fates(start, j);
        PeriodProbe<Loop> probe(start, 1.0);
        Matrix map = probe.map();
        start.advance_packet_period();
        const int to = enter(start);
        if (!grounded) map = without_translation(map, flights_[p].moved, flights_[to].moved);
        flights_[p].next.emplace_back(static_cast<int>(out_.system.maps.size()), to);
        out_.system.maps.push_back(std::move(map));
      }
    }
    if (!grounded) out_.removed.emplace_back("translation x");
    jumps(grounded ? 0 : 1);
  }

  /// Modes are patterns times the burst states of the links that have them.
  void jumps(int taken_out) {
    const int bursts = 1 << bursty_.size();
    JumpSystem& s = out_.system;
    s.period = static_cast<int>(flights_.front().loop.packet_slots().packets);
    for (const Flight& f : flights_)
      for (int b = 0; b < bursts; ++b)
        s.states.push_back(static_cast<int>(f.moved.size()) - taken_out);
    double work = 0.0;
    for (std::size_t p = 0; p < flights_.size(); ++p)
      for (int b = 0; b < bursts; ++b)
        for (int after = 0; after < bursts; ++after)
          for (int j = 0; j < joint_count_; ++j) {
            const double chance = chance_of(b, after, j);
            if (chance <= 0.0) continue;
            const auto [map, to] = flights_[p].next[j];
            s.jumps.push_back({static_cast<int>(p) * bursts + b, to * bursts + after, map, chance});
            work += std::pow(static_cast<double>(flights_[p].moved.size()), 3);
          }
    if (100.0 * work > limits_.work) refuse(work, "multiplications a step");
  }

  /// The chain moves on first, then the packet of the period fares by where it is.
  [[nodiscard]] double chance_of(int before, int after, int joint) const {
    double chance = 1.0;
    for (std::size_t l = 0; l < links_.size(); ++l) {
      const PacketFates& f = links_[l].fates;
      const auto bit = std::find(bursty_.begin(), bursty_.end(), static_cast<int>(l));
      bool in_burst = false;
      if (bit != bursty_.end()) {
        const int shift = static_cast<int>(bit - bursty_.begin());
        const bool was = (before >> shift & 1) != 0;
        in_burst = (after >> shift & 1) != 0;
        const double leaves = was ? f.burst_leave : 1.0 - f.burst_enter;
        chance *= in_burst ? 1.0 - leaves : leaves;
      }
      const auto& all = outcomes_[l];
      const Outcome& o = all[static_cast<std::size_t>(joint) % all.size()];
      joint /= static_cast<int>(all.size());
      chance *= in_burst ? o.in_burst : o.in_good;
    }
    return chance;
  }

  void refuse(double count, const char* of_what) {
    const auto rounded = static_cast<long long>(std::min(count, 1e15));
    out_.why_not = "too many to lift exactly: " + std::to_string(rounded) + " " + of_what;
  }

  const core::Scene& scene_;
  const RandomSessionLimits& limits_;
  std::vector<Link> links_;
  std::vector<std::vector<Outcome>> outcomes_;
  std::vector<int> bursty_;
  int joint_count_ = 1;
  std::map<Pattern, int> known_;
  std::vector<Flight> flights_;
  RandomSession out_;
};

/// The network with other seeds for every link.
core::NetworkModel reseeded(core::NetworkModel network, std::uint64_t seed) {
  core::Random seeds(seed);
  for (auto& row : network.link)
    for (core::LinkModelParameters& link : row) link.seed = seeds.bits();
  return network;
}

/// Sum of the logarithms of growth over the counted packets of one run.
template <typename Loop>
double growth_of_run(Loop loop, const LyapunovOptions& options, bool grounded, double amplitude,
                     std::uint64_t seed) {
  for (int i = 0; i < 64; ++i) loop.advance_packet_period();
  // The rest, over the same network: fates do not depend on the states.
  Loop rest = loop;
  std::vector<double> reference = values_of(rest), d(reference.size());
  core::Random random(seed);
  for (double& x : d) x = random.normal();
  double sum = 0.0;
  for (int k = 0; k < options.settle + options.packets; ++k) {
    if (!grounded)
      for (const Symmetry& s : candidate_symmetries(states_of(rest), reference)) remove(s, d);
    const double norm = detail::norm_of(d);
    if (norm == 0.0) return -std::numeric_limits<double>::infinity();
    if (!std::isfinite(norm)) return std::numeric_limits<double>::infinity();
    if (k >= options.settle) sum += std::log(norm);
    for (double& x : d) x /= norm;
    detail::set_deviation(loop, reference, d, amplitude);
    loop.advance_packet_period();
    rest.advance_packet_period();
    reference = values_of(rest);
    d.resize(reference.size());
    detail::get_deviation(loop, reference, d, amplitude);
  }
  return sum;
}

}  // namespace

RandomSession random_session(const core::Scene& scene, const core::NetworkModel& network,
                             const RandomSessionLimits& limits) {
  if (scene.space != core::Space::kAxis)
    throw std::domain_error("field space: only AXIS scenes are lifted over random networks");
  return with_loop_of<core::AxisWorld>(scene, network, [&](auto& loop) {
    using Loop = std::remove_reference_t<decltype(loop)>;
    return Explorer<Loop>(loop, scene, network, limits).take();
  });
}

Lyapunov sampled_exponent(const core::Scene& scene, const core::NetworkModel& network,
                          const LyapunovOptions& options) {
  if (scene.space == core::Space::kSpace)
    throw std::domain_error("field space: SPACE has no linear analysis; AXIS and PLANE have");
  Lyapunov out;
  out.runs = options.runs;
  out.packets = options.packets;
  core::Random seeds(options.seed);
  const bool grounded = has_spring_to_ground(scene);
  std::vector<double> means;
  for (int run = 0; run < options.runs; ++run) {
    const core::NetworkModel own = reseeded(network, seeds.bits());
    const std::uint64_t seed = seeds.bits();
    const double sum =
        scene.space == core::Space::kAxis
            ? with_loop_of<core::AxisWorld>(
                  scene, own,
                  [&](auto& loop) { return growth_of_run(loop, options, grounded, 1.0, seed); })
            : with_loop_of<core::PlaneWorld>(scene, own, [&](auto& loop) {
                return growth_of_run(loop, options, grounded, 1e-6, seed);
              });
    means.push_back(sum / options.packets);
    if (options.progress && !options.progress(run + 1, options.runs))
      throw std::runtime_error("interrupted");
  }
  for (const double m : means) out.exponent += m / options.runs;
  double squares = 0.0;
  for (const double m : means) squares += (m - out.exponent) * (m - out.exponent);
  out.half_width =
      student_quantile(options.runs - 1) * std::sqrt(squares / (options.runs - 1.0) / options.runs);
  return out;
}

double student_quantile(int degrees) {
  if (degrees < 1) return std::numeric_limits<double>::infinity();
  constexpr double kExact[] = {12.706, 4.3027, 3.1824};
  if (degrees <= 3) return kExact[degrees - 1];
  // Cornish and Fisher around the normal quantile; below 0.3 % off from 4 degrees on.
  constexpr double z = 1.959963984540054;
  const double v = degrees, z3 = z * z * z, z5 = z3 * z * z, z7 = z5 * z * z;
  return z + (z3 + z) / (4.0 * v) + (5.0 * z5 + 16.0 * z3 + 3.0 * z) / (96.0 * v * v) +
         (3.0 * z7 + 19.0 * z5 + 17.0 * z3 - 15.0 * z) / (384.0 * v * v * v);
}

}  // namespace tandem::analysis
