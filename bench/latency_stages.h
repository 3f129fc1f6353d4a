#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace tandem::bench {

/// One packet on its way from a force loop to the force it causes at the peer; all stamps by one
/// monotonic clock [ns].
struct PathPacket {
  std::int64_t sampled = 0;    ///< tick of the sender in which the hand was read
  std::int64_t published = 0;  ///< handed to the link thread
  std::int64_t sent = 0;       ///< stamped by the link thread, about to be encoded and sent
  std::int64_t arrived = 0;    ///< received by the peer's link thread
  std::int64_t used = 0;       ///< tick of the peer that took it
  std::int64_t felt = 0;       ///< its force written to the device
};

/// What one direction of a session has left.
struct PathRun {
  std::vector<std::int64_t> wakes;  ///< ticks of the sender, rising
  std::vector<PathPacket> packets;  ///< those that were used, by rising `sampled`
  std::int64_t published = 0;       ///< packets there were in that time
};

/// The parts of the way from a motion to the force the other user feels.
enum class Stage { kSample, kSlot, kPublish, kLink, kWire, kApply, kForce };
inline constexpr int kStages = 7;

struct StageName {
  const char* key;
  const char* from_to;
  const char* whose;
};
inline constexpr std::array<StageName, kStages> kStageNames{{
    {"sample", "the hand moves .. a tick reads it", "rate of the force loop"},
    {"slot", ".. a tick that sends", "packet rate"},
    {"publish", ".. handed to the link thread", "Tandem"},
    {"link", ".. the link thread takes it", "Tandem"},
    {"wire", ".. encoded, sent, received", "kernel, and the codec"},
    {"apply", ".. a tick of the peer takes it", "rate of the force loop"},
    {"force", ".. its force is written", "Tandem"},
}};

/// Times [us]: of a packet for the parts that only packets have, of a motion for the rest.
struct Stages {
  std::array<std::vector<double>, kStages> us;
  std::vector<double> total;              ///< of each motion, to the force
  std::vector<double> handed_over;        ///< of each packet, published .. arrived
  std::array<double, kStages> mean_us{};  ///< over motions: they add up to mean_total_us
  double mean_total_us = 0.0;
};

/// Adds what `motions` instants, spread at random over the run, had to wait for. An instant goes
/// with the first packet that was used and had been sampled after it.
void add_run(const PathRun& run, int motions, std::uint64_t seed, Stages& stages);

}  // namespace tandem::bench
