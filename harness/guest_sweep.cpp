#include "harness/guest_sweep.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <memory>
#include <numeric>
#include <thread>

#include <fmt/format.h>

#include "harness/caretaker.h"
#include "harness/harness_error.h"

namespace tandem::harness {
namespace {

constexpr std::size_t kMostGuests = 2;
constexpr std::chrono::minutes kSilence{15};  // a prediction for many users takes minutes

/// "its points: a, b".
[[nodiscard]] std::string points_of(const Sweep& sweep, const SweepPart& part) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < sweep.points.size(); ++i)
    if (part.has(i)) names.push_back(sweep.points[i].name);
  return fmt::format("its points: {}", fmt::join(names, ", "));
}

/// A guest with its part of the sweep.
struct Worker {
  SweepPart part;
  std::unique_ptr<Guest> guest;
  bool running = true;
  std::chrono::steady_clock::time_point heard = std::chrono::steady_clock::now();

  [[nodiscard]] std::string results() const { return guest->folder() + "/results"; }
  [[nodiscard]] std::string name() const { return "guest " + part.text(); }
};

}  // namespace

std::string progress_line(int done, int all, const std::string& doing) {
  return fmt::format("progress {} {} {}\n", done, all, doing);
}

bool AddedProgress::take(std::size_t worker, const std::string& line) {
  int done = 0, all = 0, used = 0;
  if (std::sscanf(line.c_str(), "progress %d %d %n", &done, &all, &used) != 2 || used == 0)
    return false;
  done_.at(worker) = done;
  all_.at(worker) = all;
  doing_ = line.substr(static_cast<std::size_t>(used));
  return true;
}

int AddedProgress::done() const { return std::accumulate(done_.begin(), done_.end(), 0); }
int AddedProgress::all() const { return std::accumulate(all_.begin(), all_.end(), 0); }

std::size_t guests_for(const Sweep& sweep) {
  return std::min({kMostGuests, processors_for_guests().size(), sweep.points.size()});
}

std::vector<PartResults> run_in_guests(const GuestKernel& kernel, GuestClock clock,
                                       const std::vector<std::string>& words, const Sweep& sweep,
                                       const RealProgress& progress,
                                       const std::function<void(const std::string&)>& say) {
  const std::size_t count = guests_for(sweep);
  const std::vector<int> processors = processors_for_guests();
  std::vector<Worker> workers;
  for (std::size_t i = 0; i < count; ++i) {
    Worker& worker = workers.emplace_back();
    worker.part = {i, count};
    worker.guest = std::make_unique<Guest>(kernel, clock, processors[i]);
    std::vector<std::string> own = words;
    own.insert(own.end(), {"--part", worker.part.text(), "--part-results", worker.results()});
    worker.guest->start(own);
  }
  AddedProgress added(count);
  progress(0, 0, "user-mode Linux boots");
  const auto look = [&](std::size_t i) {
    Worker& worker = workers[i];
    Guest::Said said;
    worker.running = worker.guest->look(said);
    bool news = false;
    for (const std::string& line : said.out)
      if (added.take(i, line))
        news = true;
      else
        say(worker.name() + ": " + line);
    for (const std::string& line : said.err) say(worker.name() + ": " + line);
    const auto now = std::chrono::steady_clock::now();
    if (!said.out.empty() || !said.err.empty()) worker.heard = now;
    if (worker.running && now - worker.heard > kSilence)
      throw HarnessError("nothing heard of it for 15 min: it hangs");
    if (news) progress(added.done(), added.all(), added.doing());
    if (!worker.running && worker.guest->status() != 0)
      throw HarnessError(fmt::format("what it ran ended with status {} (it said why above)",
                                     *worker.guest->status()));
  };
  const auto any_runs = [&] {
    return std::any_of(workers.begin(), workers.end(), [](const Worker& w) { return w.running; });
  };
  while (any_runs()) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    if (Caretaker::interrupted()) throw Interrupted();
    for (std::size_t i = 0; i < count; ++i) {
      if (!workers[i].running) continue;
      try {
        look(i);
      } catch (const Interrupted&) {
        throw;
      } catch (const HarnessError& e) {
        throw HarnessError(fmt::format("{}: {}\n{}", workers[i].name(), e.what(),
                                       points_of(sweep, workers[i].part)));
      }
    }
  }
  std::vector<PartResults> parts;
  for (const Worker& worker : workers) parts.push_back(read_part(worker.results()));
  return parts;
}

}  // namespace tandem::harness
