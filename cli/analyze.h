#pragma once

#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "analysis/lifted.h"
#include "cli/commands.h"
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
  [[nodiscard]] std::string grasp() const;    ///< plane: where each finger holds; lines to print
};

/// What every `tandem analyze` command on one scene takes.
struct AnalyzeOptions {
  SceneOption scene;
  JsonOption json;
  double delay_packets = 0.0;
  bool own_packet_timer = false;

  void add(CLI::App& command);
  [[nodiscard]] AnalyzedScene load() const;
  /// The same, refusing a scene of walls only: `what` is about an object.
  [[nodiscard]] AnalyzedScene load_with_object(const std::string& what) const;
  /// The three ways out: `csv` to a file if one is named, `text` to people unless standard output
  /// is the object's, and the object.
  void tell(const std::string& csv_file, const std::string& csv, const std::string& text,
            const nlohmann::ordered_json& object) const;
};

/// `--csv FILE`: what would be in it is said in the help.
void add_csv(CLI::App& command, std::string& file, const std::string& help);

/// When the command is chosen `run` gets its options; what no analysis can judge fails with why.
template <typename Options>
void on_call(CLI::App& command, std::shared_ptr<Options> options, void (*run)(const Options&)) {
  command.callback([options = std::move(options), run] {
    try {
      run(*options);
    } catch (const std::domain_error& e) {
      throw Failed(e.what());
    }
  });
}

void add_analyze_admittance(CLI::App& analyze);
void add_analyze_bounds(CLI::App& analyze);
void add_analyze_compensate(CLI::App& analyze);
void add_analyze_network(CLI::App& analyze);
void add_analyze_stability(CLI::App& analyze);
void add_analyze_sweep(CLI::App& analyze);
void add_analyze_check(CLI::App& analyze);
void add_analyze_figure(CLI::App& analyze);

}  // namespace tandem::cli
