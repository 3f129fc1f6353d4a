#pragma once

#include <string>

#include "view/renderer.h"

namespace tandem::view {

/// Throws std::runtime_error with the file and the reason.
void write_png(const std::string& file, const Image& image);
[[nodiscard]] Image read_png(const std::string& file);

}  // namespace tandem::view
