#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>

#include "devices/recorded_path.h"

namespace tandem::devices {

/// value = number in the file * scale + offset
struct MappedColumn {
  std::string column;   ///< its name, or "#3" for the third; empty: not there
  double scale = 1.0;   ///< unit, lever arm and factor together [m or s per unit of the file]
  double offset = 0.0;  ///< [m] or [s]
};

enum class RecordedMode {
  kAutomatic,  ///< driving where the finger has a hand spring, else kinematic
  kKinematic,  ///< the position is the recording's; force does not move it
  kDriving,    ///< a simulated hand's spring follows the recording
};

/// How to make a path out of a recording's columns.
struct ColumnMapping {
  MappedColumn time;                     ///< empty: rate_hz holds
  double rate_hz = 0.0;                  ///< of the rows, when they carry no time stamps
  std::array<MappedColumn, 3> position;  ///< x, y, z; without: 0
  int finger = 0;                        ///< of a Tandem recording, from 0
  bool from_first = false;               ///< origin=first: displacement from the first sample
  double start = 0.0;                    ///< leave out what is before [s from the first row]
  double stop = 1e30;                    ///< and after [s from the first row]
  Interpolation interpolation = Interpolation::kCubic;
  PathEnd end = PathEnd::kHold;
  double seam = 0.25;  ///< of a loop [s]
  RecordedMode mode = RecordedMode::kAutomatic;
};

/// Reads comma-separated KEY=VALUE, for example
///   time=t_s,x=x_master_rad:rad@0.075,end=loop
///   rate_hz=700,x=px,y=py*-1+0.02,z=#3:mm,origin=first
/// x, y, z: COLUMN[:UNIT][*FACTOR][+OFFSET], UNIT m, mm, cm, or rad@ARM, deg@ARM with the lever arm
/// in metres; OFFSET [m]. time: COLUMN[:UNIT], UNIT s, ms, us, ns. Further keys: rate_hz, finger,
/// start, stop, seam, origin (zero|first), interpolation (cubic|linear), end (hold|loop),
/// mode (kinematic|driving). Throws std::invalid_argument with the key, the value and what is
/// allowed.
[[nodiscard]] ColumnMapping parse_column_mapping(std::string_view text);

}  // namespace tandem::devices
