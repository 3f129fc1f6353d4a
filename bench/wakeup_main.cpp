#include <CLI/CLI.hpp>

#include "bench/wakeup.h"

int main(int argc, char** argv) {
  CLI::App program{"Wake-up bench of Tandem; the same as `tandem bench wakeup`"};
  program.require_subcommand(1);
  tandem::bench::add_bench_wakeup(program);
  CLI11_PARSE(program, argc, argv);
  return 0;
}
