#pragma once

#include <array>
#include <limits>
#include <string>
#include <vector>

#include "harness/point_result.h"

namespace tandem::harness {

/// The reconstructions of a sample between packets that compete, as points name their style, and
/// what people call them.
inline constexpr int kReconstructions = 3;
enum Reconstruction { kHeld = 0, kCompensation = 1, kExtrapolation = 2 };
inline constexpr std::array<const char*, kReconstructions> kStyleNames = {"hold", "compensated",
                                                                          "extrapolate"};
inline constexpr std::array<const char*, kReconstructions> kSpokenNames = {"hold", "compensated",
                                                                           "extrapolated"};

/// Closer than this to the best, as a ratio, is as good as the best.
inline constexpr double kAlike = 1.02;

/// What one reconstruction did at one value of the knob.
struct Contender {
  bool there = false;   ///< the sweep has the point
  bool failed = false;  ///< it would not run
  bool judged = false, stable = false;
  bool missed_ticks = false;     ///< sockets: too many (kMostMissed) to be judged
  bool near_boundary = false;    ///< within 10 % of it by the analysis
  double age = kNotMeasured;     ///< mean of the samples in use [s]
  double weber = kNotMeasured;   ///< force error against the ideal twin, mean of the sites
  double newton = kNotMeasured;  ///< the same [N]
  double drag = kNotMeasured;    ///< of a stable session [N s/m]
  /// Largest stable one [N/m]: searched for in virtual time. On sockets the analysis' own, from the
  /// measured delays, where sessions on sockets confirmed it (confirmed_coupling); else no number.
  double coupling = kNotMeasured;
  std::string unconfirmed;  ///< sockets: why there is no number

  /// Force error [Weber]: infinite if not stable, no number if not known.
  [[nodiscard]] double error() const;
};

/// All reconstructions at one value of the knob.
struct Contest {
  std::string label;          ///< of the value: "n = 2", "5 ms"
  double age = kNotMeasured;  ///< mean of the contenders' [s]
  std::array<Contender, kReconstructions> by{};
  /// Those within kAlike of the best of at least two, force errors in Weber and in newton. Empty:
  /// none is stable, or fewer than two are known (`error_known`, `coupling_known`; the latter 0
  /// where one was not confirmed: it may bear more than all others).
  std::vector<int> least_error, least_newton, largest_coupling;
  int error_known = 0, coupling_known = 0;
};

/// Extrapolation against the better of the others, at one mean age.
struct Standing {
  double age = kNotMeasured;  ///< [s]
  std::string label;
  /// Better one's error over its own, or its coupling over the better one's; above 1 it wins. 0 and
  /// infinity: one of them is not stable, or stable with every coupling that was tried.
  double ratio = 1.0;
  [[nodiscard]] bool wins() const { return ratio > kAlike; }
  [[nodiscard]] bool loses() const { return ratio * kAlike < 1.0; }
};

/// Between these two, neighbours in age but for those that are alike, it stops or begins to win.
struct Crossing {
  Standing from, to;
  /// Where the logarithm of the ratio, drawn straight over age, is 0; no number where a ratio is 0
  /// or infinite [s].
  double at = kNotMeasured;
};

/// Standings in the order of age.
struct ByAge {
  std::vector<Standing> standings;
  std::vector<Crossing> crossings;
  std::vector<std::string> none_stable;  ///< labels at which no contender is
  /// Ages within a tenth of each other: then `crossings` mean nothing.
  [[nodiscard]] bool one_age() const {
    return standings.size() > 1 && standings.back().age < 1.1 * standings.front().age;
  }
};

/// What compensation leaves of the largest coupling that hold bears, where it leaves any.
struct Margin {
  bool known = false;
  double least = kNotMeasured, most = kNotMeasured, median = kNotMeasured;
  std::string least_at, most_at;
  std::vector<std::string> nothing_at;  ///< hold bears some there, compensation none
};

struct Contests {
  std::string architecture, knob;
  std::string coupling;  ///< name of the one searched for: "k_o"
  bool real = false;
  std::vector<Contest> at;  ///< in the order of the sweep
  Margin margin;
  ByAge by_error, by_coupling;  ///< extrapolation's
};

/// Made from results of the same sweep, one for each architecture, in its order; points without a
/// style (sweep files that set it themselves) do not compete.
[[nodiscard]] std::vector<Contests> contests(const std::vector<PointResult>& results);

/// The largest coupling that the analysis predicts from a real session's delays, if sockets were
/// stable at 0.9 times it and not at 1.1 times, in sessions that ran (kMostMissed) over much the
/// same delays (their own boundary within kSameNetwork). Predicted 0: if the session as it is was
/// not stable. Else no number, and `why` says why not.
[[nodiscard]] double confirmed_coupling(const PointResult& result, std::string& why);
inline constexpr double kSameNetwork = 1.25;

}  // namespace tandem::harness
