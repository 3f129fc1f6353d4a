// What a feature costs that the scene does not declare: the shipped law's tick against the tick of
// the same law compiled without it, in processor time and in instructions, counted one by one.
//   bench_lacking ROUNDS     prints JSON
#include "bench/lacking.h"

#include <algorithm>
#include <array>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <sys/ptrace.h>
#include <sys/wait.h>
#include <unistd.h>
#include <vector>

// clang-format off
#define FOR_EACH_LAW(X) \
  X(shipped) X(again) X(walls) X(device) X(computation_delay) X(silence) X(extrapolation) \
  X(compensation) X(ground_friction) X(finger_friction) X(moment_cancellation) X(all)
#define DECLARE(name) namespace tandem_##name { extern const bench_lacking::Law kLaw; }
FOR_EACH_LAW(DECLARE)
// clang-format on

namespace {

struct Copy {
  const char* name;
  const bench_lacking::Law* law;
  std::array<double, 2> instructions{};             ///< a tick; 0: could not be counted
  std::array<std::vector<double>, 2> ns{}, cost{};  ///< of each round; the shipped law's less it
};

double median(std::vector<double> v) {
  std::sort(v.begin(), v.end());
  return v[v.size() / 2];
}
double half_the_middle_half(std::vector<double> v) {
  std::sort(v.begin(), v.end());
  return 0.5 * (v[3 * v.size() / 4] - v[v.size() / 4]);
}

/// Instructions of a child between two of its stops, one step of the debugger each; 0: not allowed.
long instructions_of(const bench_lacking::Law& law, int space, int ticks) {
  const pid_t child = fork();
  if (child == 0) {
    if (ptrace(PTRACE_TRACEME, 0, nullptr, nullptr) != 0) _exit(1);
    law.run(space, ticks, [] { raise(SIGSTOP); });
    _exit(0);
  }
  int status = 0;
  long steps = 0;
  waitpid(child, &status, 0);
  while (WIFSTOPPED(status)) {
    if (steps > 0 && WSTOPSIG(status) == SIGSTOP) break;
    if (ptrace(PTRACE_SINGLESTEP, child, nullptr, nullptr) != 0) break;
    ++steps;
    waitpid(child, &status, 0);
  }
  const bool counted = WIFSTOPPED(status) && WSTOPSIG(status) == SIGSTOP;
  if (!WIFEXITED(status)) {
    kill(child, SIGKILL);
    waitpid(child, &status, 0);
  }
  return counted ? steps : 0;
}

}  // namespace

int main(int argc, char** argv) {
  const int rounds = argc > 1 ? std::max(3, std::atoi(argv[1])) : 25;
  constexpr int kTicks = 8192;
  std::vector<Copy> copies;
#define ADD(name) copies.push_back({#name, &tandem_##name::kLaw});
  FOR_EACH_LAW(ADD)
  constexpr int kPacketPeriod = 8;
  for (int space = 0; space < 2; ++space) {
    for (Copy& c : copies) {
      const long none = instructions_of(*c.law, space, 0);
      const long all = instructions_of(*c.law, space, 2 * kPacketPeriod);
      if (none > 0 && all > none)
        c.instructions[space] = static_cast<double>(all - none) / (2 * kPacketPeriod);
    }
    for (int round = -2; round < rounds; ++round) {
      const std::size_t n = copies.size();
      std::vector<double> now(n);
      // Each round begins with another copy, so that nobody always follows the same one.
      for (std::size_t i = 0; i < n; ++i) {
        const std::size_t at = (i + static_cast<std::size_t>(round + 2)) % n;
        now[at] = copies[at].law->tick_ns(space, kTicks);
      }
      if (round < 0) continue;
      for (std::size_t i = 0; i < n; ++i) {
        copies[i].ns[space].push_back(now[i]);
        copies[i].cost[space].push_back(now[0] - now[i]);
      }
    }
  }
  std::printf("{\"rows\": [");
  const char* separator = "";
  for (int space = 0; space < 2; ++space)
    for (const Copy& c : copies) {
      const bool same = c.law->bits(space, 2000) == copies[0].law->bits(space, 2000);
      std::printf(
          "%s\n{\"space\": \"%s\", \"lacks\": \"%s\", \"tick_ns\": %.2f, \"cost_ns\": %.2f, "
          "\"spread_ns\": %.2f, \"instructions\": %.2f, \"cost_instructions\": %.2f, "
          "\"same_bits\": %s}",
          separator, space == 0 ? "axis" : "plane", c.name, median(c.ns[space]),
          median(c.cost[space]), half_the_middle_half(c.cost[space]), c.instructions[space],
          copies[0].instructions[space] - c.instructions[space], same ? "true" : "false");
      separator = ",";
    }
  std::printf("\n]}\n");
}
