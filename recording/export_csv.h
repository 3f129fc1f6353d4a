#pragma once

#include <iosfwd>

#include "recording/recording_reader.h"

namespace tandem::recording {

/// Writes the ticks as comma-separated values: one heading line (hand_position[0][1] is finger 0,
/// coordinate y), one line a tick, numbers in the shortest form that reads back to the same bits.
void export_ticks_csv(RecordingReader& recording, std::ostream& to);
/// The same for the packets.
void export_packets_csv(RecordingReader& recording, std::ostream& to);

}  // namespace tandem::recording
