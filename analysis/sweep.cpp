#include "analysis/sweep.h"

#include <atomic>
#include <exception>
#include <mutex>
#include <numeric>
#include <thread>

namespace tandem::analysis {

bool do_items(const std::vector<std::int64_t>& items, int threads,
              const std::function<SweepWork()>& make_work,
              const std::function<void(std::int64_t, SweepRow&&)>& finished,
              const std::function<bool()>& stop) {
  std::atomic<std::size_t> next{0};
  std::atomic<bool> stopped{false};
  std::exception_ptr failure;
  std::mutex one_at_a_time;
  const auto work = [&] {
    try {
      const SweepWork own = make_work();
      while (!stopped) {
        const std::size_t i = next++;
        if (i >= items.size()) return;
        if (stop && stop()) {
          stopped = true;
          return;
        }
        SweepRow row = own(items[i]);
        const std::lock_guard lock(one_at_a_time);
        finished(items[i], std::move(row));
      }
    } catch (...) {
      const std::lock_guard lock(one_at_a_time);
      if (!failure) failure = std::current_exception();
      stopped = true;
    }
  };
  std::vector<std::thread> others;
  for (int t = 1; t < threads && t < static_cast<int>(items.size()); ++t) others.emplace_back(work);
  work();
  for (std::thread& t : others) t.join();
  if (failure) std::rethrow_exception(failure);
  return !stopped;
}

std::vector<SweepRow> ThreadedRunner::run(const std::string& /*stage*/, std::int64_t items,
                                          const std::function<SweepWork()>& make_work) {
  std::vector<SweepRow> rows(static_cast<std::size_t>(items));
  std::vector<std::int64_t> all(rows.size());
  std::iota(all.begin(), all.end(), 0);
  std::int64_t done = 0;
  std::atomic<bool> go_on{true};
  const auto finished = [&](std::int64_t item, SweepRow&& row) {
    rows[static_cast<std::size_t>(item)] = std::move(row);
    if (progress_ && !progress_(++done, items)) go_on = false;
  };
  if (!do_items(all, threads_, make_work, finished, [&] { return !go_on; }))
    throw SweepStopped("stopped before the sweep was complete");
  return rows;
}

}  // namespace tandem::analysis
