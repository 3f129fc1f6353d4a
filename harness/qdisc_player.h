#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "harness/child.h"
#include "harness/condition.h"

namespace tandem::harness {

/// One change of a condition that does not stay the same: an edge of an outage, an entry of a
/// recorded series.
struct ConditionChange {
  double time = 0.0;  ///< [s] from the start of the run
  std::vector<std::string> netem_arguments;
};

/// How often netem is told anew at most, for a series that changes faster [1/s].
inline constexpr double kLargestChangeRate = 100.0;

/// What has to be told to netem within [0, seconds], in the order of time; empty: nothing changes.
[[nodiscard]] std::vector<ConditionChange> changes_of(const Condition& condition, double seconds);

/// Plays changes into the netem of one network namespace while a session runs: one `tc -batch`
/// that waits there, and a thread that tells it when it is time. A change takes effect some tenths
/// of a millisecond after its time (up to a few in user-mode Linux), for packets sent after it;
/// packets on their way keep their delay.
class QdiscPlayer {
 public:
  QdiscPlayer(const std::string& network, std::vector<ConditionChange> changes,
              std::int64_t start_ns);
  ~QdiscPlayer();
  QdiscPlayer(const QdiscPlayer&) = delete;
  QdiscPlayer& operator=(const QdiscPlayer&) = delete;

  /// What tc complained about; empty: nothing.
  [[nodiscard]] std::string failure();

 private:
  Child tc_;
  std::jthread thread_;
};

}  // namespace tandem::harness
