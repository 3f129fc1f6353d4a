#pragma once

#include <stdexcept>
#include <string>

#include <CLI/CLI.hpp>

/// One subcommand a file; each adds itself with a function of this form and does its work in its
/// callback. Wrong input throws (scene::SceneError, CLI::ValidationError), a run that ends badly
/// throws Failed.
namespace tandem::cli {

class Failed : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

void add_analyze(CLI::App& app);
void add_bench(CLI::App& app);
void add_client(CLI::App& app);
void add_demo(CLI::App& app);
void add_netem(CLI::App& app);
void add_probe(CLI::App& app);
void add_replay(CLI::App& app);
void add_replica(CLI::App& app);
void add_scene(CLI::App& app);
void add_server(CLI::App& app);
void add_simulate(CLI::App& app);
void add_view(CLI::App& app);

void add_all(CLI::App& app);

/// Program version with the revision it was built from.
[[nodiscard]] std::string version_text();
/// The revision alone.
[[nodiscard]] std::string revision_text();

}  // namespace tandem::cli
