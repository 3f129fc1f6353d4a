#include "cli/netem_real.h"

#include "cli/commands.h"

namespace tandem::cli {

void add_real_options(CLI::App&, RealRequest&) {}

bool do_chores(const RealRequest&) { return false; }

std::optional<int> run_elsewhere(const RealRequest&) { return std::nullopt; }

std::vector<harness::PointResult> run_real(const harness::Sweep&, const RealRequest&,
                                           const std::function<bool(int, int)>&) {
  throw Failed("sweeps on real sockets are not in this build yet; add --virtual");
}

std::string real_setting() { return {}; }

}  // namespace tandem::cli
