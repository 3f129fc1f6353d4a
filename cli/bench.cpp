#include "bench/analysis.h"
#include "bench/cost.h"
#include "bench/error.h"
#include "bench/latency.h"
#include "bench/packet.h"
#include "bench/scale.h"
#include "bench/tick.h"
#include "bench/view.h"
#include "bench/wakeup.h"
#include "cli/commands.h"

namespace tandem::cli {

void add_bench(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "bench", "measure Tandem beside a peer in the same run; run it on a quiet machine");
  command->require_subcommand(1);
  bench::add_bench_analysis(*command);
  bench::add_bench_error(*command);
  bench::add_bench_cost(*command);
  bench::add_bench_tick(*command);
  bench::add_bench_latency(*command);
  bench::add_bench_packet(*command);
  bench::add_bench_scale(*command);
  bench::add_bench_view(*command);
  bench::add_bench_wakeup(*command);
}

}  // namespace tandem::cli
