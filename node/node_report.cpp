#include "node/node_report.h"

#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "node/site_name.h"

namespace tandem::node {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kFaultNames[kFaultBits] = {"overrun",     "device_read",     "stale_peer",
                                                 "not_finite",  "force_saturated", "force_slewed",
                                                 "device_write"};

[[nodiscard]] double microseconds(std::int64_t ns) { return 1e-3 * static_cast<double>(ns); }

[[nodiscard]] Json delays_us(const net::DelaySummary& d) {
  return {{"count", d.count},   {"mean", 1e6 * d.mean}, {"rms_jitter", 1e6 * d.rms_jitter},
          {"p50", 1e6 * d.p50}, {"p99", 1e6 * d.p99},   {"p99.9", 1e6 * d.p999},
          {"max", 1e6 * d.max}};
}

[[nodiscard]] Json reasons(const net::DecodeCounts& counts) {
  Json object = Json::object();
  for (int r = 1; r < net::kDecodeReasons; ++r) {
    const auto reason = static_cast<net::Decode>(r);
    if (counts.of(reason) == 0) continue;
    std::string name = net::name_of(reason);
    for (char& c : name)
      if (c == ' ') c = '_';
    object[name] = counts.of(reason);
  }
  return object;
}

[[nodiscard]] double loss_of(const net::LinkSnapshot& link) {
  const double all = static_cast<double>(link.accepted + link.reordered + link.lost);
  return all > 0.0 ? static_cast<double>(link.lost) / all : 0.0;
}

}  // namespace

double NodeReport::loop_hz() const {
  const double time = 1e-9 * static_cast<double>(loop.now_ns - loop.first_ns);
  return loop.ticks > 1 && time > 0.0 ? static_cast<double>(loop.ticks - 1) / time : 0.0;
}

std::uint64_t NodeReport::packets_sent() const {
  std::uint64_t sum = 0;
  for (const PeerReport& peer : peers) sum += peer.link.packets_sent;
  return sum;
}

std::uint64_t NodeReport::packets_accepted() const {
  std::uint64_t sum = 0;
  for (const PeerReport& peer : peers) sum += peer.link.accepted;
  return sum;
}

std::uint64_t NodeReport::sequence_errors() const {
  std::uint64_t sum = 0;
  for (const PeerReport& p : peers) sum += p.link.lost + p.link.reordered + p.link.duplicates;
  return sum;
}

std::uint64_t NodeReport::rejected() const {
  std::uint64_t sum = strays.rejected();
  for (const PeerReport& peer : peers) sum += peer.link.by_reason.rejected();
  return sum;
}

nlohmann::ordered_json to_json(const NodeReport& r) {
  Json j;
  j["role"] = r.role;
  j["user"] = r.user;
  j["seconds"] = r.seconds;
  j["ticks"] = r.loop.ticks;
  j["missed_ticks"] = r.loop.missed;
  j["late_wakeups"] = r.loop.late_wakeups;
  j["loop_hz"] = r.loop_hz();
  j["wakeup_us"] = {{"p50", microseconds(r.loop.wakeups.percentile_ns(0.5))},
                    {"p99", microseconds(r.loop.wakeups.percentile_ns(0.99))},
                    {"p99.9", microseconds(r.loop.wakeups.percentile_ns(0.999))},
                    {"max", microseconds(r.loop.wakeups.max_ns())}};
  j["packet_slots"] = r.loop.packet_slots;
  j["packets_sent"] = r.packets_sent();
  j["packets_received"] = r.packets_accepted();
  j["sequence_errors"] = r.sequence_errors();
  j["rejected"] = r.rejected();
  j["strays"] = reasons(r.strays);
  j["largest_force_n"] = r.loop.largest_force;
  Json faults = Json::object();
  for (int b = 0; b < kFaultBits; ++b)
    if (r.loop.faults[b] > 0) faults[kFaultNames[b]] = r.loop.faults[b];
  j["ticks_with_fault"] = faults;
  j["allocations_in_force_loop"] =
      r.allocations_counted ? Json(r.allocations_in_force_loop) : Json(nullptr);
  j["peers"] = Json::array();
  for (const PeerReport& p : r.peers) {
    j["peers"].push_back({{"name", p.name},
                          {"joined", p.status.epoch},
                          {"sent", p.link.packets_sent},
                          {"received", p.link.accepted},
                          {"lost", p.link.lost},
                          {"loss", loss_of(p.link)},
                          {"reordered", p.link.reordered},
                          {"duplicates", p.link.duplicates},
                          {"rejected", reasons(p.link.by_reason)},
                          {"rtt_us", delays_us(p.link.round_trip)},
                          {"one_way_us", delays_us(p.link.one_way)},
                          {"one_way_bound_us", 1e6 * p.link.one_way_bound},
                          {"jitter_rfc3550_us", 1e6 * p.link.jitter_rfc3550},
                          {"send_failures", p.link.send_failures},
                          {"clock_restarts", p.link.clock_restarts},
                          {"impossible_stamps", p.link.impossible_stamps},
                          {"gain", p.gain}});
  }
  j["realtime"] = Json::array();
  for (const core::RealtimeSetting& s : r.realtime)
    j["realtime"].push_back(
        {{"name", s.name}, {"asked", s.asked}, {"granted", s.granted}, {"refusal", s.refusal}});
  j["spin_us"] = microseconds(r.spin_ns);
  if (!r.recording.empty())
    j["recording"] = {{"file", r.recording},
                      {"ticks", r.recorded.ticks_safe},
                      {"packets", r.recorded.packets_safe},
                      {"lost", r.recorded.lost},
                      {"failure", r.recorded.failure}};
  j["stop_signal"] = r.stop_signal;
  if (!r.failure.empty()) j["failure"] = r.failure;
  return j;
}

std::string to_text(const NodeReport& r) {
  std::string text = fmt::format(
      "{}: {} ticks at {:.2f} Hz, {} missed; woke late by p50 {:.1f}, p99 {:.1f}, p99.9 {:.1f} "
      "us\n",
      site_name(r.role, r.user), r.loop.ticks, r.loop_hz(), r.loop.missed,
      microseconds(r.loop.wakeups.percentile_ns(0.5)),
      microseconds(r.loop.wakeups.percentile_ns(0.99)),
      microseconds(r.loop.wakeups.percentile_ns(0.999)));
  for (const PeerReport& p : r.peers) {
    if (p.status.epoch == 0) {
      text += fmt::format("  {} never joined\n", p.name);
      continue;
    }
    text += fmt::format(
        "  with {}: sent {}, received {}, lost {} ({:.3f} %), reordered {}, twice {}, rejected {}; "
        "round trip p50 {:.0f}, p99 {:.0f} us; one way p50 {:.0f} +- {:.0f} us{}\n",
        p.name, p.link.packets_sent, p.link.accepted, p.link.lost, 100.0 * loss_of(p.link),
        p.link.reordered, p.link.duplicates, p.link.by_reason.rejected(),
        1e6 * p.link.round_trip.p50, 1e6 * p.link.round_trip.p99, 1e6 * p.link.one_way.p50,
        1e6 * p.link.one_way_bound,
        p.link.clock_restarts > 0 ? fmt::format("; clock jumped {} times", p.link.clock_restarts)
                                  : "");
  }
  if (r.strays.rejected() > 0) {
    text += "  datagrams from nobody we know, counted and not felt:";
    for (int i = 1; i < net::kDecodeReasons; ++i) {
      const auto reason = static_cast<net::Decode>(i);
      if (r.strays.of(reason) > 0)
        text += fmt::format(" {} {};", r.strays.of(reason), net::name_of(reason));
    }
    text += "\n";
  }
  text += fmt::format("  largest force {:.2f} N; allocations in the force loop: {}\n",
                      r.loop.largest_force,
                      r.allocations_counted ? std::to_string(r.allocations_in_force_loop)
                                            : std::string("not counted"));
  if (!r.recording.empty())
    text += fmt::format("  recorded {} ticks, {} packets in {}{}\n", r.recorded.ticks_safe,
                        r.recorded.packets_safe, r.recording,
                        r.recorded.lost > 0 ? fmt::format(", {} lost", r.recorded.lost) : "");
  if (!r.failure.empty()) text += "  " + r.failure + "\n";
  return text;
}

}  // namespace tandem::node
