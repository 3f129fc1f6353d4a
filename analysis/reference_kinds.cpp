#include "analysis/reference_kinds.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdio>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "analysis/closed_forms.h"
#include "analysis/drag.h"
#include "analysis/fast_response.h"
#include "analysis/resampled.h"
#include "analysis/stability.h"
#include "core/random.h"

namespace tandem::analysis::reference {

namespace {

using Complex = std::complex<double>;

constexpr double kDampingLimit = 1e-9, kRadiusLimit = 1e-10;

double damping_of(Case c, const std::string& model, const std::string& output) {
  const Pushed p = pushed(std::move(c), model);
  const FreeMotion motion = free_motion(p.system, p.port);
  if (output == "mean") return motion.mean_damping;
  if (output == "sampled") return motion.sampled_damping;
  if (output == "inertia") return motion.inertia;
  throw std::invalid_argument("no output " + output);
}

/// Gain of the coupler of the user across the network, or of the local one.
core::Gain hand_gain(const core::Scene& scene, bool remote) {
  const std::string& user = scene.users[remote ? drag_user(scene) : 0].name;
  for (const core::CouplerParameters& c : scene.couplers)
    if (c.user == user) return c.gain;
  return {};
}

double closed_form(const Case& c, const std::string& name) {
  const core::Scene& s = c.scene;
  const double wall = s.walls.empty() ? 0.0 : s.walls[0].gain.stiffness;
  const double period = s.ticks_per_packet() * s.tick(), T = s.tick(), mass = s.objects[0].mass;
  if (name == "B.10") return damping_b10(hand_gain(s, true), mass, T);
  if (name == "remote stiffness") return stiffness_in_series(hand_gain(s, true).stiffness, wall);
  if (name == "local stiffness") return stiffness_in_series(hand_gain(s, false).stiffness, wall);
  if (name == "held damping limit")
    return held_damping_limit(
        s.users[drag_user(s)].mass, period,
        static_cast<int>(c.network.link[core::NetworkModel::kServer][drag_user(s)].delay_ticks /
                         s.ticks_per_packet()));
  const double reduced = s.users[0].mass * mass / (s.users[0].mass + mass);
  if (name == "reduced mass") return reduced;
  if (name == "largest damping") return 2.0 * reduced / T;
  if (name == "2b/T") return 2.0 * hand_gain(s, false).damping / T;
  const CopiesNumbers n = copies_numbers(s);
  if (name == "6.3") return damping_6_3(n);
  if (name == "B.11") return damping_b11(n);
  if (name == "B.11 corrected") return damping_b11_corrected(n);
  if (name == "6.4") return stiffness_6_4(n, wall);
  if (name == "6.4 corrected") return stiffness_6_4_corrected(n, wall);
  if (name == "per packet") return damping_per_packet(n, period);
  if (name == "simplified per packet") return simplified_damping_per_packet(n, period);
  throw std::invalid_argument("no closed form " + name);
}

/// Magnitude and phase together: distance of the complex numbers, relative.
void response(const std::vector<std::string>& f, const Case& c, CheckRow& row) {
  const auto words = split(f.at(5), ' ');
  const double w = to_number(f.at(6)), size = to_number(f.at(7)), phase = to_number(f.at(8));
  const std::string& model = words.at(0);
  const bool position = words.at(1) == "X", fast = words.size() > 2 && words[2] == "fast";
  const core::Scene& s = c.scene;
  const double mass = s.objects[0].mass;
  Complex found;
  if (model == "mass") {
    found = mass_admittance(mass, w);
  } else if (model == "mass+hand") {
    found = mass_admittance(mass + s.users[0].mass, w);
  } else if (model == "mass_held") {
    found = held_mass_admittance(mass, s.ticks_per_packet() * s.tick(), w);
  } else if (model == "mass_at_wall") {
    found = mass_at_wall(mass, s.walls.at(0).gain, w);
  } else if (fast) {
    Case pushed_case = c;
    apply_model(pushed_case.scene, model);
    found = FastResponse(pushed_case.scene, c.network, model == "remote" ? drag_user(s) : 0)(
        w, position);
  } else {
    const Pushed p = pushed(c, model);
    found = admittance(p.system, p.port, w, position);
  }
  constexpr double kDegree = std::numbers::pi / 180.0;
  compare(std::abs(found), size, kDampingLimit, row);
  row.deviation = std::abs(found - std::polar(size, phase * kDegree)) / size;
}

Judgement judged(Case c, const std::string& model, bool on_loop) {
  apply_model(c.scene, model);
  if (model == "own timer") c.network.packet_timer = core::PacketTimer::kOwn;
  return judge(!on_loop && why_not_resampled(c.scene, c.network).empty()
                   ? resampled_system(c.scene, c.network)
                   : measured_system(c.scene, c.network));
}

/// Largest distance of an eigenvalue above 0.02 in modulus to the nearest one of the other list.
/// Smaller ones belong to delays and have no accuracy.
double mismatch(const std::vector<Complex>& a, const std::vector<Complex>& b) {
  double worst = 0.0;
  for (const auto& [from, to] : {std::pair{&a, &b}, std::pair{&b, &a}})
    for (const Complex& x : *from) {
      if (std::abs(x) <= 0.02) continue;
      double nearest = std::numeric_limits<double>::infinity();
      for (const Complex& y : *to) nearest = std::min(nearest, std::abs(x - y));
      worst = std::max(worst, nearest);
    }
  return worst;
}

void eigenvalue_list(const std::vector<std::string>& f, const Case& c, CheckRow& row) {
  std::vector<Complex> expected;
  for (const std::string& word : split(f.at(6), ' ')) {
    const auto parts = split(word, ',');
    expected.emplace_back(to_number(parts.at(0)), to_number(parts.at(1)));
  }
  const Judgement found = judged(c, f.at(5), false);
  row.expected = f.at(6);
  char text[80];
  for (const Complex& z : found.eigenvalues) {
    std::snprintf(text, sizeof text, "%s%.10g,%.10g", row.found.empty() ? "" : " ", z.real(),
                  z.imag());
    row.found += text;
  }
  row.limit = kRadiusLimit;
  row.deviation = mismatch(found.eigenvalues, expected);
}

/// Jury's margins of a mode of second order: p(1), p(-1), 1 - det.
void jury(const std::vector<std::string>& f, const Case& c, CheckRow& row) {
  const Judgement j = judged(c, f.at(5), false);
  if (j.eigenvalues.size() != 2) throw std::invalid_argument("not of second order");
  const double sum = (j.eigenvalues[0] + j.eigenvalues[1]).real(),
               product = (j.eigenvalues[0] * j.eigenvalues[1]).real();
  const double found[] = {1.0 - sum + product, 1.0 + sum + product, 1.0 - product};
  row.limit = kRadiusLimit;
  char text[40];
  for (std::size_t i = 0; i < 3; ++i) {
    const double expected = to_number(f.at(6 + i));
    std::snprintf(text, sizeof text, "%s%.10g", i == 0 ? "" : " ", found[i]);
    row.found += text;
    row.expected += (i == 0 ? "" : " ") + f.at(6 + i);
    row.deviation = std::max(row.deviation, std::abs(found[i] - expected));
  }
}

/// Every entry of the map, row by row; its states are (x, v) of the hand, then of the object.
void matrix(const std::vector<std::string>& f, const Case& c, CheckRow& row) {
  const LiftedSystem system = resampled_system(c.scene, c.network);
  const auto expected = split(f.at(5), ' ');
  row.limit = 1e-12;
  row.expected = row.found = std::to_string(expected.size()) + " entries";
  if (expected.size() != system.transition.values.size()) {
    row.deviation = std::numeric_limits<double>::infinity();
    return;
  }
  for (std::size_t i = 0; i < expected.size(); ++i)
    row.deviation =
        std::max(row.deviation, std::abs(system.transition.values[i] - to_number(expected[i])));
}

/// Gains and masses drawn anew, so that nothing hangs on the numbers of the thesis.
void redraw(core::Scene& scene, core::Random& random) {
  for (core::CouplerParameters& c : scene.couplers)
    c.gain = {random.uniform(50.0, c.user.empty() ? 600.0 : 2500.0), random.uniform(1.0, 12.0)};
  for (core::UserParameters& user : scene.users) user.mass = random.uniform(0.05, 0.2);
  scene.objects[0].mass = random.uniform(0.2, 1.0);
}

/// Two roads to the map of random plants, N = 2, 3, 8, d = 0..3.
void roads(const std::vector<std::string>& f, Case c, CheckRow& row) {
  const auto words = split(f.at(5), ' ');
  core::Random random(2);
  double worst = 0.0;
  for (int i = 0; i < 144; ++i) {
    const int N = i % 3 == 0 ? 2 : i % 3 == 1 ? 3 : 8, d = i / 3 % 4;
    c.scene.rates.packet_hz = c.scene.rates.local_hz / N;
    redraw(c.scene, random);
    Case other = c;
    c.network.set_round_trip(d, N);
    other.network = c.network;
    const int there =
        c.scene.architecture == core::Architecture::kCentral ? core::NetworkModel::kServer : 0;
    core::LinkModelParameters &out = other.network.link[there][1],
                              &back = other.network.link[1][there];
    if (words.at(1) == "return") std::swap(out.delay_ticks, back.delay_ticks);
    if (words.at(1) == "half") out.delay_ticks = back.delay_ticks = 0.5 * d * N;
    // Half of an odd number of packets is not a whole packet, and then the split matters.
    if (words.at(1) == "half" && d % 2 != 0) continue;
    worst = std::max(worst, mismatch(judged(c, "free", false).eigenvalues,
                                     judged(other, "free", words.at(0) == "measured").eigenvalues));
  }
  row.expected = f.at(6);
  char text[40];
  std::snprintf(text, sizeof text, "%.3g", worst);
  row.found = text;
  row.limit = kRadiusLimit;
  row.deviation = worst;
}

/// tr(M^k), k = 1..8, of the resampled map and of the one measured on the loop.
void traces(const std::vector<std::string>& f, const Case& c, CheckRow& row) {
  const Matrix a = resampled_system(c.scene, c.network).transition,
               b = measured_system(c.scene, c.network).transition;
  const auto powers = [](const Matrix& m) {
    std::vector<double> out;
    Matrix p = m;
    for (int k = 1; k <= 8; ++k) {
      double trace = 0.0;
      for (int i = 0; i < m.rows; ++i) trace += p(i, i);
      out.push_back(trace);
      Matrix next(m.rows, m.rows);
      for (int i = 0; i < m.rows; ++i)
        for (int l = 0; l < m.rows; ++l)
          for (int j = 0; j < m.rows; ++j) next(i, j) += m(i, l) * p(l, j);
      p = next;
    }
    return out;
  };
  const auto ta = powers(a), tb = powers(b);
  for (std::size_t k = 0; k < ta.size(); ++k)
    row.deviation = std::max(row.deviation, std::abs(ta[k] - tb[k]) / std::abs(tb[k]));
  row.expected = f.at(5);
  char text[40];
  std::snprintf(text, sizeof text, "%.3g", row.deviation);
  row.found = text;
  row.limit = 1e-12;
}

/// The number that gives a damping, looked for near the expected one.
void root(const std::vector<std::string>& f, Case c, CheckRow& row) {
  const Knob knob(c.scene, f.at(5));
  const auto words = split(f.at(6), ' ');
  const double target = to_number(f.at(7)), expected = to_number(f.at(8));
  const auto above = [&](double x) {
    knob.set(c.scene, x);
    return damping_of(c, words.at(0), words.at(1)) > target;
  };
  double low = 0.999 * expected, high = 1.001 * expected;
  const bool at_low = above(low);
  if (at_low == above(high)) {
    compare(std::numeric_limits<double>::infinity(), expected, 0.0, row);
    return;
  }
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (above(middle) == at_low ? low : high) = middle;
  }
  compare(low, expected, 0.0, row);
  row.deviation = std::abs(low - expected);
  row.limit = 4e-12;  // absolute: what the reference's root finder stops at
}

/// Is a closed form the direct solve at six other sets of numbers? Expected: true or false.
void identity(const std::vector<std::string>& f, Case c, CheckRow& row) {
  const auto words = split(f.at(6), ' ');
  core::Random random(3);
  double worst = 0.0;
  for (int i = 0; i < 6; ++i) {
    redraw(c.scene, random);
    core::Gain* between = nullptr;
    for (core::CouplerParameters& coupler : c.scene.couplers)
      if (coupler.user.empty()) {
        if (between != nullptr) coupler.gain = *between;
        between = &coupler.gain;
      }
    const double formula = closed_form(c, f.at(5));
    worst = std::max(worst, std::abs(damping_of(c, words.at(0), words.at(1)) / formula - 1.0));
  }
  row.expected = f.at(7);
  row.found = worst < kDampingLimit ? "true" : "false";
  row.deviation = row.expected == row.found ? 0.0 : std::numeric_limits<double>::infinity();
}

}  // namespace

void compare(double found, double expected, double limit, CheckRow& row) {
  char text[64];
  std::snprintf(text, sizeof text, "%.13g", expected);
  row.expected = text;
  std::snprintf(text, sizeof text, "%.13g", found);
  row.found = text;
  row.limit = limit;
  const double size = expected == 0.0 ? 1.0 : std::abs(expected);
  row.deviation = std::isfinite(found) ? std::abs(found - expected) / size
                                       : std::numeric_limits<double>::infinity();
}

void compute(const std::vector<std::string>& f, Case c, CheckRow& row) {
  if (compute_region(f, c, row)) return;
  if (row.kind == "damping") {
    const auto words = split(f.at(5), ' ');
    compare(damping_of(c, words.at(0), words.at(1)), to_number(f.at(6)), kDampingLimit, row);
  } else if (row.kind == "slope") {  // what one more packet of round trip adds
    const auto words = split(f.at(5), ' ');
    Case later = c;
    later.network.set_round_trip(row.round_trip + 1.0, c.scene.ticks_per_packet());
    compare(damping_of(later, words.at(0), words.at(1)) - damping_of(c, words.at(0), words.at(1)),
            to_number(f.at(6)), kDampingLimit, row);
  } else if (row.kind == "closed") {
    compare(closed_form(c, f.at(5)), to_number(f.at(6)), kDampingLimit, row);
  } else if (row.kind == "stiffness") {
    const Pushed p = pushed(c, f.at(5));
    compare(equivalent_stiffness(p.system, p.port), to_number(f.at(6)), kDampingLimit, row);
  } else if (row.kind == "radius") {
    compare(judged(c, f.at(5), false).radius, to_number(f.at(6)), kRadiusLimit, row);
  } else if (row.kind == "excess") {  // rho - 1, measured on the loop; the limit is of rho
    compare(judged(c, f.at(5), true).radius - 1.0, to_number(f.at(6)), kRadiusLimit, row);
    row.deviation *= std::abs(to_number(f.at(6)));
  } else if (row.kind == "response") {
    response(f, c, row);
  } else if (row.kind == "eigenvalues") {
    eigenvalue_list(f, c, row);
  } else if (row.kind == "jury") {
    jury(f, c, row);
  } else if (row.kind == "matrix") {
    matrix(f, c, row);
  } else if (row.kind == "roads") {
    roads(f, c, row);
  } else if (row.kind == "traces") {
    traces(f, c, row);
  } else if (row.kind == "root") {
    root(f, c, row);
  } else if (row.kind == "identity") {
    identity(f, c, row);
  } else {
    throw std::invalid_argument("no kind " + row.kind);
  }
}

}  // namespace tandem::analysis::reference
