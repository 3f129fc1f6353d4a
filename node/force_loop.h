#pragma once

#include <array>
#include <atomic>
#include <cmath>
#include <cstdint>

#include "core/allocation_counter.h"
#include "core/clock.h"
#include "core/fault.h"
#include "core/latest_value.h"
#include "core/packet_slots.h"
#include "core/periodic_schedule.h"
#include "core/records.h"
#include "core/wakeup_statistics.h"
#include "node/stop_request.h"
#include "node/tick_log.h"

namespace tandem::node {

inline constexpr int kFaultBits = 7;  ///< core::Fault

/// How the loop goes, for people; published by the force thread now and then.
struct LoopStatus {
  std::int64_t slot = -1;                 ///< newest that ran
  std::int64_t ticks = 0;                 ///< that ran
  std::int64_t missed = 0;                ///< slots that did not
  std::int64_t first_ns = 0, now_ns = 0;  ///< wake-up of the first and of the newest tick
  std::int64_t late_wakeups = 0;          ///< by a period or more: slots were missed
  std::int64_t packet_slots = 0;          ///< packets every peer was sent one in
  core::WakeupStatistics wakeups;
  std::array<std::int64_t, kFaultBits> faults{};  ///< ticks with each fault bit
  std::array<double, core::kMaxUsers> gains{};    ///< of each peer
  std::array<double, core::kMaxUsers> ages{};     ///< of each peer's newest sample [s]
  std::array<core::Vec3, core::kMaxFingers> command{};
  double largest_force = 0.0;  ///< commanded so far, any finger [N]
};

/// One slot as a site sees it.
struct Slot {
  std::int64_t number = 0;
  std::int64_t woke_ns = 0;
  bool sends = false;  ///< a packet leaves in it
};

/// Runs one site of a session in real time. `Site` does a tick's work:
///   void tick(const Slot&, core::TickRecord&, TickLog&) noexcept   fills hands, command, objects,
///       contact bits, ages, fresh bits and faults; logs the packets it used
///   void report(LoopStatus&) const noexcept                        gains
///
/// A packet leaves in the ticks that core/packet_slots.h says; when such a slot was missed, in the
/// first one that runs after it. Nothing here allocates, locks, logs or throws.
template <typename Site>
class ForceLoop {
 public:
  struct Settings {
    std::int64_t start_ns = 0;
    double rate_hz = 1024.0;
    core::PacketSlots packet_slots;
    std::int64_t end_slot = 0;  ///< the first slot that does not run any more; 0: until stopped
    std::int64_t spin_ns = 0;
  };

  ForceLoop(Site& site, TickLog& log, core::LatestValue<LoopStatus>& status,
            std::atomic<std::int64_t>& heartbeat)
      : site_(site), log_(log), status_out_(status), heartbeat_(heartbeat) {}

  void run(const Settings& settings, const StopRequest& stop, core::Clock& clock) noexcept {
    core::PeriodicSchedule schedule(settings.start_ns, settings.rate_hz, settings.spin_ns);
    const core::CountAllocations count;
    std::int64_t newest_packet = -1;
    core::TickRecord record;
    while (!stop.requested()) {
      const core::PeriodicSchedule::Wake wake = schedule.wait(clock);
      if (settings.end_slot > 0 && wake.slot >= settings.end_slot) {
        // Slots missed just before the end belong to the run.
        status_.missed += wake.missed - (wake.slot - settings.end_slot);
        break;
      }
      record = {};
      record.slot = wake.slot;
      record.due_ns = wake.due_ns;
      record.woke_ns = wake.woke_ns;
      const std::int64_t packet = settings.packet_slots.packet_at(wake.slot);
      const bool sends = packet != newest_packet;
      newest_packet = packet;
      site_.tick({wake.slot, wake.woke_ns, sends}, record, log_);
      if (clock.now_ns() >= schedule.due_ns(wake.slot + 1))
        record.faults |= static_cast<std::uint32_t>(core::Fault::kOverrun);
      log_.push(record);
      count_tick(wake, record, sends);
    }
    publish();
  }

 private:
  void count_tick(const core::PeriodicSchedule::Wake& wake, const core::TickRecord& record,
                  bool sends) noexcept {
    status_.slot = wake.slot;
    if (status_.ticks++ == 0) status_.first_ns = wake.woke_ns;
    status_.now_ns = wake.woke_ns;
    status_.missed += wake.missed;
    status_.late_wakeups += wake.missed > 0 ? 1 : 0;
    status_.packet_slots += sends ? 1 : 0;
    status_.wakeups.record(wake.lateness_ns, wake.missed);
    for (int b = 0; b < kFaultBits; ++b) status_.faults[b] += record.faults >> b & 1u;
    for (const core::Vec3& f : record.command) {
      const double squared = f.x * f.x + f.y * f.y + f.z * f.z;
      if (squared > largest_squared_) largest_squared_ = squared;
    }
    heartbeat_.store(wake.slot, std::memory_order_relaxed);
    if (status_.ticks % kPublishEvery != 0) return;
    status_.ages = record.ages;
    status_.command = record.command;
    publish();
  }

  void publish() noexcept {
    status_.largest_force = std::sqrt(largest_squared_);
    site_.report(status_);
    status_out_.publish(status_);
  }

  static constexpr std::int64_t kPublishEvery = 64;  // ticks: 18 kB are copied each time

  Site& site_;
  TickLog& log_;
  core::LatestValue<LoopStatus>& status_out_;
  std::atomic<std::int64_t>& heartbeat_;
  LoopStatus status_;
  double largest_squared_ = 0.0;
};

}  // namespace tandem::node
