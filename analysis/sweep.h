#pragma once

#include <cstdint>
#include <functional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

/// Work over many points, cut into numbered items that do not know of each other: who does an item,
/// and when, changes no bit of it. So it can be spread over cores and machines, stopped, and gone
/// on with.
namespace tandem::analysis {

/// What one item came out as.
using SweepRow = std::vector<double>;
using SweepWork = std::function<SweepRow(std::int64_t item)>;

/// The sweep was asked to stop before all items were done.
class SweepStopped : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Gets items done.
class SweepRunner {
 public:
  virtual ~SweepRunner() = default;
  /// Rows of items 0 ... items-1, in order. `make_work` is called once a thread. Throws
  /// SweepStopped, or what an item threw.
  [[nodiscard]] virtual std::vector<SweepRow> run(const std::string& stage, std::int64_t items,
                                                  const std::function<SweepWork()>& make_work) = 0;
};

/// Does `items` on `threads` threads, the calling one among them. `finished(item, row)` is called
/// under a lock, in whatever order items end. False: `stop` said so. Throws what an item threw.
bool do_items(const std::vector<std::int64_t>& items, int threads,
              const std::function<SweepWork()>& make_work,
              const std::function<void(std::int64_t, SweepRow&&)>& finished,
              const std::function<bool()>& stop = {});

/// Threads of this process; nothing is kept. `progress(done, all)` after each item of a stage, by
/// one thread at a time; where it returns false the sweep stops.
class ThreadedRunner : public SweepRunner {
 public:
  using Progress = std::function<bool(std::int64_t done, std::int64_t all)>;
  explicit ThreadedRunner(int threads = 1, Progress progress = {})
      : threads_(threads), progress_(std::move(progress)) {}
  [[nodiscard]] std::vector<SweepRow> run(const std::string& stage, std::int64_t items,
                                          const std::function<SweepWork()>& make_work) override;

 private:
  int threads_;
  Progress progress_;
};

}  // namespace tandem::analysis
