#pragma once

#include <string>

#include "devices/column_mapping.h"
#include "devices/recorded_path.h"

namespace tandem::devices {

/// Reads a path from .csv, .csv.gz (columns as mapped) or a Tandem recording (.h5; finger
/// `mapping.finger`, time from the slots; x, y, z need no mapping). Throws std::runtime_error with
/// the file, where in it, and what is allowed.
[[nodiscard]] RecordedPath load_recorded_path(const std::string& file,
                                              const ColumnMapping& mapping);

/// The same for one text: "FILE" or "FILE?MAPPING" (column_mapping.h), as in a scene's `file`.
struct RecordedSource {
  std::string file;
  ColumnMapping mapping;
};
[[nodiscard]] RecordedSource parse_recorded_source(const std::string& text);

}  // namespace tandem::devices
