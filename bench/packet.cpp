#include "bench/packet.h"

#include <array>
#include <chrono>
#include <cstring>
#include <memory>
#include <net/wire.pb.h>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "bench/report.h"
#include "core/allocation_counter.h"
#include "net/state_codec.h"

namespace tandem::bench {

namespace {

using Clock = std::chrono::steady_clock;
constexpr int kPackets = 20000;  // a timed round, about 3 ms
constexpr std::uint64_t kSession = 0x1234567890abcdefu;

core::StatePacket sample_packet(int values) {
  core::StatePacket packet;
  packet.sender = 1;
  packet.sequence = 1000;
  packet.slot = 8000;
  packet.send_ns = 123456789012345;
  packet.echo_ns = 123456781012345;
  packet.echo_hold_ns = 4321;
  packet.contact_bits = 0x22;
  packet.energy_in = 0.125;
  packet.energy_out = 0.25;
  packet.value_count = values;
  for (int i = 0; i < values; ++i) packet.values[i] = 0.01 * (i + 1);
  return packet;
}

/// Nanoseconds a packet, encoded and decoded by net's codec. `moved` keeps the work from being
/// thrown away and the packets different.
double time_codec(net::StateEncoder& encoder, net::StateDecoder& decoder, core::StatePacket& sent,
                  double& moved) {
  core::StatePacket got;
  const auto start = Clock::now();
  for (int i = 0; i < kPackets; ++i) {
    ++sent.sequence;
    sent.values[0] += 1e-9;
    if (decoder.decode(encoder.encode(sent, kSession), got) == net::Decode::kOk)
      moved += got.values[0];
  }
  return std::chrono::duration<double, std::nano>(Clock::now() - start).count() / kPackets;
}

struct Bare {
  net::wire::State out, in;
  std::array<char, 1400> buffer{};
};

/// The same fields through protobuf alone: no prefix, no check of anything.
double time_bare(Bare& bare, core::StatePacket& sent, double& moved) {
  core::StatePacket got;
  const auto start = Clock::now();
  for (int i = 0; i < kPackets; ++i) {
    ++sent.sequence;
    sent.values[0] += 1e-9;
    bare.out.set_session(kSession);
    bare.out.set_sender(sent.sender);
    bare.out.set_sequence(sent.sequence);
    bare.out.set_slot(sent.slot);
    bare.out.set_send_ns(sent.send_ns);
    bare.out.set_echo_ns(sent.echo_ns);
    bare.out.set_echo_hold_ns(sent.echo_hold_ns);
    bare.out.set_contact_bits(sent.contact_bits);
    bare.out.set_energy_in(sent.energy_in);
    bare.out.set_energy_out(sent.energy_out);
    bare.out.mutable_values()->Resize(sent.value_count, 0.0);
    std::memcpy(bare.out.mutable_values()->mutable_data(), sent.values.data(),
                sizeof(double) * static_cast<std::size_t>(sent.value_count));
    const auto size = static_cast<int>(bare.out.ByteSizeLong());
    bare.out.SerializeWithCachedSizesToArray(reinterpret_cast<std::uint8_t*>(bare.buffer.data()));
    if (!bare.in.ParseFromArray(bare.buffer.data(), size)) continue;
    got.sender = bare.in.sender();
    got.sequence = bare.in.sequence();
    got.slot = bare.in.slot();
    got.send_ns = bare.in.send_ns();
    got.echo_ns = bare.in.echo_ns();
    got.echo_hold_ns = bare.in.echo_hold_ns();
    got.contact_bits = bare.in.contact_bits();
    got.energy_in = bare.in.energy_in();
    got.energy_out = bare.in.energy_out();
    got.value_count = bare.in.values_size();
    std::memcpy(got.values.data(), bare.in.values().data(),
                sizeof(double) * static_cast<std::size_t>(got.value_count));
    moved += got.values[0];
  }
  return std::chrono::duration<double, std::nano>(Clock::now() - start).count() / kPackets;
}

struct Row {
  int values = 0;
  std::size_t bytes = 0;
  double codec_ns = 0.0, bare_ns = 0.0;
  std::uint64_t allocations = 0;
};

Row measure(int values, int rounds) {
  core::StatePacket packet = sample_packet(values);
  net::StateEncoder encoder;
  net::StateDecoder decoder;
  decoder.expect(packet.sender, kSession, values);
  auto bare = std::make_unique<Bare>();
  Row row;
  row.values = values;
  row.bytes = encoder.encode(packet, kSession).size();
  std::vector<double> codec, floor;
  codec.reserve(static_cast<std::size_t>(rounds));
  double moved = 0.0;
  time_codec(encoder, decoder, packet, moved);
  time_bare(*bare, packet, moved);
  const std::uint64_t before = core::counted_allocations();
  for (int r = 0; r < rounds; ++r) {  // interleaved: both see the same machine
    {
      const core::CountAllocations counting;
      codec.push_back(time_codec(encoder, decoder, packet, moved));
    }
    floor.push_back(time_bare(*bare, packet, moved));
  }
  row.allocations = core::counted_allocations() - before;
  row.codec_ns = median(codec);
  row.bare_ns = median(floor);
  if (!(moved > 0.0)) row.codec_ns = -1.0;  // nothing was decoded: say so by an impossible time
  return row;
}

void run(int rounds, const std::string& json_file) {
  std::vector<Row> rows;
  for (const int values : {20, 44, 128}) rows.push_back(measure(values, rounds));
  const Row& planar = rows[0];  // about what two fingers and a box with velocities take
  nlohmann::ordered_json json;
  json["encode_decode_ns"] = planar.codec_ns;
  json["protobuf_floor_ns"] = planar.bare_ns;
  json["ratio"] = planar.codec_ns / planar.bare_ns;
  std::uint64_t allocations = 0;
  for (const Row& row : rows) allocations += row.allocations;
  if (core::allocation_hook_linked())
    json["allocations"] = allocations;
  else
    json["allocations"] = nullptr;
  json["values"] = planar.values;
  json["bytes"] = planar.bytes;
  std::string text =
      "encode and decode of one state packet, ns (median)\n"
      "  values  bytes   Tandem   bare protobuf   ratio   allocations\n";
  for (const Row& row : rows) {
    text += fmt::format("  {:6} {:6} {:8.1f} {:15.1f} {:7.2f} {:13}\n", row.values, row.bytes,
                        row.codec_ns, row.bare_ns, row.codec_ns / row.bare_ns, row.allocations);
    json["rows"].push_back({{"values", row.values},
                            {"bytes", row.bytes},
                            {"encode_decode_ns", row.codec_ns},
                            {"protobuf_floor_ns", row.bare_ns},
                            {"allocations", row.allocations}});
  }
  report(json_file, text, json);
}

}  // namespace

void add_bench_packet(CLI::App& bench) {
  CLI::App* app = bench.add_subcommand("packet", "encode and decode beside bare protobuf");
  auto rounds = std::make_shared<int>(101);
  auto json_file = std::make_shared<std::string>();
  app->add_option("--rounds", *rounds, "timed rounds of each, interleaved; the median counts")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  app->add_option("--json", *json_file, "write the result as JSON to this file; - is the output");
  app->callback([rounds, json_file] { run(*rounds, *json_file); });
}

}  // namespace tandem::bench
