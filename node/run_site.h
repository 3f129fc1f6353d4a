#pragma once

#include <cmath>
#include <cstdio>
#include <future>
#include <memory>
#include <thread>
#include <vector>

#include "core/clock.h"
#include "net/peer_link.h"
#include "node/force_loop.h"
#include "node/node_report.h"
#include "node/recording_header.h"
#include "node/session_setup.h"
#include "node/stop_request.h"
#include "node/supervisor.h"
#include "node/tick_log.h"

namespace tandem::node {

/// Runs a site to its end: force thread here, link thread in `link`, recording thread, and the
/// caller's own thread as supervisor. Whatever ends it, the devices are stopped, goodbye is said
/// and the recording is closed. `Site` is what ForceLoop wants, and
///   void stop() noexcept                                            devices at zero force
///   void append_devices(std::vector<devices::HapticDevice*>&) const
/// The link is started here if it is not running yet. Throws recording::RecordingError, or
/// std::runtime_error (demand_silence), before anything runs.
template <typename Site>
[[nodiscard]] NodeReport run_site(Site& site, const SessionSetup& setup, net::PeerLink& link) {
  demand_silence(setup);
  core::MonotonicClock clock;
  LoopShare share;
  std::vector<devices::HapticDevice*> devices;
  site.append_devices(devices);
  using Settings = typename ForceLoop<Site>::Settings;
  struct Start {
    ForceLoop<Site>* loop = nullptr;  ///< nullptr: do not start at all
    Settings settings;
  };

  const SignalGuard signals(share.stop, devices);
  NodeReport report;

  // What is asked of the system takes its time (every page locked): first that, then the clock
  // runs.
  std::promise<void> asked;
  std::promise<Start> start;
  std::thread force_thread([&] {
    const core::RealtimeGrant grant = core::request_realtime(setup.options.realtime);
    report.realtime = grant.settings();
    report.spin_ns = setup.options.spin_ns.value_or(grant.default_spin_ns());
    asked.set_value();
    Start given = start.get_future().get();
    if (given.loop != nullptr) {
      given.settings.spin_ns = report.spin_ns;
      given.loop->run(given.settings, share.stop, clock);
    }
    site.stop();
    share.ended.store(true, std::memory_order_release);
  });
  asked.get_future().wait();

  std::unique_ptr<recording::RecordingWriter> recording;
  std::unique_ptr<TickLog> log;
  std::unique_ptr<ForceLoop<Site>> loop;
  Settings settings;
  try {
    constexpr std::int64_t kTimeToStart_ns = 50'000'000;
    settings.start_ns =
        setup.options.start_ns > 0 ? setup.options.start_ns : clock.now_ns() + kTimeToStart_ns;
    settings.rate_hz = setup.scene.rates.local_hz;
    settings.packet_slots = setup.scene.packet_slots();
    settings.end_slot = std::llround(setup.options.seconds * settings.rate_hz);
    if (!setup.options.record_file.empty())
      recording = std::make_unique<recording::RecordingWriter>(
          setup.options.record_file, recording_header(setup, settings.start_ns), setup.columns);
    log = std::make_unique<TickLog>(recording.get(), setup.options.window, link.spectator_tap());
    loop = std::make_unique<ForceLoop<Site>>(site, *log, share.status, share.heartbeat);
    net::ExchangeOptions exchange = setup.exchange;
    exchange.start_ns = settings.start_ns;
    exchange.spectators = {setup.columns.fingers, setup.columns.hand_values, setup.columns.objects,
                           setup.columns.object_values, setup.columns.users};
    // Nobody is let in before all that can fail has not failed.
    tell_address(setup, link);
    link.start();
    link.open_exchange(exchange);
    tell_realtime(setup, report);
  } catch (...) {
    start.set_value({});
    force_thread.join();
    throw;
  }
  start.set_value({loop.get(), settings});
  Supervisor supervisor(setup, link, recording.get(), share, devices);
  try {
    supervisor.watch();
  } catch (...) {
    share.stop.request();
    force_thread.join();
    throw;
  }
  force_thread.join();

  // What the peers sent in their last slots is still on its way.
  constexpr auto kLastPackets = std::chrono::milliseconds(100);
  if (!share.stop.requested()) std::this_thread::sleep_for(kLastPackets);
  link.stop();
  if (recording != nullptr) recording->close();
  supervisor.fill(report);
  return report;
}

}  // namespace tandem::node
