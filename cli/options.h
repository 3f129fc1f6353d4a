#pragma once

#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "core/scene.h"

namespace tandem::cli {

/// `--scene NAME|FILE` and any number of `--set PATH=VALUE`, the same on every command.
struct SceneOption {
  std::string scene;
  std::vector<std::string> sets;

  void add(CLI::App& command, const std::string& default_scene = "");
  /// The validated scene; throws scene::SceneError.
  [[nodiscard]] core::Scene load() const;
};

/// `--json FILE`, where - is standard output (then nothing else is printed there).
struct JsonOption {
  std::string file;

  void add(CLI::App& command);
  [[nodiscard]] bool to_stdout() const { return file == "-"; }
  [[nodiscard]] bool wanted() const { return !file.empty(); }
  /// Writes one object; throws Failed when the file cannot be written.
  void write(const nlohmann::ordered_json& object) const;
};

/// A number, or null where it is not finite: JSON has no infinity.
[[nodiscard]] nlohmann::ordered_json number(double value);

/// Of an option's text, for CLI11's check: what is wrong with it; empty: nothing.
[[nodiscard]] std::string not_negative(const std::string& number);

/// CLI::Range that refuses what is no number too: every comparison with NaN is false.
[[nodiscard]] inline CLI::Validator between(double low, double high) {
  return CLI::Validator(
      [=](std::string& text) {
        double x = 0.0;
        if (CLI::detail::lexical_cast(text, x) && x >= low && x <= high) return std::string();
        return text + " is not between " + CLI::detail::to_string(low) + " and " +
               CLI::detail::to_string(high);
      },
      "FLOAT in [" + CLI::detail::to_string(low) + " - " + CLI::detail::to_string(high) + "]");
}

/// Why the text is no seed: numbers below 0 would be read as huge ones. Empty: it is one.
[[nodiscard]] std::string seed_number(const std::string& text);

/// Why the file could not be written, to be told before the work and not after it; empty: it can.
/// "-" is standard output.
[[nodiscard]] std::string writable_file(const std::string& file);

/// Writes a whole text file; throws Failed with the reason when it cannot.
void write_text(const std::string& file, const std::string& text);

}  // namespace tandem::cli
