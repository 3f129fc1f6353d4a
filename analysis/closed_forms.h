#pragma once

#include <complex>

#include "core/scene.h"

/// Closed forms of the thesis and of the reference analysis, beside which the direct solves stand.
/// Each holds under its own assumptions only; closed_form_rows.h says where a scene leaves them.
namespace tandem::analysis {

/// The numbers of a symmetric distributed axis scene, one user moving the object alone: k11 its
/// coupler, k21 that to the other's copy, ko between the copies.
struct CopiesNumbers {
  double T = 0.0;                 ///< tick T_c [s]
  core::Gain k11, k21, ko;        ///< [N/m], [N s/m]
  double hand = 0.0, mass = 0.0;  ///< m_1, m_o [kg]
};

/// The numbers of a scene; throws std::domain_error where it has no such form or ko1 and ko2
/// differ.
[[nodiscard]] CopiesNumbers copies_numbers(const core::Scene& scene);

/// (6.3): force on both copies, no hand couplers, N = 2, no delay, sampled velocity [N s/m].
[[nodiscard]] double damping_6_3(const CopiesNumbers& s) noexcept;
/// (B.11)-(B.13) as printed, with M_o = m_o. The thesis says N = 2, n = 0; it is the damping for a
/// round trip of *one* packet period, sampled velocity [N s/m].
[[nodiscard]] double damping_b11(const CopiesNumbers& s) noexcept;
/// What (B.11) should be for N = 2 and no delay (reference analysis, appendix) [N s/m].
[[nodiscard]] double damping_b11_corrected(const CopiesNumbers& s) noexcept;
/// (B.10): the remote user of a central scene, N = 2, any delay; k2, b2 its coupler [N s/m].
[[nodiscard]] double damping_b10(const core::Gain& k2, double mass, double T) noexcept;
/// What a packet period of round trip adds to the damping against the mean velocity, any N,
/// exactly: T_t k11 k_o (k_o + k21) / (k11 k21 + k_o k21 + k11 k_o) [N s/m].
[[nodiscard]] double damping_per_packet(const CopiesNumbers& s, double packet_period) noexcept;
/// The same for force on both copies without hand couplers: T_t k_o / 2 [N s/m].
[[nodiscard]] double simplified_damping_per_packet(const CopiesNumbers& s,
                                                   double packet_period) noexcept;

/// Stiffness at rest against a wall (k_w), distributed: (6.4) as printed, which has 2 k_o^2 too
/// much above and below, and as corrected [N/m].
[[nodiscard]] double stiffness_6_4(const CopiesNumbers& s, double wall) noexcept;
[[nodiscard]] double stiffness_6_4_corrected(const CopiesNumbers& s, double wall) noexcept;
/// Springs in series: a hand of a central scene against the wall [N/m].
[[nodiscard]] double stiffness_in_series(double coupler, double wall) noexcept;

/// Largest damping [N s/m] of a coupler that is held over a packet period and comes back `packets`
/// later on a free hand, object held: b < 2 (m / T_t) sin(pi / (2 (2 packets + 1))). Above it no
/// remote stiffness is stable.
[[nodiscard]] double held_damping_limit(double hand, double packet_period, int packets) noexcept;

/// V/F of a free mass at `omega` [rad/s], force and velocity continuous: 1 / (j omega m).
[[nodiscard]] std::complex<double> mass_admittance(double mass, double omega) noexcept;
/// The same with the force held over `period` and the velocity sampled: (period / m) / (z - 1).
[[nodiscard]] std::complex<double> held_mass_admittance(double mass, double period,
                                                        double omega) noexcept;
/// X/F of a mass at a wall: 1 / (k_w + j omega b_w - omega^2 m).
[[nodiscard]] std::complex<double> mass_at_wall(double mass, const core::Gain& wall,
                                                double omega) noexcept;

}  // namespace tandem::analysis
