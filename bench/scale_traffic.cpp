#include "bench/scale_traffic.h"

#include <algorithm>
#include <arpa/inet.h>
#include <array>
#include <atomic>
#include <cmath>
#include <ctime>
#include <memory>
#include <netinet/in.h>
#include <pthread.h>
#include <stdexcept>
#include <sys/socket.h>
#include <thread>
#include <unistd.h>

#include "core/clock.h"
#include "core/periodic_schedule.h"
#include "core/realtime.h"
#include "core/wakeup_statistics.h"
#include "net/state_codec.h"
#include "net/udp_socket.h"

namespace tandem::bench {
namespace {

constexpr std::uint64_t kSceneHash = 1;
constexpr double kSettle = 0.25;  // of the exchange, before the window [s]

double seconds_of(clockid_t clock) {
  timespec t{};
  clock_gettime(clock, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}
double processor_seconds(std::thread& thread) {
  clockid_t clock{};
  return pthread_getcpuclockid(thread.native_handle(), &clock) == 0 ? seconds_of(clock) : 0.0;
}

core::RealtimeRequest request(int priority) {
  return {.priority = priority,
          .lock_memory = false,
          .cpu = {},
          .timer_slack_ns = 1,
          .hold_cpu_dma_latency = priority > 0};
}

/// One of the other users: a session and a socket of its own.
struct Guest {
  net::UdpLink link{"127.0.0.1:0"};
  std::unique_ptr<net::GuestSession> session;
  net::StateDecoder decoder;
  core::StatePacket packet, got;
  std::int64_t arrival_ns = 0;
  bool ready = false;
};

/// All other users, for one thread.
class Guests {
 public:
  Guests(const TrafficHost& host, const net::Endpoint& at) : host_(host), at_(at) {
    for (std::size_t u = 0; u < host.from_user.size(); ++u) {
      if (host.from_user[u].value_count == 0) continue;
      auto guest = std::make_unique<Guest>();
      net::GuestOptions options;
      options.host = at;
      options.user_name = host.user_names[u];
      options.scene_hash = kSceneHash;
      options.seed = u + 1;
      guest->session = std::make_unique<net::GuestSession>(options);
      guest->packet = host.from_user[u];
      guest->packet.sender = static_cast<std::uint32_t>(u);
      guests_.push_back(std::move(guest));
    }
  }

  /// Sessions and what came in. True: everybody has joined.
  bool look() {
    bool all = true;
    for (const auto& guest : guests_) {
      const std::int64_t now = core::monotonic_ns();
      receive(*guest, now);
      guest->session->poll(now);
      while (auto datagram = guest->session->next_datagram())
        guest->link.send(datagram->to, datagram->bytes);
      while (guest->session->next_event()) {
      }
      if (!guest->ready && guest->session->state() == net::GuestSession::State::kJoined) {
        guest->ready = true;
        guest->decoder.expect(host_.own_sender, guest->session->welcome().session,
                              host_.values_out);
      }
      all = all && guest->ready;
    }
    return all;
  }

  void send(std::int64_t slot) {
    for (const auto& guest : guests_) {
      core::StatePacket& p = guest->packet;
      ++p.sequence;
      p.slot = slot;
      p.send_ns = core::monotonic_ns();
      p.echo_ns = guest->got.send_ns;
      p.echo_hold_ns = p.echo_ns != 0 ? p.send_ns - guest->arrival_ns : 0;
      guest->link.send(at_, encoder_.encode(p, guest->session->welcome().session));
    }
  }

  void leave() {
    for (const auto& guest : guests_) guest->session->leave();
    (void)look();
  }

  [[nodiscard]] std::int64_t decoded() const { return decoded_.load(std::memory_order_relaxed); }

 private:
  void receive(Guest& guest, std::int64_t now) {
    std::array<std::uint8_t, net::kMaxDatagram + 1> buffer;
    net::Endpoint from;
    while (const auto size = guest.link.receive(from, buffer)) {
      const std::span<const std::uint8_t> datagram(buffer.data(), *size);
      const auto prefix = net::prefix_of(datagram);
      if (prefix && prefix->kind == net::Kind::kControl) {
        guest.session->on_datagram(datagram, from, now);
      } else if (guest.ready && guest.decoder.decode(datagram, guest.got) == net::Decode::kOk) {
        guest.session->heard(now);
        guest.arrival_ns = now;
        decoded_.fetch_add(1, std::memory_order_relaxed);
      }
    }
  }

  const TrafficHost& host_;
  net::Endpoint at_;
  net::StateEncoder encoder_;
  std::vector<std::unique_ptr<Guest>> guests_;
  std::atomic<std::int64_t> decoded_{0};
};

net::PeerLinkOptions link_options(const TrafficHost& host, int priority) {
  net::HostOptions session;
  session.own_sender = host.own_sender;
  session.user_names = host.user_names;
  for (const core::StatePacket& packet : host.from_user)
    session.seats.push_back(packet.value_count == 0 ? net::Seat::kTaken : net::Seat::kOpen);
  session.scene_hash = kSceneHash;
  session.scene_text = "not asked for";
  session.packet_hz = host.packet_hz;
  net::PeerLinkOptions options;
  options.bind = "127.0.0.1:0";
  options.host = session;
  options.realtime = request(priority);
  return options;
}

void sleep_until(double seconds) {
  core::MonotonicClock().sleep_until(static_cast<std::int64_t>(1e9 * seconds));
}

struct Counts {
  double time = 0.0, process = 0.0, force = 0.0, others = 0.0, own = 0.0;
  double in = 0.0, out = 0.0, bytes_in = 0.0, bytes_out = 0.0, decoded = 0.0;
};

}  // namespace

Traffic run_traffic(const TrafficHost& host, const TrafficOptions& options) {
  const int link_priority = std::max(0, options.priority - 1);
  net::PeerLink link(link_options(host, link_priority));
  link.start();
  Guests guests(host, link.local());

  // Everybody joins, then all clocks start.
  const double patience = 1e-9 * static_cast<double>(core::monotonic_ns()) + 5.0;
  while (!guests.look()) {
    if (1e-9 * static_cast<double>(core::monotonic_ns()) > patience)
      return {.why_not = "not everybody could join within 5 s"};
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  const std::int64_t start_ns = core::monotonic_ns() + 20'000'000;
  net::ExchangeOptions exchange;
  exchange.own_sender = host.own_sender;
  exchange.start_ns = start_ns;
  exchange.packet_hz = host.packet_hz;
  exchange.local_hz = host.local_hz;
  exchange.values_from.fill(-1);
  for (std::size_t u = 0; u < host.from_user.size(); ++u)
    if (host.from_user[u].value_count > 0) exchange.values_from[u] = host.from_user[u].value_count;
  link.open_exchange(exchange);

  std::atomic<bool> stop{false}, counting{false};
  std::int64_t ticks = 0, missed = 0;
  core::WakeupStatistics lateness;
  std::thread force([&] {
    const core::RealtimeGrant grant = core::request_realtime(request(options.priority));
    core::MonotonicClock clock;
    core::PeriodicSchedule schedule(start_ns, host.local_hz);
    const core::PacketSlots slots = core::PacketSlots::of(host.local_hz, host.packet_hz);
    std::int64_t newest = -1;
    while (!stop.load(std::memory_order_relaxed)) {
      const auto wake = schedule.wait(clock);
      const std::int64_t packet = slots.packet_at(wake.slot);
      host.tick(wake.slot, packet != newest, link);
      newest = packet;
      if (!counting.load(std::memory_order_relaxed)) continue;
      ++ticks;
      missed += wake.missed;
      lateness.record(wake.lateness_ns, wake.missed);
    }
  });
  std::thread others([&] {
    const core::RealtimeGrant grant =
        core::request_realtime(request(std::max(0, link_priority - 1)));
    core::MonotonicClock clock;
    core::PeriodicSchedule schedule(start_ns + 300'000, host.packet_hz);
    while (!stop.load(std::memory_order_relaxed)) {
      const auto wake = schedule.wait(clock);
      guests.send(wake.slot);
      (void)guests.look();
    }
    guests.leave();
  });

  const auto count = [&] {
    Counts c;
    for (std::size_t u = 0; u < host.from_user.size(); ++u) {
      if (host.from_user[u].value_count == 0) continue;
      const net::LinkSnapshot s = link.statistics(static_cast<std::uint32_t>(u));
      c.in += static_cast<double>(s.accepted), c.out += static_cast<double>(s.packets_sent);
      c.bytes_in += static_cast<double>(s.bytes_received);
      c.bytes_out += static_cast<double>(s.bytes_sent);
    }
    c.decoded = static_cast<double>(guests.decoded());
    c.force = processor_seconds(force), c.others = processor_seconds(others);
    c.own = seconds_of(CLOCK_THREAD_CPUTIME_ID);
    c.process = seconds_of(CLOCK_PROCESS_CPUTIME_ID);
    c.time = 1e-9 * static_cast<double>(core::monotonic_ns());
    return c;
  };
  const double begin = 1e-9 * static_cast<double>(start_ns) + kSettle;
  sleep_until(begin);
  counting = true;
  const Counts a = count();
  sleep_until(begin + options.seconds);
  const Counts b = count();
  counting = false;
  stop = true;
  force.join();
  others.join();
  link.stop();

  const double span = b.time - a.time;
  Traffic t;
  t.in_per_s = (b.in - a.in) / span;
  t.out_per_s = (b.out - a.out) / span;
  t.delivered_per_s = (b.decoded - a.decoded) / span;
  t.bytes_in_per_s = (b.bytes_in - a.bytes_in) / span;
  t.bytes_out_per_s = (b.bytes_out - a.bytes_out) / span;
  t.force_share = (b.force - a.force) / span;
  t.others_share = (b.others - a.others) / span;
  t.link_share = (b.process - a.process - (b.own - a.own)) / span - t.force_share - t.others_share;
  t.missed_share =
      static_cast<double>(missed) / static_cast<double>(std::max<std::int64_t>(1, ticks + missed));
  t.late_p99_us = 1e-3 * static_cast<double>(lateness.percentile_ns(0.99));
  return t;
}

namespace {

/// A socket on the loopback interface, connected to itself.
class OwnSocket {
 public:
  OwnSocket() : socket_(::socket(AF_INET, SOCK_DGRAM, 0)) {
    sockaddr_in at{};
    at.sin_family = AF_INET;
    at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof at;
    auto* address = reinterpret_cast<sockaddr*>(&at);
    if (socket_ < 0 || bind(socket_, address, size) != 0 ||
        getsockname(socket_, address, &size) != 0 || connect(socket_, address, size) != 0) {
      if (socket_ >= 0) close(socket_);
      throw std::runtime_error("no UDP socket on the loopback interface (127.0.0.1)");
    }
  }
  ~OwnSocket() { close(socket_); }
  OwnSocket(const OwnSocket&) = delete;
  OwnSocket& operator=(const OwnSocket&) = delete;
  [[nodiscard]] int get() const { return socket_; }

 private:
  int socket_;
};

constexpr int kBlock = 32;

/// Datagrams a second of `block()`, which sends and receives kBlock of them and says how many.
template <typename Block>
double rate_of(double seconds, Block&& block) {
  const double start = seconds_of(CLOCK_MONOTONIC);
  double count = 0.0, now = start;
  for (; now < start + seconds; now = seconds_of(CLOCK_MONOTONIC)) count += block();
  return count / (now - start);
}

}  // namespace

LoopbackRate measure_loopback(std::size_t bytes, double seconds) {
  const OwnSocket socket;
  std::vector<char> out(bytes), in(kBlock * bytes);
  std::array<iovec, kBlock> sent{}, got{};
  std::array<mmsghdr, kBlock> to{}, from{};
  for (std::size_t i = 0; i < kBlock; ++i) {
    sent[i] = {out.data(), bytes};
    got[i] = {in.data() + i * bytes, bytes};
    to[i].msg_hdr.msg_iov = &sent[i], to[i].msg_hdr.msg_iovlen = 1;
    from[i].msg_hdr.msg_iov = &got[i], from[i].msg_hdr.msg_iovlen = 1;
  }
  LoopbackRate rate;
  rate.sendmmsg = rate_of(seconds, [&] {
    (void)sendmmsg(socket.get(), to.data(), kBlock, 0);
    return std::max(0, recvmmsg(socket.get(), from.data(), kBlock, MSG_DONTWAIT, nullptr));
  });
  rate.send = rate_of(seconds, [&] {
    for (int i = 0; i < kBlock; ++i) (void)send(socket.get(), out.data(), bytes, 0);
    int count = 0;
    while (count < kBlock && recv(socket.get(), in.data(), bytes, MSG_DONTWAIT) >= 0) ++count;
    return count;
  });
  return rate;
}

}  // namespace tandem::bench
