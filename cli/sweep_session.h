#pragma once

#include <chrono>
#include <csignal>
#include <memory>
#include <string>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "analysis/sweep.h"
#include "cli/sweep_file.h"
#include "core/scene.h"

namespace tandem::cli {

/// `--jobs N` and `--resume FILE`, the same on every command that sweeps.
struct SweepOptions {
  int jobs = 0;
  std::string resume;

  void add(CLI::App& command);
};

/// Runs the stages of one command's sweep on all cores (under mpirun: of all machines), tells how
/// far it is on a terminal, keeps what is finished when it is interrupted, and goes on from there.
class SweepSession : public analysis::SweepRunner {
 public:
  /// `command`: its name. `settings`: what results depend on; a file of others is refused.
  SweepSession(const SweepOptions& options, const std::string& command,
               nlohmann::ordered_json settings);
  ~SweepSession() override;
  SweepSession(const SweepSession&) = delete;
  SweepSession& operator=(const SweepSession&) = delete;

  /// Throws Failed when interrupted, saying how to go on.
  [[nodiscard]] std::vector<analysis::SweepRow> run(
      const std::string& stage, std::int64_t items,
      const std::function<analysis::SweepWork()>& make_work) override;

  /// Whether this process prints and writes: under mpirun only one does.
  [[nodiscard]] bool tells() const;

 private:
  struct Progress;
  [[nodiscard]] std::vector<std::int64_t> missing(
      const std::vector<analysis::SweepRow>& rows) const;
  [[noreturn]] void stopped(std::int64_t done, std::int64_t items, const std::string& stage);
  void keep(const std::string& stage, std::int64_t item, const analysis::SweepRow& row);
  void share(std::vector<analysis::SweepRow>& rows) const;

  int jobs_;
  std::string command_;
  nlohmann::ordered_json settings_;
  std::unique_ptr<SweepFile> file_;
  /// Without a file: what would be in it, should we be interrupted.
  std::vector<std::pair<std::string, std::vector<std::pair<std::int64_t, analysis::SweepRow>>>>
      kept_;
  struct sigaction before_int_ {
  }, before_term_{};
};

/// What every sweep over a scene depends on: the scene, all of it, and its delay.
[[nodiscard]] nlohmann::ordered_json scene_settings(const core::Scene& scene, double delay_packets);

/// Refuses what does not fit: `points` of `bytes` each. Throws Failed with both and what is free.
void refuse_too_large(double points, double bytes, const std::string& what);

}  // namespace tandem::cli
