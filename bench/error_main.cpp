#include <cstdio>
#include <exception>

#include <CLI/CLI.hpp>

#include "bench/error.h"

int main(int argc, char** argv) try {
  CLI::App program{"Work-precision bench of Tandem; the same as `tandem bench error`"};
  program.require_subcommand(1);
  tandem::bench::add_bench_error(program);
  CLI11_PARSE(program, argc, argv);
  return 0;
} catch (const std::exception& e) {
  std::fprintf(stderr, "%s\n", e.what());
  return 1;
}
