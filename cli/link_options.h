#pragma once

#include <string>

#include <CLI/CLI.hpp>

#include "core/link_model.h"

namespace tandem::cli {

/// What packets meet on every link of a modelled network, as options.
struct LinkOptions {
  double delay_ms = 0.0, jitter_ms = 0.0;
  std::string jitter_kind = "normal";
  double loss = 0.0, burst_enter = 0.0, burst_leave = 1.0;
  bool fifo = false;

  /// To a command that has --delay-packets already, which says the same otherwise.
  void add(CLI::App& command);
  /// `local_hz` counts its ticks.
  [[nodiscard]] core::LinkModelParameters model(double local_hz) const;
};

}  // namespace tandem::cli
