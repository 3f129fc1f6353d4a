#include "node/supervisor.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <memory>
#include <optional>
#include <thread>
#include <unistd.h>

#include <fmt/format.h>

#include "core/allocation_counter.h"
#include "node/site_name.h"
#include "node/stability_guard.h"

namespace tandem::node {
namespace {

using namespace std::chrono_literals;

constexpr auto kLookEvery = 20ms;
constexpr int kHangLooks = 25;  // half a second of our own time: a stopped process does not count
constexpr double kLiveEvery = 0.2, kLogEvery = 5.0;  // [s]

[[nodiscard]] double length(const core::Vec3& v) {
  return std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z);
}

/// Watches the delay for a node. Outside the stable region it lets the peers go: their force fades
/// out by the scene's silence rule, here and there, and then the node ends.
class DelayWatch {
 public:
  DelayWatch(const SessionSetup& setup, net::PeerLink& link, StopRequest& stop)
      : setup_(setup), link_(link), stop_(stop) {
    if (setup.options.guard) guard_ = setup.options.guard(setup.scene);
    if (guard_ != nullptr) act(guard_->at_start());
  }

  /// Why the node has to end; empty: it does not.
  [[nodiscard]] const std::string& failure() const { return failure_; }

  void look() {
    const auto now = std::chrono::steady_clock::now();
    if (!failure_.empty()) {
      if (now >= end_) stop_.request();
      return;
    }
    if (guard_ == nullptr) return;
    std::optional<double> longest;
    for (const std::uint32_t sender : setup_.peers) {
      const net::PeerStatus status = link_.status(sender);
      if (status.connected && status.delay_known)
        longest = std::max(longest.value_or(0.0), status.round_trip);
    }
    act(guard_->look(std::chrono::duration<double>(now - start_).count(), longest));
  }

 private:
  void act(const StabilityGuard::Finding& finding) {
    if (finding.text.empty()) return;
    std::fprintf(stderr, "%s: %s\n", site_name(setup_.role, setup_.user).c_str(),
                 finding.text.c_str());
    if (!finding.refuses) return;
    failure_ =
        "refused: the measured delay is outside the stable region, see above "
        "(--on-unstable warn goes on all the same)";
    link_.stop();
    const auto& silence = setup_.scene.silence;
    const double fade = silence ? silence->timeout + silence->fade : 0.0;
    end_ = std::chrono::steady_clock::now() +
           std::chrono::duration_cast<std::chrono::steady_clock::duration>(
               std::chrono::duration<double>(fade));
  }

  const SessionSetup& setup_;
  net::PeerLink& link_;
  StopRequest& stop_;
  std::unique_ptr<StabilityGuard> guard_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now(), end_ = start_;
  std::string failure_;
};

}  // namespace

Supervisor::Supervisor(const SessionSetup& setup, net::PeerLink& link,
                       const recording::RecordingWriter* recording, LoopShare& share,
                       std::span<devices::HapticDevice* const> devices)
    : setup_(setup), link_(link), recording_(recording), share_(share), devices_(devices) {}

void Supervisor::watch() {
  const bool on_terminal = isatty(STDERR_FILENO) == 1 && setup_.options.status_every <= 0.0;
  const double every = setup_.options.status_every > 0.0 ? setup_.options.status_every
                       : on_terminal                     ? kLiveEvery
                                                         : kLogEvery;
  auto next_status = std::chrono::steady_clock::now() + std::chrono::duration<double>(every);
  DelayWatch delay(setup_, link_, share_.stop);
  while (!share_.ended.load(std::memory_order_acquire)) {
    std::this_thread::sleep_for(kLookEvery);
    look_for_hang();
    tell_messages();
    delay.look();
    if (failure_.empty()) failure_ = delay.failure();
    if (std::chrono::steady_clock::now() < next_status) continue;
    next_status += std::chrono::duration_cast<std::chrono::steady_clock::duration>(
        std::chrono::duration<double>(every));
    (void)share_.status.fetch(loop_);
    if (!setup_.options.quiet && loop_.slot >= 0) tell_status(on_terminal);
  }
  if (line_open_) std::fputc('\n', stderr);
  line_open_ = false;
}

void Supervisor::look_for_hang() {
  const std::int64_t beat = share_.heartbeat.load(std::memory_order_relaxed);
  const bool moved = beat != last_beat_ || beat < 0;
  silent_looks_ = moved ? 0 : silent_looks_ + 1;
  last_beat_ = beat;
  if (silent_looks_ != kHangLooks) return;
  for (devices::HapticDevice* device : devices_) device->stop();
  failure_ = fmt::format("the force loop hangs since slot {}: devices stopped", beat);
  share_.stop.request();
}

void Supervisor::tell_messages() {
  const auto tell = [this](const std::string& text) {
    std::fprintf(stderr, "%s%s: %s\n", line_open_ ? "\r\033[K" : "",
                 site_name(setup_.role, setup_.user).c_str(), text.c_str());
    line_open_ = false;
  };
  for (const net::LinkMessage& message : link_.take_messages()) tell(message.text);
  // Asked without waiting, with all messages taken: "refused" is a refusal, and final.
  const net::JoinResult joined = link_.wait_until_joined(0.0);
  if (!joined.joined && joined.error == "refused" && failure_.empty()) {
    failure_ = "a host has refused us, see above";
    share_.stop.request();
  }
  if (recording_ == nullptr || recording_failure_told_) return;
  const std::string failure = recording_->status().failure;
  if (failure.empty()) return;
  recording_failure_told_ = true;
  tell(failure);
}

void Supervisor::tell_status(bool on_terminal) {
  const std::string line = status_line();
  if (on_terminal) {
    std::fprintf(stderr, "\r\033[K%s", line.c_str());
    line_open_ = true;
  } else {
    std::fprintf(stderr, "status: %s\n", line.c_str());
  }
  std::fflush(stderr);
}

std::string Supervisor::status_line() const {
  const double span = 1e-9 * static_cast<double>(loop_.now_ns - loop_.first_ns);
  const auto us = [](std::int64_t ns) { return 1e-3 * static_cast<double>(ns); };
  std::string line = fmt::format("{} {:6.1f} s | {:.1f} Hz woke p50 {:.0f} p99 {:.0f} us missed {}",
                                 site_name(setup_.role, setup_.user), span,
                                 span > 0.0 ? static_cast<double>(loop_.ticks - 1) / span : 0.0,
                                 us(loop_.wakeups.percentile_ns(0.5)),
                                 us(loop_.wakeups.percentile_ns(0.99)), loop_.missed);
  for (const std::uint32_t sender : setup_.peers) {
    const net::PeerStatus status = link_.status(sender);
    if (status.epoch == 0) continue;
    const net::LinkSnapshot link = link_.statistics(sender);
    const auto i = static_cast<std::size_t>(sender % core::kMaxUsers);
    line += fmt::format(" | {}: out {} in {} lost {} rtt {:.0f} us age {:.1f} ms gain {:.2f}",
                        setup_.name_of(sender), link.packets_sent, link.accepted, link.lost,
                        1e6 * status.round_trip, 1e3 * loop_.ages[i], loop_.gains[i]);
  }
  double force = 0.0;
  for (const core::Vec3& f : loop_.command) force = std::max(force, length(f));
  return line + fmt::format(" | force {:.2f} N", force);
}

void Supervisor::fill(NodeReport& report) {
  tell_messages();
  (void)share_.status.fetch(loop_);
  report.role = setup_.role;
  report.user = setup_.user;
  report.seconds = setup_.options.seconds;
  report.local_hz = setup_.scene.rates.local_hz;
  report.packet_hz = setup_.scene.rates.packet_hz;
  report.loop = loop_;
  for (const std::uint32_t sender : setup_.peers) {
    PeerReport peer;
    peer.name = setup_.name_of(sender);
    peer.sender = sender;
    peer.link = link_.statistics(sender);
    peer.status = link_.status(sender);
    peer.gain = loop_.gains[sender % core::kMaxUsers];
    report.peers.push_back(peer);
  }
  report.strays = link_.strays();
  report.allocations_in_force_loop = core::counted_allocations();
  report.allocations_counted = core::allocation_hook_linked();
  if (recording_ != nullptr) {
    report.recording = setup_.options.record_file;
    report.recorded = recording_->status();
    if (!report.recorded.failure.empty() && failure_.empty()) failure_ = report.recorded.failure;
  }
  report.stop_signal = share_.stop.signal();
  report.failure = failure_;
}

}  // namespace tandem::node
