#include "scene/scene_text.h"

#include <algorithm>
#include <set>
#include <string_view>

#include <google/protobuf/descriptor.h>
#include <google/protobuf/io/tokenizer.h>
#include <google/protobuf/text_format.h>

#include "scene/message_visitors.h"
#include "scene/nearest_name.h"
#include "scene/scene.pb.h"

namespace tandem::scene {
namespace {

using google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::TextFormat;

/// Text between the n-th pair of double quotes of a message of protobuf.
std::string quoted(std::string_view text, int n) {
  for (; n > 0; --n)
    for (int quote = 0; quote < 2; ++quote) {
      const auto at = text.find('"');
      if (at == std::string_view::npos) return {};
      text.remove_prefix(at + 1);
    }
  const auto from = text.find('"');
  if (from == std::string_view::npos) return {};
  text.remove_prefix(from + 1);
  return std::string(text.substr(0, text.find('"')));
}

/// Values of every enum field with this name, anywhere in the schema.
std::vector<std::string> enum_values(const std::string& field_name) {
  std::set<std::string> values;
  const auto* file = wire::Scene::descriptor()->file();
  for (int m = 0; m < file->message_type_count(); ++m) {
    const FieldDescriptor* field = file->message_type(m)->FindFieldByName(field_name);
    if (field == nullptr || field->enum_type() == nullptr) continue;
    for (int i = 0; i < field->enum_type()->value_count(); ++i)
      values.insert(field->enum_type()->value(i)->name());
  }
  return {values.begin(), values.end()};
}

/// Protobuf's words in ours, with what was probably meant.
std::string said_better(const std::string& message) {
  if (message.find("has no field named") != std::string::npos) {
    const std::string type = quoted(message, 0), field = quoted(message, 1);
    const Descriptor* d = wire::Scene::descriptor()->file()->pool()->FindMessageTypeByName(type);
    std::vector<std::string> known;
    for (int i = 0; d != nullptr && i < d->field_count(); ++i) known.push_back(d->field(i)->name());
    return "unknown field '" + field + "' in " + type.substr(type.rfind('.') + 1) +
           suggestion(field, known);
  }
  if (message.find("Unknown enumeration value") != std::string::npos) {
    const std::string value = quoted(message, 0), field = quoted(message, 1);
    return "unknown value '" + value + "' of " + field + suggestion(value, enum_values(field));
  }
  if (message.ends_with("got: ")) return "the file ends inside a part: a } is missing";
  return "syntax: " + message;
}

/// Protobuf says where the parser stood, which is past the word it complains of: goes back to it.
struct Place {
  int line = 0, column = 0;  ///< from 0
};

Place place_of(const std::string& word, const std::string& text, Place stood) {
  std::size_t start = 0;
  for (int i = 0; i < stood.line && start != std::string::npos; ++i) {
    start = text.find('\n', start);
    if (start != std::string::npos) ++start;
  }
  if (start == std::string::npos || word.empty()) return stood;
  const std::size_t at = text.rfind(word, start + static_cast<std::size_t>(stood.column));
  if (at == std::string::npos) return stood;
  const std::size_t line_start = at == 0 ? 0 : text.rfind('\n', at - 1) + 1;  // npos + 1 is 0
  return {static_cast<int>(std::count(text.begin(), text.begin() + static_cast<long>(at), '\n')),
          static_cast<int>(at - line_start)};
}

class Collector : public google::protobuf::io::ErrorCollector {
 public:
  Collector(const std::string& text, const std::string& origin, std::vector<Problem>& problems)
      : text_(text), origin_(origin), problems_(problems) {}

  void AddError(int line, int column, const std::string& message) override {
    std::string where = origin_;
    if (line >= 0) {
      Place place{line, column};
      if (message.find("has no field named") != std::string::npos)
        place = place_of(quoted(message, 1), text_, place);
      else if (message.find("Unknown enumeration value") != std::string::npos)
        place = place_of(quoted(message, 0), text_, place);
      where += ":" + std::to_string(place.line + 1) + ":" + std::to_string(place.column + 1);
    }
    if (problems_.size() < kMaxProblems) problems_.push_back({{}, said_better(message), where});
  }
  /// Unknown fields come as warnings, so that the parser goes on and finds all of them.
  void AddWarning(int line, int column, const std::string& message) override {
    AddError(line, column, message);
  }

 private:
  static constexpr std::size_t kMaxProblems = 100;  ///< a file of another kind has thousands

  const std::string& text_;
  const std::string& origin_;
  std::vector<Problem>& problems_;
};

std::string key_of(const Message& entry, int index) {
  if (const auto* name = entry.GetDescriptor()->FindFieldByName("name"))
    if (std::string given = entry.GetReflection()->GetString(entry, name); !given.empty())
      return given;
  return std::to_string(index);
}

void find_lines(const Message& message, const TextFormat::ParseInfoTree& tree,
                const std::string& path, LineOfPath& lines) {
  std::vector<const FieldDescriptor*> set;
  const auto* reflection = message.GetReflection();
  reflection->ListFields(message, &set);
  for (const FieldDescriptor* d : set) {
    const int count = d->is_repeated() ? reflection->FieldSize(message, d) : 1;
    for (int i = 0; i < count; ++i) {
      const int index = d->is_repeated() ? i : -1;
      std::string here = path + d->name();
      const Message* part = nullptr;
      if (d->cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE) {
        part = d->is_repeated() ? &reflection->GetRepeatedMessage(message, d, i)
                                : &reflection->GetMessage(message, d);
        if (d->is_repeated()) here += "." + key_of(*part, i);
      }
      const int line = tree.GetLocation(d, index).line;
      if (line >= 0) lines[here] = line + 1;
      const auto* nested = part != nullptr ? tree.GetTreeForNested(d, index) : nullptr;
      if (nested != nullptr) find_lines(*part, *nested, here + ".", lines);
    }
  }
}

}  // namespace

bool parse_scene_text(const std::string& text, const std::string& origin, Message& message,
                      LineOfPath& lines, std::vector<Problem>& problems) {
  Collector collector(text, origin, problems);
  TextFormat::ParseInfoTree tree;
  TextFormat::Parser parser;
  parser.RecordErrorsTo(&collector);
  parser.AllowUnknownField(true);
  parser.SetRecursionLimit(16);  // the schema is 4 deep; text may come from the network
  parser.WriteLocationsTo(&tree);
  if (!parser.ParseFromString(text, &message)) return false;
  find_lines(message, tree, "", lines);
  return true;
}

std::string to_text(const core::Scene& scene) {
  core::Scene copy = scene;  // the list of fields is written for readers, too
  wire::Scene message;
  MessageWriter writer(message);
  visit_scene(copy, writer);
  TextFormat::Printer printer;
  printer.SetUseUtf8StringEscaping(true);
  std::string text;
  printer.PrintToString(message, &text);
  return text;
}

}  // namespace tandem::scene
