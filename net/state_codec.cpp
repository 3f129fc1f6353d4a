#include "net/state_codec.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <numeric>

#include "net/wire.pb.h"

namespace tandem::net {
namespace {

[[nodiscard]] bool stamp_in_range(std::int64_t stamp_ns) noexcept {
  return stamp_ns >= 0 && stamp_ns < limits::kMaxStamp_ns;
}

/// Largest |value| as an integer: without its sign a double's bits are ordered as its magnitude,
/// and infinity and NaN lie above every number. Four lanes, so that no comparison waits for
/// another.
[[nodiscard]] std::uint64_t largest_bits(const double* values, int count) noexcept {
  std::uint64_t lanes[4] = {};
  const auto take = [&](int lane, double value) {
    const std::uint64_t bits = std::bit_cast<std::uint64_t>(value) & 0x7fffffffffffffffu;
    lanes[lane] = bits > lanes[lane] ? bits : lanes[lane];
  };
  int i = 0;
  for (; i + 4 <= count; i += 4) {
    take(0, values[i]);
    take(1, values[i + 1]);
    take(2, values[i + 2]);
    take(3, values[i + 3]);
  }
  for (; i < count; ++i) take(0, values[i]);
  return std::max(std::max(lanes[0], lanes[1]), std::max(lanes[2], lanes[3]));
}

/// kOk if every number is finite and no larger than `limit`.
[[nodiscard]] Decode check(const double* values, int count, double limit) noexcept {
  const double largest = std::bit_cast<double>(largest_bits(values, count));
  if (largest <= limit) return Decode::kOk;
  return std::isfinite(largest) ? Decode::kOutOfRange : Decode::kNotFinite;
}

}  // namespace

const char* name_of(Decode reason) noexcept {
  static constexpr std::array<const char*, kDecodeReasons> kNames{
      "accepted",       "malformed",      "wrong magic", "wrong version",
      "unknown sender", "wrong session",  "wrong count", "not finite",
      "out of range",   "stale sequence", "duplicate"};
  const auto index = static_cast<std::size_t>(reason);
  return index < kNames.size() ? kNames[index] : "?";
}

std::uint64_t DecodeCounts::rejected() const noexcept {
  return std::accumulate(by_reason.begin() + 1, by_reason.end(), std::uint64_t{0});
}

struct StateEncoder::Message {
  wire::State state;
};

StateEncoder::StateEncoder() : message_(std::make_unique<Message>()) {
  message_->state.mutable_values()->Reserve(core::kMaxPacketValues);
}
StateEncoder::~StateEncoder() = default;

std::span<const std::uint8_t> StateEncoder::encode(const core::StatePacket& packet,
                                                   std::uint64_t session, Kind kind) noexcept {
  wire::State& m = message_->state;
  m.set_session(session);
  m.set_sender(packet.sender);
  m.set_sequence(packet.sequence);
  m.set_slot(packet.slot);
  m.set_send_ns(packet.send_ns);
  m.set_echo_ns(packet.echo_ns);
  m.set_echo_hold_ns(packet.echo_hold_ns);
  m.set_contact_bits(packet.contact_bits);
  m.set_energy_in(packet.energy_in);
  m.set_energy_out(packet.energy_out);
  const int count = std::clamp(packet.value_count, 0, core::kMaxPacketValues);
  auto* values = m.mutable_values();
  values->Resize(count, 0.0);
  std::memcpy(values->mutable_data(), packet.values.data(),
              static_cast<std::size_t>(count) * sizeof(double));

  const std::size_t bytes = m.ByteSizeLong();
  write_prefix(buffer_, kind, bytes);
  m.SerializeWithCachedSizesToArray(buffer_.data() + kPrefixBytes);
  return {buffer_.data(), kPrefixBytes + bytes};
}

struct StateDecoder::Message {
  wire::State state;
};

StateDecoder::StateDecoder(double max_magnitude)
    : message_(std::make_unique<Message>()), max_magnitude_(max_magnitude) {
  // No datagram holds more doubles than this, so parsing never grows the array.
  message_->state.mutable_values()->Reserve(static_cast<int>(kMaxDatagram / sizeof(double)));
}
StateDecoder::~StateDecoder() = default;

void StateDecoder::expect(std::uint32_t sender, std::uint64_t session,
                          std::int32_t value_count) noexcept {
  if (sender < expected_.size())
    expected_[sender] = {.known = true, .session = session, .value_count = value_count};
}

void StateDecoder::forget(std::uint32_t sender) noexcept {
  if (sender < expected_.size()) expected_[sender] = {};
}

Decode StateDecoder::decode(std::span<const std::uint8_t> datagram, core::StatePacket& out,
                            Kind kind) noexcept {
  const Decode answer = examine(datagram, out, kind);
  counts_.add(answer);
  return answer;
}

Decode StateDecoder::examine(std::span<const std::uint8_t> datagram, core::StatePacket& out,
                             Kind kind) noexcept {
  Prefix prefix;
  switch (read_prefix(datagram, prefix)) {
    case PrefixFault::kWrongMagic:
      return Decode::kWrongMagic;
    case PrefixFault::kMalformed:
      return Decode::kMalformed;
    case PrefixFault::kNone:
      break;
  }
  if (prefix.version != kProtocolVersion) return Decode::kWrongVersion;
  if (prefix.kind != kind) return Decode::kMalformed;

  wire::State& m = message_->state;
  if (!m.ParseFromArray(datagram.data() + kPrefixBytes,
                        static_cast<int>(datagram.size() - kPrefixBytes)))
    return Decode::kMalformed;

  if (m.sender() >= expected_.size() || !expected_[m.sender()].known) return Decode::kUnknownSender;
  const Expected& expected = expected_[m.sender()];
  if (m.session() != expected.session) return Decode::kWrongSession;
  const int count = m.values_size();
  if (count != expected.value_count || count > core::kMaxPacketValues) return Decode::kWrongCount;

  const double energies[2] = {m.energy_in(), m.energy_out()};
  const Decode values = check(m.values().data(), count, max_magnitude_);
  const Decode energy = check(energies, 2, limits::kMaxEnergy);
  if (values == Decode::kNotFinite || energy == Decode::kNotFinite) return Decode::kNotFinite;
  if (values != Decode::kOk || energy != Decode::kOk) return Decode::kOutOfRange;
  if (m.sequence() == 0 || m.sequence() > limits::kMaxSequence || !stamp_in_range(m.slot()) ||
      !stamp_in_range(m.send_ns()) || !stamp_in_range(m.echo_ns()) ||
      !stamp_in_range(m.echo_hold_ns()))
    return Decode::kOutOfRange;

  out.sender = m.sender();
  out.sequence = m.sequence();
  out.slot = m.slot();
  out.send_ns = m.send_ns();
  out.echo_ns = m.echo_ns();
  out.echo_hold_ns = m.echo_hold_ns();
  out.contact_bits = m.contact_bits();
  out.energy_in = m.energy_in();
  out.energy_out = m.energy_out();
  out.value_count = count;
  std::memcpy(out.values.data(), m.values().data(),
              static_cast<std::size_t>(count) * sizeof(double));
  return Decode::kOk;
}

}  // namespace tandem::net
