#pragma once

#include <string>
#include <string_view>

namespace google::protobuf {
class Message;
}

namespace tandem::scene {

/// One edit of a scene message by path, as --set gives it: "coupler.k11.stiffness=800",
/// "user.1.finger.a.position.x=0.01", "user.1.finger.a.path.0.time=2", "silence=none". Entries of a
/// list are addressed by their name, or by number counted from 0 where they have none; parts that
/// do not exist yet are made, list entries are not. "none" takes away a whole part.
/// Returns the path. Throws SceneError: unknown field or name (with the nearest one), bad value.
std::string apply_set(google::protobuf::Message& message, std::string_view assignment);

}  // namespace tandem::scene
