#include "net/probe.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>

#include "core/clock.h"
#include "net/datagram.h"
#include "net/wire.pb.h"

namespace tandem::net {
namespace {

constexpr std::size_t kSmallestProbe = 48;

[[nodiscard]] std::invalid_argument out_of_range(const std::string& what, double value,
                                                 const std::string& range) {
  std::string number = std::to_string(value);
  number.erase(number.find_last_not_of('0') + 1);
  if (number.back() == '.') number.pop_back();
  return std::invalid_argument("probe: " + what + " is " + number + "; allowed: " + range);
}

[[nodiscard]] std::size_t write_probe(const wire::Probe& probe,
                                      std::array<std::uint8_t, kMaxDatagram>& buffer) {
  const std::size_t bytes = probe.ByteSizeLong();
  write_prefix(buffer, Kind::kProbe, bytes);
  probe.SerializeWithCachedSizesToArray(buffer.data() + kPrefixBytes);
  return kPrefixBytes + bytes;
}

}  // namespace

std::uint64_t ProbeOptions::packets() const {
  if (!(rate_hz > 0.0 && rate_hz <= kMaxProbeRate))
    throw out_of_range("rate", rate_hz, "above 0, at most 100000 packets a second");
  if (!(seconds >= 0.0 && seconds <= kMaxProbeSeconds))
    throw out_of_range("duration", seconds, "at most 86400 s");
  if (datagram < kSmallestProbe || datagram > kMaxDatagram)
    throw out_of_range("datagram size", static_cast<double>(datagram), "48 to 1200 bytes");
  if (count == 0 && seconds == 0.0)
    throw std::invalid_argument("probe: give a number of packets or a duration");
  double packets = std::numeric_limits<double>::infinity();
  if (count > 0) packets = static_cast<double>(count);
  if (seconds > 0.0) packets = std::min(packets, std::max(1.0, std::floor(seconds * rate_hz)));
  if (packets > static_cast<double>(kMaxProbeCount))
    throw out_of_range("number of packets", packets, "1 to 10000000");
  return static_cast<std::uint64_t>(packets);
}

ProbeResult run_probe(Link& link, const Endpoint& peer, const ProbeOptions& options,
                      const std::atomic<bool>& stop,
                      const std::function<void(std::uint64_t, std::uint64_t)>& progress) {
  const std::uint64_t packets = options.packets();
  ProbeResult result;
  result.asked_rate_hz = options.rate_hz;
  result.round_trip_ns.assign(packets, -1);

  std::random_device device;
  wire::Probe out, in;
  const std::uint64_t run = std::uint64_t{device()} << 32 | device() | 1;
  out.set_run(run);
  // 8 prefix, 27 for the three numbers, 2 or 3 for the tag and length of the padding.
  const std::size_t overhead = kPrefixBytes + 27 + (options.datagram > 8 + 27 + 2 + 127 ? 3 : 2);
  out.set_padding(std::string(options.datagram - overhead, '\0'));

  std::array<std::uint8_t, kMaxDatagram> buffer;
  std::array<std::uint8_t, kMaxDatagram + 1> incoming;
  ArrivalJitter jitter;
  std::uint64_t newest = 0;
  const auto receive_all = [&] {
    Endpoint from;
    while (const auto size = link.receive(from, incoming)) {
      const std::int64_t now = core::monotonic_ns();
      const std::span<const std::uint8_t> datagram(incoming.data(), *size);
      const auto prefix = prefix_of(datagram);
      if (!prefix || prefix->version != kProtocolVersion || prefix->kind != Kind::kProbeEcho ||
          from != peer ||
          !in.ParseFromArray(datagram.data() + kPrefixBytes,
                             static_cast<int>(datagram.size() - kPrefixBytes)) ||
          in.run() != run || in.number() == 0 || in.number() > result.sent || in.send_ns() > now ||
          in.send_ns() < 0) {
        ++result.strangers;
        continue;
      }
      std::int64_t& slot = result.round_trip_ns[in.number() - 1];
      if (slot >= 0) {
        ++result.duplicates;
        continue;
      }
      slot = now - in.send_ns();
      ++result.received;
      if (in.number() < newest) ++result.reordered;
      newest = std::max(newest, in.number());
      jitter.record(in.send_ns(), now);
    }
  };

  constexpr std::int64_t kShortWait_ns = 50'000'000;  // so that `stop` is seen
  const std::int64_t start = core::monotonic_ns();
  std::int64_t last_sent = start, next_progress = start + 1'000'000'000;
  const auto due = [&](std::uint64_t k) {
    return start + static_cast<std::int64_t>(1e9 * static_cast<double>(k) / options.rate_hz);
  };
  std::int64_t first_sent = start;
  for (std::uint64_t k = 0; k < packets && !stop;) {
    std::int64_t now = core::monotonic_ns();
    if (now >= due(k)) {
      out.set_number(k + 1);
      out.set_send_ns(now = core::monotonic_ns());
      const std::size_t size = write_probe(out, buffer);
      result.datagram = size;
      result.sent = k + 1;
      if (!link.send(peer, {buffer.data(), size})) ++result.send_failures;
      if (k == 0) first_sent = now;
      last_sent = now;
      ++k;
    } else {
      link.wait(std::min(due(k) - now, kShortWait_ns));
    }
    receive_all();
    if (progress && now >= next_progress) {
      progress(result.sent, result.received);
      next_progress += 1'000'000'000;
    }
  }
  const std::int64_t end = last_sent + static_cast<std::int64_t>(1e9 * options.patience);
  while (result.received < result.sent && !stop && core::monotonic_ns() < end) {
    link.wait(std::min(end - core::monotonic_ns(), kShortWait_ns));
    receive_all();
  }
  receive_all();
  result.interrupted = stop;
  result.seconds = 1e-9 * static_cast<double>(last_sent - first_sent);
  result.jitter_rfc3550 = jitter.jitter();
  summarise(result);
  return result;
}

void summarise(ProbeResult& r) {
  r.round_trip_ns.resize(r.sent);
  r.achieved_rate_hz = r.seconds > 0.0 ? static_cast<double>(r.sent - 1) / r.seconds : 0.0;
  r.sorted.clear();
  for (const std::int64_t ns : r.round_trip_ns)
    if (ns >= 0) r.sorted.push_back(1e-9 * static_cast<double>(ns));
  std::sort(r.sorted.begin(), r.sorted.end());
  if (r.sorted.empty()) return;
  const double n = static_cast<double>(r.sorted.size());
  r.mean = 0.0;
  for (const double t : r.sorted) r.mean += t / n;
  double squares = 0.0;
  for (const double t : r.sorted) squares += (t - r.mean) * (t - r.mean) / n;
  r.rms_jitter = std::sqrt(squares);
  const auto at = [&](double f) {
    return r.sorted[static_cast<std::size_t>(std::max(1.0, std::ceil(f * n))) - 1];
  };
  r.min = r.sorted.front();
  r.p10 = at(0.1);
  r.p50 = at(0.5);
  r.p90 = at(0.9);
  r.p99 = at(0.99);
  r.p999 = at(0.999);
  r.max = r.sorted.back();
}

std::uint64_t serve_probe(Link& link, const std::atomic<bool>& stop, double seconds) {
  std::array<std::uint8_t, kMaxDatagram + 1> buffer;
  Endpoint from;
  std::uint64_t answered = 0;
  const std::int64_t end = core::monotonic_ns() + static_cast<std::int64_t>(1e9 * seconds);
  while (!stop && (seconds == 0.0 || core::monotonic_ns() < end)) {
    link.wait(50'000'000);
    while (const auto size = link.receive(from, buffer)) {
      const auto prefix = prefix_of({buffer.data(), *size});
      if (!prefix || prefix->version != kProtocolVersion || prefix->kind != Kind::kProbe) continue;
      buffer[5] = static_cast<std::uint8_t>(Kind::kProbeEcho);
      if (link.send(from, {buffer.data(), *size})) ++answered;
    }
  }
  return answered;
}

}  // namespace tandem::net
