#include <CLI/CLI.hpp>

#include "bench/tick.h"

int main(int argc, char** argv) {
  CLI::App program{"Planar tick bench of Tandem; the same as `tandem bench tick`"};
  program.require_subcommand(1);
  tandem::bench::add_bench_tick(program);
  CLI11_PARSE(program, argc, argv);
  return 0;
}
