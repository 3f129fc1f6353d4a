#include "recording/record_columns.h"

#include <stdexcept>

namespace tandem::recording {
namespace {

void within(const char* field, int value, int lowest, int highest) {
  if (value >= lowest && value <= highest) return;
  throw std::invalid_argument(std::string("recording: ") + field + " is " + std::to_string(value) +
                              ", must be within [" + std::to_string(lowest) + ", " +
                              std::to_string(highest) + "]");
}

}  // namespace

void check(const RecordColumns& columns) {
  within("fingers", columns.fingers, 0, core::kMaxFingers);
  within("hand_values", columns.hand_values, 0, 3);
  within("users", columns.users, 0, core::kMaxUsers);
  within("objects", columns.objects, 0, core::kMaxObjects);
  within("object_values", columns.object_values, 0, core::kMaxObjectValues);
  within("packet_values", columns.packet_values, 0, core::kMaxPacketValues);
}

}  // namespace tandem::recording
