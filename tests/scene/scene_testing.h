#pragma once

#include <cstdlib>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

#include <google/protobuf/text_format.h>

#include "scene/load_scene.h"
#include "scene/scene.pb.h"

namespace tandem::scene::testing {

/// Message of what load_scene_text throws; "" if it does not.
inline std::string error_of(const std::string& text, const std::vector<std::string>& sets = {}) {
  try {
    (void)load_scene_text(text, "t.scene", sets);
    return {};
  } catch (const SceneError& error) {
    return error.what();
  }
}

/// The same of a scene by name or file.
inline std::string error_of_named(const std::string& name, const std::vector<std::string>& sets) {
  try {
    (void)load_scene(name, sets);
    return {};
  } catch (const SceneError& error) {
    return error.what();
  }
}

inline bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

/// A scene in which every field of its space is set, except those that exclude each other.
inline wire::Scene message_of(const core::Scene& scene) {
  wire::Scene message;
  google::protobuf::TextFormat::ParseFromString(to_text(scene), &message);
  return message;
}

inline std::string text_of(const google::protobuf::Message& message) {
  std::string text;
  google::protobuf::TextFormat::PrintToString(message, &text);
  return text;
}

using Leaf =
    std::function<void(google::protobuf::Message& parent,
                       const google::protobuf::FieldDescriptor* field, const std::string& path)>;

/// Calls `leaf` for every set single value, with its path as --set writes it.
inline void for_each_leaf(google::protobuf::Message& message, const std::string& path,
                          const Leaf& leaf) {
  std::vector<const google::protobuf::FieldDescriptor*> set;
  const auto* reflection = message.GetReflection();
  reflection->ListFields(message, &set);
  for (const auto* field : set) {
    const std::string here = path + field->name();
    if (field->cpp_type() != google::protobuf::FieldDescriptor::CPPTYPE_MESSAGE) {
      leaf(message, field, here);
    } else if (!field->is_repeated()) {
      for_each_leaf(*reflection->MutableMessage(&message, field), here + ".", leaf);
    } else {
      for (int i = 0; i < reflection->FieldSize(message, field); ++i) {
        auto* entry = reflection->MutableRepeatedMessage(&message, field, i);
        const auto* name = entry->GetDescriptor()->FindFieldByName("name");
        const std::string key =
            name != nullptr ? entry->GetReflection()->GetString(*entry, name) : std::to_string(i);
        for_each_leaf(*entry, here + "." + key + ".", leaf);
      }
    }
  }
}

/// Scenes that together set every field of the schema.
inline std::vector<core::Scene> scenes_with_every_field() {
  core::Scene plane = load_scene("box_distributed"), space = load_scene("space_box"),
              axis = load_scene("wall_single");
  auto& finger = plane.users[0].fingers[0];
  finger.intent.force_sines.push_back({0.0, 5.0, 1.5, 3.0, {0.0, 1.0, 0.0}, true});
  finger.intent.force = {0.1, 0.2, 0.0};
  plane.devices[0].kind = core::DeviceKind::kRecorded;
  plane.devices[0].file = "hand.csv";
  axis.objects.push_back({.name = "box", .position = {-0.1, 0.0, 0.0}});
  axis.couplers.push_back({"k", "box", "1", "", {}, {}, {}});
  return {plane, space, axis};
}

}  // namespace tandem::scene::testing
