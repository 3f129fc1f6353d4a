#pragma once

#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <vector>

#include "analysis/growth.h"
#include "analysis/matrix.h"
#include "analysis/state_vector.h"
#include "core/random.h"

namespace tandem::analysis {

template <typename Loop>
[[nodiscard]] std::vector<double> values_of(Loop& loop) {
  std::vector<double> values;
  for (const StateEntry& e : states_of(loop)) values.push_back(*e.value);
  return values;
}

/// One packet period of a loop that stands at its start, as a map on deviations. Where delays are
/// not whole packet periods, other packets are in flight at its end than at its start.
template <typename Loop>
class PeriodProbe {
 public:
  PeriodProbe(const Loop& start, double amplitude)
      : start_(start), work_(start), before_(values_of(start_)), amplitude_(amplitude) {
    work_.advance_packet_period();
    after_ = values_of(work_);
  }

  [[nodiscard]] int columns() const { return static_cast<int>(before_.size()); }

  /// What a deviation has become. The rest moves where a wall pushes it: what a deviation adds to
  /// that is the map.
  std::vector<double> linear(const std::vector<double>& d) {
    std::vector<double> y = run(d, amplitude_);
    if (amplitude_ == 1.0) return y;
    const std::vector<double> back = run(d, -amplitude_);  // central difference
    for (std::size_t i = 0; i < y.size(); ++i) y[i] = 0.5 * (y[i] + back[i]);
    return y;
  }

  [[nodiscard]] Matrix map() {
    Matrix m(static_cast<int>(after_.size()), columns());
    std::vector<double> unit(before_.size(), 0.0);
    for (int j = 0; j < m.cols; ++j) {
      unit[j] = 1.0;
      const std::vector<double> column = linear(unit);
      for (int i = 0; i < m.rows; ++i) m(i, j) = column[i];
      unit[j] = 0.0;
    }
    check(m);
    return m;
  }

  /// Change by 1 N on a finger, along component `c`.
  [[nodiscard]] std::vector<double> push(int user, int finger, int c) {
    typename Loop::Vector force{0.0};
    core::component(force, c) = amplitude_;
    start_.hands().finger(user, finger).set_external_force(force);
    std::vector<double> y = run(std::vector<double>(before_.size(), 0.0), amplitude_);
    start_.hands().finger(user, finger).set_external_force(typename Loop::Vector{0.0});
    return y;
  }

 private:
  std::vector<double> run(const std::vector<double>& d, double size) {
    work_ = start_;
    detail::set_deviation(work_, before_, d, size);
    work_.advance_packet_period();
    std::vector<double> y(after_.size());
    detail::get_deviation(work_, after_, y, size);
    return y;
  }

  /// Superposition, on one seeded deviation: a threshold or a saturation shows here.
  void check(const Matrix& m) {
    core::Random random(1);
    std::vector<double> d(before_.size());
    for (double& x : d) x = random.uniform(-1.0, 1.0);
    const std::vector<double> whole = linear(d), sum = multiply(m, d);
    for (int i = 0; i < m.rows; ++i) {
      double sizes = 1.0;
      for (int j = 0; j < m.cols; ++j) sizes += std::abs(m(i, j) * d[j]);
      if (std::isfinite(whole[i]) && !(std::abs(whole[i] - sum[i]) <= 1e-4 * sizes))
        throw std::domain_error(
            "the scene is not linear: the effect of two deviations is not the sum of their "
            "effects");
    }
  }

  Loop start_, work_;
  std::vector<double> before_, after_;
  double amplitude_;
};

/// What the map over the next packet period depends on: its ticks, and when the packets in flight
/// were sent and arrive.
template <typename Loop>
[[nodiscard]] std::vector<std::int64_t> pattern_of(Loop& loop) {
  const std::int64_t now = loop.slot();
  std::vector<std::int64_t> pattern{loop.packet_slots().period_from(now)};
  loop.visit_links([&](int, int, auto& port) {
    pattern.push_back(port.age(now));
    pattern.push_back(port.link().in_flight());
    port.link().visit_flights([&](std::int64_t sent, double arrival) {
      pattern.push_back(now - sent);
      pattern.push_back(static_cast<std::int64_t>(std::ceil(arrival)) - now);
    });
  });
  return pattern;
}

}  // namespace tandem::analysis
