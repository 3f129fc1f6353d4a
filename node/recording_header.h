#pragma once

#include <cstdint>

#include "node/node_report.h"
#include "node/session_setup.h"

namespace tandem::node {

[[nodiscard]] recording::RecordingHeader recording_header(const SessionSetup& setup,
                                                          std::int64_t start_ns);
/// Says on stderr what real-time setting was asked for and not granted, and what the wait costs.
void tell_realtime(const SessionSetup& setup, const NodeReport& report);

}  // namespace tandem::node
