#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bench/error_cases.h"

namespace tandem::bench {

/// One point of a diagram.
struct ErrorRow {
  int point = 0;        ///< index in kErrorPoints
  std::string engine;   ///< "tandem" or a peer
  std::string setting;  ///< integrator, or the peer's setting
  bool is_default = false;
  bool in_tandem = true;  ///< false: a candidate of the wall case, compared with nobody
  int hz = 0;
  double ns_per_s = 0.0;   ///< processor time for a simulated second, median over the rounds [ns]
  double error = 0.0;      ///< from the true course [m] or [rad]; infinity: blew up
  double law_error = 0.0;  ///< from the law's own exact course (README) [m] or [rad]
  double drift = 0.0;      ///< of the energy [1]
};

/// Tandem beside the best of the peers at equal error.
struct Comparison {
  int point = 0;
  std::string peer, setting;  ///< whose point it is
  int hz = 0;
  double error = 0.0;      ///< that both keep
  double peer_ns = 0.0;    ///< the least any peer needs for it
  double tandem_ns = 0.0;  ///< the least Tandem needs for at most that
  int tandem_hz = 0;
  std::string tandem_setting;
  [[nodiscard]] double speedup() const { return peer_ns / tandem_ns; }
};

/// Of one case: every useful point of the peers' common front (no other peer's point is both nearer
/// and faster) set against Tandem. Useful: an error of at most `scale` / 20.
struct CaseResult {
  int point = 0;
  double scale = 0.0;               ///< the largest way of the true course [m]; 1 rad
  std::vector<Comparison> reached;  ///< errors that Tandem keeps, too
  std::vector<Comparison>
      unreached;                    ///< errors that only a peer keeps; the Tandem side is its least
  double least_error = 0.0;         ///< Tandem's, over all rates
  std::optional<Comparison> least;  ///< of least speedup among `reached`
};

/// `only_default`: the scheme a scene has if it says nothing; otherwise the best of all its
/// schemes.
[[nodiscard]] CaseResult compare_case(const std::vector<ErrorRow>& rows, int point, double scale,
                                      bool only_default);

/// Observed order of convergence: slope of log error over log step by least squares through the
/// rates from 1024 Hz on whose errors are below a twentieth of `scale` and above `floor`; nothing
/// if there are not three. Stick-slip: of the error from the law's own course, as the true one is
/// that of another law.
[[nodiscard]] std::optional<double> observed_order(const std::vector<ErrorRow>& rows, int point,
                                                   const std::string& setting, double scale,
                                                   double floor);

}  // namespace tandem::bench
