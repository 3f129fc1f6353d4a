#pragma once

#include <optional>
#include <string>
#include <vector>

#include "analysis/knob.h"
#include "cli/analyze.h"

namespace tandem::cli {

/// One dimension of a sweep: fields of the scene set alike, or the delay, and the values they take.
///   FIELD[,FIELD...]=FROM:TO:COUNT[log|lin]     ends included
///   FIELD[,FIELD...]=VALUE,VALUE,...
///   delay_packets=...
struct SweepAxis {
  std::string name;
  std::vector<double> values;
  std::optional<analysis::Knob> knob;  ///< quick way to set it, where there is one
  bool is_delay = false;

  /// Edits for scene::load_scene.
  [[nodiscard]] std::vector<std::string> sets(double value) const;
};

/// Throws CLI::ValidationError or scene::SceneError: what is wrong with the text or a value of it.
[[nodiscard]] SweepAxis parse_axis(const core::Scene& scene, const std::string& text);

/// The points of some axes, the last one varying fastest, each as a linear scene and its network.
class SweepGrid {
 public:
  SweepGrid(const core::Scene& scene, std::vector<SweepAxis> axes, double delay_packets);

  [[nodiscard]] double count() const;  ///< may be more than fits anywhere
  [[nodiscard]] const std::vector<SweepAxis>& axes() const { return axes_; }
  [[nodiscard]] std::vector<double> values(std::int64_t point) const;
  /// `last` is what the same caller got before, to save reading the text of the scene again.
  void place(std::int64_t point, AnalyzedScene& last, double& delay_packets) const;

 private:
  core::Scene scene_;
  std::string text_;
  std::vector<SweepAxis> axes_;
  double delay_packets_;
  bool by_text_ = false;
};

}  // namespace tandem::cli
