#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "analysis/mean_square.h"
#include "core/network_model.h"
#include "core/scene.h"

/// Stability where packets have fates of their own: loss, bursts of loss, jitter. Every matrix is
/// measured on the running loop, with the fates of the packets set (core::PacketFate).
namespace tandem::analysis {

/// The session as a system that jumps once a packet period. A mode is what is in flight at the
/// start of the period, when it arrives, and which links are in a burst; the translation is taken
/// out of every map.
struct RandomSession {
  JumpSystem system;
  std::string why_not;  ///< why there is no such system, or none of a size to handle; else empty
  std::vector<std::string> removed;
};

struct RandomSessionLimits {
  int modes = 1500;
  int maps = 6000;
  double work = 4e9;  ///< multiplications of one step of the second moment, at most, times 100
};

/// Linear axis scenes (linear_scene). Throws std::domain_error for others.
[[nodiscard]] RandomSession random_session(const core::Scene& scene,
                                           const core::NetworkModel& network,
                                           const RandomSessionLimits& limits = {});

/// Mean growth of a typical run a packet period, ln; every run of the loop draws its own fates.
struct LyapunovOptions {
  int runs = 24;
  int packets = 4000;  ///< of each run, counted after
  int settle = 400;    ///< more
  std::uint64_t seed = 1;
  /// progress(done, all); returning false stops (std::runtime_error).
  std::function<bool(int, int)> progress;
};

struct Lyapunov {
  double exponent = 0.0;    ///< a packet period; negative: runs die out, with probability one
  double half_width = 0.0;  ///< of the 95 % confidence interval (Student's t over the runs)
  int runs = 0, packets = 0;

  [[nodiscard]] bool surely_stable() const { return exponent + half_width < 0.0; }
  [[nodiscard]] bool surely_unstable() const { return exponent - half_width > 0.0; }
};

/// Sampled on the running loop as it is, every link with the fates it draws (recorded delays in
/// their order): its deviation from rest is brought back to size one after every packet period.
/// Axis and plane scenes made linear.
[[nodiscard]] Lyapunov sampled_exponent(const core::Scene& scene, const core::NetworkModel& network,
                                        const LyapunovOptions& options = {});

/// 97.5 % quantile of Student's t.
[[nodiscard]] double student_quantile(int degrees);

}  // namespace tandem::analysis
