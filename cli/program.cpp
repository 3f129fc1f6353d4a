#include "cli/program.h"

#include <algorithm>
#include <cstdio>
#include <exception>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "cli/commands.h"
#include "scene/nearest_name.h"
#include "scene/scene_error.h"

namespace tandem::cli {

namespace {

/// The first word that should be a command and is none, in words for whoever wrote it; empty: none.
std::string unknown_command(CLI::App& app, int argc, char** argv) {
  CLI::App* here = &app;
  for (int i = 1; i < argc && argv[i][0] != '-'; ++i) {
    const auto commands = here->get_subcommands({});
    if (commands.empty()) return {};
    const auto named = std::find_if(commands.begin(), commands.end(), [&](const CLI::App* command) {
      return command->get_name() == argv[i];
    });
    if (named != commands.end()) {
      here = *named;
      continue;
    }
    if (here->get_require_subcommand_min() == 0) return {};
    std::vector<std::string> known;
    for (const CLI::App* command : commands) known.push_back(command->get_name());
    return std::string("there is no command '") + argv[i] + "'" + scene::suggestion(argv[i], known);
  }
  return {};
}

}  // namespace

int run_program(int argc, char** argv) {
  constexpr int kFailed = 1, kWrongInput = 2;
  CLI::App app{
      "Tandem: several people hold and move the same virtual object, each with a force-feedback\n"
      "device at their own workstation.\n\n"
      "First steps:  tandem demo            two users move one box, as processes over UDP\n"
      "              tandem scene list      the scenes that come with the program\n"
      "              tandem simulate --scene box_distributed --seconds 60\n"};
  app.require_subcommand(1);
  app.set_version_flag("--version", version_text());
  app.fallthrough(false);
  add_all(app);

  if (const std::string wrong = unknown_command(app, argc, argv); !wrong.empty()) {
    std::fprintf(stderr, "%s\n", wrong.c_str());
    return kWrongInput;
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    const int code = app.exit(e);
    return code == 0 ? 0 : kWrongInput;
  } catch (const scene::SceneError& e) {
    std::fprintf(stderr, "%s\n", e.what());
    return kWrongInput;
  } catch (const Failed& e) {
    if (e.what()[0] != '\0') std::fprintf(stderr, "%s\n", e.what());
    return kFailed;
  } catch (const std::exception& e) {
    std::fprintf(stderr, "tandem: %s\n", e.what());
    return kFailed;
  }
  return 0;
}

}  // namespace tandem::cli
