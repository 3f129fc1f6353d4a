#pragma once

#include <CLI/CLI.hpp>

namespace tandem::bench {

/// `tandem bench packet [--json FILE]`: encode and decode of one state packet through net's codec
/// (prefix, checks, every field) beside bare protobuf with the same message, packed doubles,
/// reused. Keys: encode_decode_ns, protobuf_floor_ns, ratio, allocations, values, bytes, rows.
void add_bench_packet(CLI::App& bench);

}  // namespace tandem::bench
