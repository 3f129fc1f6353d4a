#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "core/scene.h"

namespace tandem::cli {

/// The first number that a law, stepped again, gives otherwise than the node did.
struct ReplayDifference {
  std::int64_t slot = 0;
  std::string quantity;  ///< "command[0].x", "object[0][3]", "contact_bits[0]", "faults"
  std::string expected;  ///< as recorded: value and bits
  std::string got;
};

struct ReplayResult {
  std::string role, user;
  core::Scene scene;
  std::uint64_t ticks = 0, packets = 0;  ///< compared, used
  std::int64_t first_slot = 0, last_slot = 0;
  std::int64_t skipped_slots = 0;  ///< in between, that the node missed
  bool complete = false;           ///< the recording was closed in order
  std::int64_t records_lost = 0;   ///< known to be missing from it
  std::optional<ReplayDifference> difference;
};

/// Steps the law of a recording's node again from the recorded inputs and compares every output bit
/// by bit, up to the first difference. Throws recording::RecordingError, scene::SceneError,
/// std::runtime_error.
[[nodiscard]] ReplayResult replay_recording(const std::string& file);

}  // namespace tandem::cli
