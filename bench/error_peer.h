#pragma once

#include <cstdio>
#include <cstdlib>

#include "bench/error_run.h"

/// What every peer's program shares: it is asked for one point and prints one JSON line for each
/// setting and rate, which `tandem bench error` reads.
namespace tandem::bench {

inline void print_run(const char* setting, int hz, const ErrorRun& run) {
  std::printf(R"({"setting":"%s","hz":%d,"ns_per_s":%.17g,"samples":[)", setting, hz, run.ns_per_s);
  const char* comma = "";
  for (const double x : run.samples) {
    if (x - x == 0.0)
      std::printf("%s%.17g", comma, x);
    else
      std::printf("%snull", comma);  // JSON has no infinity
    comma = ",";
  }
  std::printf("]}\n");
}

/// The point named by the first argument, its index in kErrorPoints; ends the program if there is
/// none.
[[nodiscard]] inline const ErrorPoint& asked_point(int argc, char** argv) {
  const long index = argc == 2 ? std::strtol(argv[1], nullptr, 10) : -1;
  if (index < 0 || index >= static_cast<long>(kErrorPoints.size())) {
    std::fprintf(stderr, "usage: %s INDEX, 0 to %zu; `tandem bench error` calls this program\n",
                 argv[0], kErrorPoints.size() - 1);
    std::exit(2);
  }
  return kErrorPoints[static_cast<std::size_t>(index)];
}

template <typename Make>
void run_all_rates(const ErrorPoint& point, const char* setting, Make&& make) {
  for (const int hz : kErrorRates)
    print_run(setting, hz, measure(point, hz, [&] { return make(1.0 / hz); }));
}

}  // namespace tandem::bench
