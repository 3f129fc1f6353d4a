#pragma once

#include <string>

#include <CLI/CLI.hpp>

#include "cli/options.h"
#include "node/node_options.h"
#include "node/node_report.h"

namespace tandem::cli {

struct WindowArguments;

/// The options that server, client and replica have in common.
struct NodeArguments {
  JsonOption json;
  double seconds = 0.0;
  std::string record;
  std::string hands = "simulated", hand_file, hand_columns;
  double hand_after = -1.0;
  int priority = 80;
  int cpu = -1;
  double spin_us = -1.0;
  bool no_memory_lock = false, no_dma_latency = false;
  double status_every = 0.0;
  bool quiet = false;
  bool without_silence = false;
  long long start_ns = 0;
  std::string room, head_udp;
  bool view = false, view_hidden = false;
  std::string view_size = "1280x720", view_screenshot;
  double view_fps = 60.0;
  std::string on_unstable = "refuse";

  void add(CLI::App& command);
  [[nodiscard]] node::NodeOptions options(const std::string& bind) const;
  [[nodiscard]] WindowArguments window_arguments() const;  ///< where there is a viewer
  /// What has a node watch its delay against the scene's predicted stability; without a scene it is
  /// predicted when it is known. Throws Failed: unstable whatever the network does.
  [[nodiscard]] node::GuardMaker guard(const core::Scene* scene) const;
};

/// Prints the report and writes its JSON, with `window` in it if that is something; throws Failed
/// when the run ended badly.
void finish(const node::NodeReport& report, const JsonOption& json,
            const nlohmann::ordered_json& window = {});

}  // namespace tandem::cli
