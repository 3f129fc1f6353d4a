#pragma once

namespace tandem::core {

/// Motion of a hand or an object on one axis.
struct AxisState {
  double p = 0.0;  ///< position [m]
  double v = 0.0;  ///< velocity [m/s]
};

}  // namespace tandem::core
