#pragma once

#include <algorithm>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include <google/protobuf/message.h>

#include "scene/scene_error.h"
#include "scene/scene_fields.h"

/// Between a core::Scene and its protobuf message, by the list in scene_fields.h. A field that the
/// message does not set keeps the default of core/scene.h: defaults are written once, there.
namespace tandem::scene {

[[nodiscard]] inline const google::protobuf::FieldDescriptor* descriptor_of(
    const google::protobuf::Message& message, const Field& field) {
  return message.GetDescriptor()->FindFieldByName(std::string(field.name));
}

/// Message to scene. Set fields that are never visited are not part of such a scene: a problem.
class MessageReader {
 public:
  MessageReader(const google::protobuf::Message& message, std::string path, std::string_view where,
                std::vector<Problem>& problems)
      : message_(message), path_(std::move(path)), where_(where), problems_(problems) {}

  void where(std::string_view words) { where_ = words; }

  template <typename T>
  void value(const Field& field, T& value) {
    const auto* d = visit(field);
    const auto* reflection = message_.GetReflection();
    if (!reflection->HasField(message_, d)) return;
    if constexpr (std::is_enum_v<T>) {
      const int number = reflection->GetEnumValue(message_, d);
      if (d->enum_type()->FindValueByNumber(number) == nullptr)
        refuse(*d, number);
      else
        value = static_cast<T>(number);
    } else if constexpr (std::is_same_v<T, double>)
      value = reflection->GetDouble(message_, d);
    else if constexpr (std::is_same_v<T, int>)
      value = reflection->GetInt32(message_, d);
    else if constexpr (std::is_same_v<T, bool>)
      value = reflection->GetBool(message_, d);
    else
      value = reflection->GetString(message_, d);
  }

  template <typename Fn>
  void group(const Field& field, Fn&& fn) {
    const auto* d = visit(field);
    if (message_.GetReflection()->HasField(message_, d))
      descend(message_.GetReflection()->GetMessage(message_, d), std::string(field.name), fn);
  }

  template <typename T, typename Fn>
  void optional_group(const Field& field, std::optional<T>& part, Fn&& fn) {
    if (message_.GetReflection()->HasField(message_, descriptor_of(message_, field)))
      part.emplace();
    group(field, [&](auto& sub) { fn(*part, sub); });
  }

  template <typename T, typename Fn>
  void list(const Field& field, std::vector<T>& entries, int /*max*/, Fn&& fn) {
    const auto* d = visit(field);
    const auto* reflection = message_.GetReflection();
    const int count = reflection->FieldSize(message_, d);
    for (int i = 0; i < count; ++i) {
      const auto& entry = reflection->GetRepeatedMessage(message_, d, i);
      std::string key = std::to_string(i);
      if (const auto* name = entry.GetDescriptor()->FindFieldByName("name"))
        if (const std::string& given = entry.GetReflection()->GetString(entry, name);
            !given.empty())
          key = given;
      descend(entry, std::string(field.name) + "." + key,
              [&](auto& sub) { fn(entries.emplace_back(), sub); });
    }
  }

  /// Reports what is set and was not visited.
  void finish() const {
    std::vector<const google::protobuf::FieldDescriptor*> set;
    message_.GetReflection()->ListFields(message_, &set);
    for (const auto* d : set) {
      if (std::find(visited_.begin(), visited_.end(), d->name()) != visited_.end()) continue;
      std::string text = path_ + d->name() + ": not part of " + std::string(where_) + "; it has";
      for (std::size_t i = 0; i < visited_.size(); ++i) text += (i > 0 ? ", " : " ") + visited_[i];
      problems_.push_back({path_ + d->name(), std::move(text), {}});
    }
  }

 private:
  /// Text format takes any number for an enum; a law knows only those with a name.
  void refuse(const google::protobuf::FieldDescriptor& d, int number) {
    std::string names;
    for (int i = 0; i < d.enum_type()->value_count(); ++i)
      names += (i == 0 ? "" : ", ") + d.enum_type()->value(i)->name();
    problems_.push_back({path_ + d.name(),
                         path_ + d.name() + " = " + std::to_string(number) +
                             ": there is no such value; write one of " + names,
                         {}});
  }
  const google::protobuf::FieldDescriptor* visit(const Field& field) {
    visited_.emplace_back(field.name);
    return descriptor_of(message_, field);
  }

  template <typename Fn>
  void descend(const google::protobuf::Message& part, const std::string& step, Fn&& fn) {
    MessageReader sub(part, path_ + step + ".", where_, problems_);
    fn(sub);
    sub.finish();
  }

  const google::protobuf::Message& message_;
  std::string path_;
  std::string_view where_;
  std::vector<std::string> visited_;
  std::vector<Problem>& problems_;
};

/// Scene to message: every field that the scene's space has, except empty strings.
class MessageWriter {
 public:
  explicit MessageWriter(google::protobuf::Message& message) : message_(message) {}

  void where(std::string_view) {}

  template <typename T>
  void value(const Field& field, T& value) {
    const auto* d = descriptor_of(message_, field);
    const auto* reflection = message_.GetReflection();
    if constexpr (std::is_enum_v<T>)
      reflection->SetEnumValue(&message_, d, static_cast<int>(value));
    else if constexpr (std::is_same_v<T, double>)
      reflection->SetDouble(&message_, d, value);
    else if constexpr (std::is_same_v<T, int>)
      reflection->SetInt32(&message_, d, value);
    else if constexpr (std::is_same_v<T, bool>)
      reflection->SetBool(&message_, d, value);
    else if (!value.empty())
      reflection->SetString(&message_, d, value);
  }

  template <typename Fn>
  void group(const Field& field, Fn&& fn) {
    MessageWriter sub(
        *message_.GetReflection()->MutableMessage(&message_, descriptor_of(message_, field)));
    fn(sub);
  }

  template <typename T, typename Fn>
  void optional_group(const Field& field, std::optional<T>& part, Fn&& fn) {
    if (part) group(field, [&](auto& sub) { fn(*part, sub); });
  }

  template <typename T, typename Fn>
  void list(const Field& field, std::vector<T>& entries, int /*max*/, Fn&& fn) {
    for (T& entry : entries) {
      MessageWriter sub(
          *message_.GetReflection()->AddMessage(&message_, descriptor_of(message_, field)));
      fn(entry, sub);
    }
  }

 private:
  google::protobuf::Message& message_;
};

}  // namespace tandem::scene
