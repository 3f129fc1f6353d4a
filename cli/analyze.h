#pragma once

#include <string>
#include <vector>

#include "analysis/lifted.h"
#include "cli/options.h"

namespace tandem::cli {

/// A scene made linear, with the links it is analysed over.
struct AnalyzedScene {
  core::Scene scene;
  core::NetworkModel network;
  std::vector<std::string> assumptions;

  /// Resampled where that applies, else measured on the running loop.
  [[nodiscard]] analysis::LiftedSystem lift() const;
  [[nodiscard]] std::string assumed() const;  ///< lines to print
};

/// What every `tandem analyze` command on one scene takes.
struct AnalyzeOptions {
  SceneOption scene;
  JsonOption json;
  double delay_packets = 0.0;
  bool own_packet_timer = false;

  void add(CLI::App& command);
  [[nodiscard]] AnalyzedScene load() const;
};

/// Of an option's text, for CLI11's check: what is wrong with it as a round trip; empty: nothing.
[[nodiscard]] std::string round_trip_packets(const std::string& text);

void add_analyze_admittance(CLI::App& analyze);
void add_analyze_network(CLI::App& analyze);
void add_analyze_stability(CLI::App& analyze);
void add_analyze_check(CLI::App& analyze);
void add_analyze_figure(CLI::App& analyze);

}  // namespace tandem::cli
