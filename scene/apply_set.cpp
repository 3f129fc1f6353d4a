#include "scene/apply_set.h"

#include <charconv>
#include <system_error>
#include <vector>

#include <google/protobuf/descriptor.h>
#include <google/protobuf/message.h>

#include "scene/nearest_name.h"
#include "scene/scene_error.h"

namespace tandem::scene {
namespace {

using google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;
using google::protobuf::Message;

class Edit {
 public:
  explicit Edit(std::string_view assignment) : assignment_(assignment) {
    const auto equals = assignment.find('=');
    if (equals == std::string_view::npos || equals == 0)
      fail("expected PATH=VALUE, for example coupler.k11.stiffness=800");
    path_ = assignment.substr(0, equals);
    value_ = assignment.substr(equals + 1);
    for (std::string_view rest = path_;;) {
      const auto dot = rest.find('.');
      steps_.emplace_back(rest.substr(0, dot));
      if (dot == std::string_view::npos) break;
      rest.remove_prefix(dot + 1);
    }
  }

  std::string apply(Message& root) {
    Message* message = &root;
    for (std::size_t i = 0; i < steps_.size(); ++i) {
      const FieldDescriptor* field = field_named(*message, steps_[i]);
      const bool last = i + 1 == steps_.size();
      if (field->is_repeated()) {
        message = entry_named(*message, field, last ? "" : steps_[++i]);
        if (i + 1 == steps_.size())
          fail("'" + path_ + "' is a whole " + field->name() +
               "; name one of its fields: " + joined(field_names(message->GetDescriptor())));
      } else if (field->cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE) {
        if (last && value_ == "none") {
          message->GetReflection()->ClearField(message, field);
          return path_;
        }
        if (last)
          fail("'" + path_ + "' has fields of its own: " +
               joined(field_names(field->message_type())) + "; or give none to take it away");
        message = message->GetReflection()->MutableMessage(message, field);
      } else {
        if (!last) fail("'" + steps_[i] + "' is a single value, nothing can follow it");
        assign(*message, field);
      }
    }
    return path_;
  }

 private:
  [[noreturn]] void fail(const std::string& text) const {
    throw SceneError({{path_, text, "--set " + assignment_}});
  }

  static std::vector<std::string> field_names(const Descriptor* d) {
    std::vector<std::string> names;
    for (int i = 0; i < d->field_count(); ++i) names.push_back(d->field(i)->name());
    return names;
  }

  static std::string joined(const std::vector<std::string>& names) {
    std::string text;
    for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
    return text;
  }

  const FieldDescriptor* field_named(const Message& message, const std::string& name) const {
    const Descriptor* d = message.GetDescriptor();
    if (const FieldDescriptor* field = d->FindFieldByName(name)) return field;
    fail("unknown field '" + name + "' in " + d->name() + suggestion(name, field_names(d)));
  }

  Message* entry_named(Message& message, const FieldDescriptor* field,
                       const std::string& key) const {
    const auto* reflection = message.GetReflection();
    const int count = reflection->FieldSize(message, field);
    const FieldDescriptor* name = field->message_type()->FindFieldByName("name");
    std::vector<std::string> known;
    for (int i = 0; i < count; ++i) {
      Message* entry = reflection->MutableRepeatedMessage(&message, field, i);
      known.push_back(name != nullptr ? entry->GetReflection()->GetString(*entry, name)
                                      : std::to_string(i));
      if (!key.empty() && known.back() == key) return entry;
    }
    if (known.empty()) fail("the scene has no " + field->name() + " to edit");
    if (key.empty()) fail("'" + field->name() + "' is a list; say which" + suggestion(key, known));
    fail("no " + field->name() + " is named '" + key + "'" + suggestion(key, known));
  }

  template <typename Number>
  Number number(const char* kind) const {
    Number out{};
    const char* const end = value_.data() + value_.size();
    const auto [stop, error] = std::from_chars(value_.data(), end, out);
    if (error != std::errc{} || stop != end) fail(path_ + ": '" + value_ + "' is not " + kind);
    return out;
  }

  bool truth() const {
    if (value_ == "true" || value_ == "1") return true;
    if (value_ == "false" || value_ == "0") return false;
    fail(path_ + ": '" + value_ + "' is neither true nor false");
  }

  int enum_number(const FieldDescriptor* field) const {
    std::vector<std::string> known;
    for (int i = 0; i < field->enum_type()->value_count(); ++i) {
      known.push_back(field->enum_type()->value(i)->name());
      if (edit_distance(known.back(), value_) == 0) return field->enum_type()->value(i)->number();
    }
    fail(path_ + ": unknown value '" + value_ + "'" + suggestion(value_, known));
  }

  void assign(Message& message, const FieldDescriptor* field) const {
    const auto* reflection = message.GetReflection();
    switch (field->cpp_type()) {
      case FieldDescriptor::CPPTYPE_DOUBLE:
        return reflection->SetDouble(&message, field, number<double>("a number"));
      case FieldDescriptor::CPPTYPE_INT32:
        return reflection->SetInt32(&message, field, number<int>("a whole number"));
      case FieldDescriptor::CPPTYPE_BOOL:
        return reflection->SetBool(&message, field, truth());
      case FieldDescriptor::CPPTYPE_ENUM:
        return reflection->SetEnumValue(&message, field, enum_number(field));
      case FieldDescriptor::CPPTYPE_STRING:
        return reflection->SetString(&message, field, value_);
      default:
        fail("'" + path_ + "' is of a kind that --set does not know");
    }
  }

  std::string assignment_, path_, value_;
  std::vector<std::string> steps_;
};

}  // namespace

std::string apply_set(Message& message, std::string_view assignment) {
  return Edit(assignment).apply(message);
}

}  // namespace tandem::scene
