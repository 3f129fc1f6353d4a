#include "net/probe.h"

#include <atomic>
#include <csignal>
#include <cstdio>
#include <memory>
#include <string>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "cli/commands.h"
#include "cli/options.h"
#include "core/realtime.h"
#include "net/udp_socket.h"

namespace tandem::cli {

namespace {

struct Arguments {
  std::string peer;
  bool serve = false;
  std::string bind = "0.0.0.0:0";
  net::ProbeOptions probe;
  int priority = 0;
  JsonOption json;
  std::string csv, picture;
};

std::atomic<bool> stop{false};
void on_signal(int) { stop = true; }

[[nodiscard]] nlohmann::ordered_json as_json(const net::ProbeResult& r, const std::string& peer) {
  return {{"peer", peer},
          {"sent", r.sent},
          {"received", r.received},
          {"lost", r.lost()},
          {"duplicates", r.duplicates},
          {"reordered", r.reordered},
          {"strangers", r.strangers},
          {"send_failures", r.send_failures},
          {"interrupted", r.interrupted},
          {"datagram_bytes", r.datagram},
          {"seconds", r.seconds},
          {"asked_rate_hz", r.asked_rate_hz},
          {"achieved_rate_hz", r.achieved_rate_hz},
          {"mean_round_trip_s", r.mean},
          {"rms_jitter_s", r.rms_jitter},
          {"jitter_rfc3550_s", r.jitter_rfc3550},
          {"round_trip_s",
           {{"min", r.min},
            {"p10", r.p10},
            {"p50", r.p50},
            {"p90", r.p90},
            {"p99", r.p99},
            {"p99.9", r.p999},
            {"max", r.max}}},
          {"thesis_table_1_1",
           {{"mean_round_trip_s", net::thesis::kMeanRoundTrip},
            {"rms_jitter_s", net::thesis::kRmsJitter},
            {"lost", net::thesis::kLost},
            {"packets", net::thesis::kPackets},
            {"stated_rate_hz", net::thesis::kStatedRate_hz},
            {"rate_from_packets_and_minutes_hz",
             net::thesis::kPackets / (60.0 * net::thesis::kMinutes)}}}};
}

[[nodiscard]] std::string as_csv(const net::ProbeResult& r) {
  std::string text = "number,round_trip_s\n";  // empty: lost
  for (std::size_t i = 0; i < r.round_trip_ns.size(); ++i)
    text += r.round_trip_ns[i] < 0
                ? fmt::format("{},\n", i + 1)
                : fmt::format("{},{:.9f}\n", i + 1, 1e-9 * static_cast<double>(r.round_trip_ns[i]));
  return text;
}

void serve(const Arguments& a, net::UdpLink& link) {
  fmt::print("answering probes on {}; end with Ctrl-C\n", net::to_string(link.local()));
  std::fflush(stdout);
  const auto answered = net::serve_probe(link, stop, a.probe.seconds);
  fmt::print("answered {} packets\n", answered);
}

std::string svg_file(const std::string& file) {
  if (!file.ends_with(".svg")) return file + ": this picture is an .svg file";
  return writable_file(file);
}

void measure(Arguments a, net::UdpLink& link) {
  if (a.probe.count == 0 && a.probe.seconds == 0.0) a.probe.seconds = 10.0;
  (void)a.probe.packets();  // complain before anything else happens
  const net::Endpoint peer = link.resolve(a.peer);
  // Where the JSON object goes to standard output, everything else goes to standard error.
  std::FILE* out = a.json.to_stdout() ? stderr : stdout;
  const bool show_progress = isatty(STDERR_FILENO) != 0;
  const auto result =
      net::run_probe(link, peer, a.probe, stop, [&](std::uint64_t sent, std::uint64_t received) {
        if (show_progress) fmt::print(stderr, "\r{} sent, {} back ", sent, received);
      });
  if (show_progress) fmt::print(stderr, "\r\033[K");
  if (result.received > 0)
    fmt::print(out, "{}\n{}", net::probe_table(result, a.peer), net::probe_histogram(result));
  if (!a.csv.empty()) write_text(a.csv, as_csv(result));
  if (!a.picture.empty()) write_text(a.picture, net::probe_picture(result, a.peer));
  if (a.json.wanted()) a.json.write(as_json(result, a.peer));
  if (result.received == 0)
    throw std::runtime_error(
        fmt::format("no answer from {}: 0 of {} packets came back; is 'tandem "
                    "probe --serve --bind 0.0.0.0:PORT' running there and the "
                    "port open?",
                    a.peer, result.sent));
}

void run(const Arguments& a) {
  if (a.serve != a.peer.empty())
    throw CLI::ValidationError(
        "probe",
        a.serve ? "give either --serve or HOST:PORT, not both"
                : "give HOST:PORT of a computer where 'tandem probe --serve' runs, or --serve");
  std::signal(SIGINT, on_signal);
  std::signal(SIGTERM, on_signal);
  net::UdpLink link(a.bind);
  const auto grant = core::request_realtime({.priority = a.priority,
                                             .lock_memory = false,
                                             .cpu = {},
                                             .timer_slack_ns = 1,
                                             .hold_cpu_dma_latency = false});
  if (a.priority > 0 || !grant.all_granted()) fmt::print(stderr, "{}", grant.report());
  if (a.serve)
    serve(a, link);
  else
    measure(a, link);
}

}  // namespace

/// tandem probe: Table 1.1 of the thesis between two hosts.
void add_probe(CLI::App& app) {
  auto* command = app.add_subcommand(
      "probe",
      "Measure a network: numbered packets to another host and back (Table 1.1 of the thesis).\n"
      "There: tandem probe --serve --bind 0.0.0.0:7001    Here: tandem probe HOST:7001");
  auto a = std::make_shared<Arguments>();
  command->add_option("peer", a->peer, "HOST:PORT where 'tandem probe --serve' runs");
  command->add_flag("--serve", a->serve, "send every probe packet back, until Ctrl-C or --seconds");
  command->add_option("--bind", a->bind, "our own ADDRESS:PORT")->capture_default_str();
  command->add_option("--rate", a->probe.rate_hz, "packets a second, at most 100000")
      ->capture_default_str();
  command->add_option("--count", a->probe.count, "packets to send, at most 10000000")
      ->check(CLI::Range(0, 10'000'000));
  command->add_option("--seconds", a->probe.seconds, "how long, at most 86400 (default 10)");
  command->add_option("--bytes", a->probe.datagram, "size of a datagram, 48 to 1200")
      ->capture_default_str();
  command->add_option("--priority", a->priority, "SCHED_FIFO priority, 1 to 99; 0: ordinary")
      ->check(CLI::Range(0, 99))
      ->capture_default_str();
  a->json.add(*command);
  command->add_option("--csv", a->csv, "write every round trip to FILE")
      ->check(writable_file, "", "writable");
  command->add_option("--picture", a->picture, "write a histogram to FILE.svg")
      ->check(svg_file, "", "a picture");
  command->callback([a] { run(*a); });
}

}  // namespace tandem::cli
