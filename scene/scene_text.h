#pragma once

#include <map>
#include <string>
#include <vector>

#include "core/scene.h"
#include "scene/scene_error.h"

namespace google::protobuf {
class Message;
}

namespace tandem::scene {

/// Canonical text of a scene: every field that its space has, defaults written out, doubles in
/// digits that read back to the same bits. load_scene_text(to_text(s)) is s again; this is what a
/// joiner is sent.
[[nodiscard]] std::string to_text(const core::Scene& scene);

/// Line of each field and part by its path (coupler.k11.stiffness), counted from 1.
using LineOfPath = std::map<std::string, int>;

/// Reads protobuf text into `message`. Syntax errors stop it, unknown fields are skipped and
/// reported: all problems are added, with FILE:LINE:COLUMN and the nearest known name.
/// False: syntax error, the message is not whole.
bool parse_scene_text(const std::string& text, const std::string& origin,
                      google::protobuf::Message& message, LineOfPath& lines,
                      std::vector<Problem>& problems);

}  // namespace tandem::scene
