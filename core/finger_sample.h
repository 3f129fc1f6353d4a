#pragma once

#include <array>

#include "core/scene.h"

namespace tandem::core {

/// What the force loop reads of one finger's device.
template <typename V>
struct FingerSample {
  V p{0.0};  ///< position [m]
  V v{0.0};  ///< velocity [m/s]; zero where the device measures none
};

/// All fingers of one user; entries beyond the user's finger count are unused.
template <typename V>
using HandSample = std::array<FingerSample<V>, kMaxFingers>;

}  // namespace tandem::core
