#include "harness/sweep_file.h"

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>

#include <fmt/format.h>
#include <google/protobuf/descriptor.h>
#include <google/protobuf/io/tokenizer.h>
#include <google/protobuf/text_format.h>

#include "harness/sweep.h"
#include "harness/sweep.pb.h"
#include "scene/nearest_name.h"

namespace tandem::harness {

namespace fs = std::filesystem;

namespace {

constexpr const char* kExtension = ".sweep";
constexpr std::uintmax_t kMostBytes = 1 << 20;

/// Text between the n-th pair of double quotes.
std::string quoted(std::string text, int n) {
  for (;; --n) {
    const std::size_t from = text.find('"');
    const std::size_t to = from == std::string::npos ? from : text.find('"', from + 1);
    if (to == std::string::npos) return {};
    if (n == 0) return text.substr(from + 1, to - from - 1);
    text = text.substr(to + 1);
  }
}

std::string said_better(const std::string& message) {
  const auto* pool = wire::Sweep::descriptor()->file()->pool();
  if (message.find("has no field named") != std::string::npos) {
    const std::string type = quoted(message, 0), field = quoted(message, 1);
    const auto* d = pool->FindMessageTypeByName(type);
    std::vector<std::string> known;
    for (int i = 0; d != nullptr && i < d->field_count(); ++i) known.push_back(d->field(i)->name());
    return "unknown field '" + field + "' in " + type.substr(type.rfind('.') + 1) +
           scene::suggestion(field, known);
  }
  if (message.find("Unknown enumeration value") != std::string::npos) {
    const std::string value = quoted(message, 0), field = quoted(message, 1);
    const auto* e =
        pool->FindEnumTypeByName(field == "style" ? "tandem.harness.wire.Style"
                                                  : "tandem.harness.wire.Condition.Distribution");
    std::vector<std::string> known;
    for (int i = 0; e != nullptr && i < e->value_count(); ++i) known.push_back(e->value(i)->name());
    return "unknown value '" + value + "' of " + field + scene::suggestion(value, known);
  }
  return message;
}

class Problems : public google::protobuf::io::ErrorCollector {
 public:
  explicit Problems(std::string origin) : origin_(std::move(origin)) {}
  void AddError(int line, int column, const std::string& message) override {
    if (!text_.empty()) text_ += '\n';
    text_ += fmt::format("{}:{}:{}: {}", origin_, line + 1, column + 1, said_better(message));
  }
  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  std::string origin_, text_;
};

}  // namespace

std::vector<std::string> sweep_folders() {
  std::vector<std::string> folders;
  if (const char* list = std::getenv("TANDEM_SWEEPS")) {
    std::istringstream parts(list);
    for (std::string part; std::getline(parts, part, ':');)
      if (!part.empty()) folders.push_back(part);
  }
  folders.emplace_back(TANDEM_SOURCE_SWEEPS);
  folders.emplace_back(TANDEM_INSTALLED_SWEEPS);
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  if (!error)
    folders.push_back((program.parent_path().parent_path() / "share/tandem/sweeps").string());
  return folders;
}

std::string read_sweep_file(const std::string& name_or_file, std::string& file) {
  std::error_code error;
  file.clear();
  if (name_or_file.find_first_of("/.") != std::string::npos) {
    file = name_or_file;
  } else {
    for (const std::string& folder : sweep_folders()) {
      const fs::path candidate = fs::path(folder) / (name_or_file + kExtension);
      if (fs::is_regular_file(candidate, error)) {
        file = candidate.string();
        break;
      }
    }
    if (file.empty())
      throw SweepError("there is no sweep '" + name_or_file + "'" +
                       scene::suggestion(name_or_file, built_in_sweeps()) +
                       "; a file is given with its folder: ./" + name_or_file);
  }
  if (fs::is_directory(file, error))
    throw SweepError(file + ": is a folder; give a sweep file in it");
  errno = 0;
  std::ifstream in(file, std::ios::binary);
  if (!in)
    throw SweepError(file + ": cannot be read: " + std::strerror(errno) +
                     scene::suggestion(name_or_file, built_in_sweeps()));
  if (fs::file_size(file, error) > kMostBytes && !error)
    throw SweepError(file + ": larger than 1 MiB; this is no sweep file");
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

void parse_sweep(const std::string& text, const std::string& origin, wire::Sweep& sweep) {
  google::protobuf::TextFormat::Parser parser;
  Problems problems(origin);
  parser.RecordErrorsTo(&problems);
  if (!parser.ParseFromString(text, &sweep) || !problems.text().empty())
    throw SweepError(problems.text().empty() ? origin + ": is no sweep" : problems.text());
}

}  // namespace tandem::harness
