#pragma once

#include <complex>
#include <functional>
#include <string>
#include <vector>

#include "analysis/boundary.h"
#include "analysis/experiments.h"

/// The figures of chapters 5 and 6 of the thesis, from the shipped scenes and the edits its text
/// names. Nothing here is typed in that a scene or an edit can say.
namespace tandem::analysis {

/// Figs 5.1-5.4: a map over two numbers of a scene.
struct MapPlan {
  std::string figure;             ///< "5.2"
  std::string scene;              ///< shipped scene
  std::vector<std::string> sets;  ///< what the text fixes
  std::string x_field, y_field;   ///< for Knob
  std::string x_label, y_label;   ///< with units
  Axis across, up;                ///< ranges; the thesis's own are not legible
};
/// Throws std::invalid_argument for any other figure.
[[nodiscard]] MapPlan map_plan(const std::string& figure);

struct Region {
  double round_trip = 0.0;  ///< [packet periods]
  StabilityMap map;
  std::vector<Segment> boundary;
  std::string road;
};
/// `progress(done, all)`: rows of cells; false stops (std::runtime_error).
[[nodiscard]] Region region(const MapPlan& plan, const core::Scene& scene, double round_trip,
                            int threads, const std::function<bool(int, int)>& progress = {});

/// Figs 6.2, 6.4, 6.5: curves over frequency.
struct Curve {
  std::string name;
  double round_trip = 0.0;
  bool has_round_trip = false;  ///< false: ideal, or a user without a network in the loop
  std::vector<std::complex<double>> values;
};
struct ResponseFigure {
  std::string figure, response;  ///< "6.2", "V/F [m/(N s)]"
  std::vector<double> omega;     ///< [rad/s]
  std::vector<Curve> curves;
};
/// What chapter 6 compares. The wall and the compensation are the figures' own.
struct ResponseSettings {
  core::Scene central, distributed;
  std::vector<double> round_trips{1.0};
  int points = 200;
  double compensation = 3.0;       ///< Fig 6.4 [N s/m]
  core::Gain wall{30000.0, 20.0};  ///< Fig 6.5
  bool fast = false;               ///< force held over a tick (fundamental), not a packet
};
/// 0.1 rad/s to just below half the packet rate, evenly on a logarithmic scale. Throws
/// std::invalid_argument for another figure, std::domain_error for scenes that have no such curves.
[[nodiscard]] ResponseFigure response_figure(const std::string& figure,
                                             const ResponseSettings& settings);

/// Drag of `user` moving the object alone, (6.2) against the sampled velocity [N s/m].
[[nodiscard]] double drag_alone(const core::Scene& scene, int user, double round_trip);

/// Table 6.2: what is printed, beside ours with the numbers the caption names and with those that
/// come nearest [N s/m].
struct Table62Row {
  std::string model;  ///< "distributed, original"
  double printed = 0.0;
  double caption = 0.0;  ///< Table 6.1, N as in the scene, no delay
  double nearest = 0.0;  ///< with `nearest_numbers`
  std::string nearest_numbers;
};
/// `table_8_2`: a planar scene whose normal gains are taken for the second reading.
[[nodiscard]] std::vector<Table62Row> table_6_2(const core::Scene& central,
                                                const core::Scene& distributed,
                                                const core::Scene& table_8_2, double round_trip);

}  // namespace tandem::analysis
