#include "cli/commands.h"

namespace tandem::cli {

void add_all(CLI::App& app) {
  add_demo(app);
  add_view(app);
  add_simulate(app);
  add_analyze(app);
  add_scene(app);
  add_server(app);
  add_client(app);
  add_replica(app);
  add_replay(app);
  add_netem(app);
  add_probe(app);
  add_bench(app);
}

std::string version_text() { return "tandem " TANDEM_VERSION " (" TANDEM_REVISION ")"; }

std::string revision_text() { return TANDEM_REVISION; }

}  // namespace tandem::cli
