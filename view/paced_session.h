#pragma once

#include <atomic>
#include <functional>
#include <thread>

#include "core/latest_value.h"
#include "core/network_model.h"
#include "core/scene.h"
#include "devices/pointer_feed.h"
#include "view/snapshot.h"

namespace tandem::view {

/// A whole session in virtual time, paced by the clock of the wall: the loop of the scene's
/// architecture with its simulated hands, in a thread of its own, published once a packet period.
/// What is drawn solid is what `own` holds.
class PacedSession {
 public:
  struct Options {
    core::NetworkModel network{};
    double seconds = 0.0;  ///< 0: until destroyed
    double speed = 1.0;    ///< seconds of the session per second; 0: as fast as it is asked for
    int own = 0;           ///< user
    /// That user's fingers follow a pointer instead of the scene's script; nullptr: nobody's.
    devices::PointerFeed* pointer = nullptr;
  };

  PacedSession(const core::Scene& scene, const Options& options);
  ~PacedSession();
  PacedSession(const PacedSession&) = delete;
  PacedSession& operator=(const PacedSession&) = delete;

  /// False if nothing new was published.
  [[nodiscard]] bool fetch(Snapshot& out) noexcept { return newest_.fetch(out); }
  [[nodiscard]] bool ended() const noexcept { return ended_.load(std::memory_order_acquire); }
  /// Runs to the slot at this time, here and now; only with speed 0.
  void advance_to(double time);

 private:
  template <typename Loop>
  struct LoopRunner;
  template <typename Loop>
  void use(const core::Scene& scene);
  void run();

  Options options_;
  double T_;
  int ticks_per_packet_;  ///< rounded up where the ratio of the rates is not whole
  std::int64_t slot_ = 0;
  std::function<void()> tick_;
  std::function<void(Snapshot&)> fill_;
  core::LatestValue<Snapshot> newest_;
  std::atomic<bool> stop_{false}, ended_{false};
  std::thread thread_;
};

}  // namespace tandem::view
