#pragma once

#include <complex>

#include "analysis/matrix.h"
#include "analysis/workstations.h"

namespace tandem::analysis {

/// Response of a finger to a sinusoidal force that changes every tick, where Response (6.1) holds
/// it over a packet period: the fundamental component of the motion at the ticks over the force.
/// The motion has other components too, for the session is periodic in the packet period and not in
/// the tick. Where resampling applies (why_not_resampled); throws std::domain_error elsewhere.
class FastResponse {
 public:
  FastResponse(const core::Scene& scene, const core::NetworkModel& network, int user,
               int finger = 0);
  /// V/F at `omega` [rad/s]; X/F with `of_position`.
  [[nodiscard]] std::complex<double> operator()(double omega, bool of_position = false) const;

 private:
  Workstations w_;
  Matrix map_;  ///< over a packet period
  int site_ = 0, body_ = 0;
};

}  // namespace tandem::analysis
