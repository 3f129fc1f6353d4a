#include "analysis/closed_forms.h"

#include <cmath>
#include <numbers>
#include <stdexcept>

namespace tandem::analysis {

namespace {

const core::Gain& gain_of(const core::Scene& scene, int user, int copy) {
  for (const core::CouplerParameters& c : scene.couplers)
    if (c.copy == scene.users[copy].name && c.user == (user < 0 ? "" : scene.users[user].name))
      return c.gain;
  static constexpr core::Gain kNone;
  return kNone;
}

}  // namespace

CopiesNumbers copies_numbers(const core::Scene& scene) {
  if (scene.architecture != core::Architecture::kDistributed || scene.users.size() != 2 ||
      scene.objects.size() != 1)
    throw std::domain_error("the closed forms are for two users with a whole copy of one object");
  const core::Gain &one = gain_of(scene, -1, 0), &two = gain_of(scene, -1, 1);
  if (one.stiffness != two.stiffness || one.damping != two.damping)
    throw std::domain_error("the closed forms take the couplers between the copies to be equal");
  return {scene.tick(), gain_of(scene, 0, 0), gain_of(scene, 0, 1),
          one,          scene.users[0].mass,  scene.objects[0].mass};
}

double damping_6_3(const CopiesNumbers& s) noexcept {
  return 2.0 * s.mass * s.ko.stiffness /
         (4.0 * s.mass / s.T - s.T * s.ko.stiffness - 2.0 * s.ko.damping);
}

double damping_b11(const CopiesNumbers& s) noexcept {
  const double T = s.T, T2 = T * T, T3 = T2 * T, m1 = s.hand, mo = s.mass;
  const double k11 = s.k11.stiffness, k21 = s.k21.stiffness, ko = s.ko.stiffness;
  const double b11 = s.k11.damping, b21 = s.k21.damping, bo = s.ko.damping;
  const double sum = 10.0 * m1 * ko * ko * T2 * bo * b11 - 24.0 * T * ko * ko * m1 * mo * b11 -
                     40.0 * m1 * T * mo * ko * ko * bo - 24.0 * m1 * T * mo * ko * ko * b21 +
                     T3 * b21 * b21 * ko * ko * b11 - 24.0 * T * b11 * mo * mo * ko * ko -
                     4.0 * T3 * b11 * bo * bo * ko * ko + 10.0 * m1 * T2 * bo * ko * ko * b21 +
                     8.0 * m1 * T2 * bo * bo * ko * ko - 4.0 * T3 * b11 * bo * ko * ko * b21 +
                     10.0 * T2 * b11 * mo * ko * ko * b21 + 12.0 * m1 * T2 * ko * ko * b21 * b11 +
                     48.0 * m1 * mo * mo * ko * ko + 20.0 * T2 * b11 * mo * ko * ko * bo -
                     2.0 * T2 * k21 * k21 * mo * bo * b11 - 2.0 * T2 * k21 * k21 * m1 * bo * bo -
                     2.0 * T2 * k21 * k21 * m1 * bo * b11 + 4.0 * T * k21 * k21 * m1 * mo * bo +
                     T3 * k21 * k21 * bo * bo * b11 + 8.0 * T2 * m1 * b11 * ko * bo * k21 -
                     40.0 * T * m1 * mo * ko * bo * k21 - 4.0 * T3 * ko * bo * bo * b11 * k21 +
                     8.0 * T2 * m1 * bo * bo * ko * k21 + 12.0 * m1 * T2 * b11 * ko * b21 * k21 +
                     12.0 * m1 * T2 * bo * ko * b21 * k21 + 20.0 * T2 * mo * ko * bo * k21 * b11 +
                     12.0 * T2 * mo * k21 * ko * b21 * b11 - 6.0 * T3 * k21 * ko * b21 * b11 * bo -
                     24.0 * m1 * mo * T * ko * b21 * k21 + 48.0 * m1 * mo * mo * k21 * ko -
                     24.0 * T * mo * mo * k21 * ko * b11 - 24.0 * m1 * mo * T * b11 * ko * k21;
  const double below = (T * bo + T * b21 - 2.0 * mo) * (k11 * k21 + ko * k21 + k11 * ko) *
                       (-T3 * b11 * ko - 2.0 * T2 * b11 * bo + 4.0 * m1 * T * bo +
                        4.0 * m1 * T * b11 + 4.0 * mo * T * b11 - 8.0 * m1 * mo);
  return T * k11 * sum / below;
}

double damping_b11_corrected(const CopiesNumbers& s) noexcept {
  const double T = s.T, T2 = T * T, T3 = T2 * T, m1 = s.hand, mo = s.mass;
  const double k11 = s.k11.stiffness, k21 = s.k21.stiffness, ko = s.ko.stiffness;
  const double b11 = s.k11.damping, b21 = s.k21.damping, bo = s.ko.damping;
  const double sum = T3 * b11 * b21 * b21 * ko * ko - 2.0 * T3 * b11 * b21 * bo * k21 * ko +
                     T3 * b11 * bo * bo * k21 * k21 + 4.0 * T2 * b11 * b21 * k21 * ko * m1 +
                     4.0 * T2 * b11 * b21 * k21 * ko * mo + 4.0 * T2 * b11 * b21 * ko * ko * m1 +
                     2.0 * T2 * b11 * b21 * ko * ko * mo - 2.0 * T2 * b11 * bo * k21 * k21 * m1 -
                     2.0 * T2 * b11 * bo * k21 * k21 * mo + 4.0 * T2 * b11 * bo * k21 * ko * mo +
                     2.0 * T2 * b11 * bo * ko * ko * m1 + 4.0 * T2 * b11 * bo * ko * ko * mo +
                     4.0 * T2 * b21 * bo * k21 * ko * m1 + 2.0 * T2 * b21 * bo * ko * ko * m1 -
                     2.0 * T2 * bo * bo * k21 * k21 * m1 - 8.0 * T * b11 * k21 * ko * m1 * mo -
                     8.0 * T * b11 * k21 * ko * mo * mo - 8.0 * T * b11 * ko * ko * m1 * mo -
                     8.0 * T * b11 * ko * ko * mo * mo - 8.0 * T * b21 * k21 * ko * m1 * mo -
                     8.0 * T * b21 * ko * ko * m1 * mo + 4.0 * T * bo * k21 * k21 * m1 * mo -
                     8.0 * T * bo * k21 * ko * m1 * mo - 8.0 * T * bo * ko * ko * m1 * mo +
                     16.0 * k21 * ko * m1 * mo * mo + 16.0 * ko * ko * m1 * mo * mo;
  const double below = (T * b21 + T * bo - 2.0 * mo) * (k11 * k21 + k11 * ko + k21 * ko) *
                       (T3 * b11 * ko + 2.0 * T2 * b11 * bo - 4.0 * T * b11 * m1 -
                        4.0 * T * b11 * mo - 4.0 * T * bo * m1 + 8.0 * m1 * mo);
  return -T * k11 * sum / below;
}

double damping_b10(const core::Gain& k2, double mass, double T) noexcept {
  return k2.stiffness / (2.0 / T - k2.damping / mass);
}

double damping_per_packet(const CopiesNumbers& s, double packet_period) noexcept {
  const double k11 = s.k11.stiffness, k21 = s.k21.stiffness, ko = s.ko.stiffness;
  return packet_period * k11 * ko * (ko + k21) / (k11 * k21 + ko * k21 + k11 * ko);
}

double simplified_damping_per_packet(const CopiesNumbers& s, double packet_period) noexcept {
  return 0.5 * packet_period * s.ko.stiffness;
}

double stiffness_6_4(const CopiesNumbers& s, double wall) noexcept {
  const double k11 = s.k11.stiffness, k21 = s.k21.stiffness, ko = s.ko.stiffness;
  const double below = 2.0 * ko * ko + k21 * wall + 2.0 * ko * wall + wall * wall;
  return k11 * below / (ko * k21 + k21 * k11 + k11 * ko + k11 * wall + below);
}

double stiffness_6_4_corrected(const CopiesNumbers& s, double wall) noexcept {
  const double k11 = s.k11.stiffness, k21 = s.k21.stiffness, ko = s.ko.stiffness;
  const double below = wall * (2.0 * ko + k21 + wall);
  return k11 * below / (ko * k21 + k21 * k11 + k11 * ko + k11 * wall + below);
}

double stiffness_in_series(double coupler, double wall) noexcept {
  return coupler * wall / (coupler + wall);
}

double held_damping_limit(double hand, double packet_period, int packets) noexcept {
  return 2.0 * hand / packet_period * std::sin(std::numbers::pi / (2.0 * (2.0 * packets + 1.0)));
}

std::complex<double> mass_admittance(double mass, double omega) noexcept {
  return {0.0, -1.0 / (omega * mass)};
}

std::complex<double> held_mass_admittance(double mass, double period, double omega) noexcept {
  // z - 1 = 2j sin(a/2) e^(ja/2), which does not cancel where omega is small.
  const double a = omega * period;
  return period / mass / (std::polar(2.0 * std::sin(0.5 * a), 0.5 * (a + std::numbers::pi)));
}

std::complex<double> mass_at_wall(double mass, const core::Gain& wall, double omega) noexcept {
  return 1.0 / std::complex<double>(wall.stiffness - omega * omega * mass, omega * wall.damping);
}

}  // namespace tandem::analysis
