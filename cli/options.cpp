#include "cli/options.h"

#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <limits>
#include <unistd.h>

#include <fmt/format.h>

#include "cli/commands.h"
#include "scene/load_scene.h"

namespace tandem::cli {

void SceneOption::add(CLI::App& command, const std::string& default_scene) {
  scene = default_scene;
  auto* option =
      command.add_option("--scene", scene, "scene: a name (`tandem scene list`) or a file");
  if (default_scene.empty())
    option->required();
  else
    option->capture_default_str();
  command
      .add_option("--set", sets,
                  "change one field, PATH=VALUE; entries go by name: coupler.k11.stiffness=800")
      ->take_all()
      ->allow_extra_args(false);
}

core::Scene SceneOption::load() const { return scene::load_scene(scene, sets); }

void JsonOption::add(CLI::App& command) {
  command.add_option("--json", file, "also write the results as one JSON object; - is stdout")
      ->check(writable_file, "", "writable");
}

void JsonOption::write(const nlohmann::ordered_json& object) const {
  if (!wanted()) return;
  const std::string text = object.dump(2) + "\n";
  if (to_stdout()) {
    std::fwrite(text.data(), 1, text.size(), stdout);
    std::fflush(stdout);
  } else {
    write_text(file, text);
  }
}

nlohmann::ordered_json number(double value) {
  if (!std::isfinite(value)) return nullptr;
  return value;
}

std::string not_negative(const std::string& number) {
  double value = 0.0;
  if (CLI::detail::lexical_cast(number, value) && std::isfinite(value) && value >= 0.0) return {};
  return number + " is no number of at least 0";
}

std::string seed_number(const std::string& text) {
  std::uint64_t seed = 0;
  const char* end = text.data() + text.size();
  const auto read = std::from_chars(text.data(), end, seed);
  if (read.ec == std::errc() && read.ptr == end) return {};
  return fmt::format("{} is no seed; allowed: whole numbers from 0 to {}", text,
                     std::numeric_limits<std::uint64_t>::max());
}

std::string writable_file(const std::string& file) {
  const std::filesystem::path path(file);
  const std::string folder = path.has_parent_path() ? path.parent_path().string() : ".";
  std::error_code ignored;
  if (file == "-") return {};
  if (file.empty()) return "a file's name is needed";
  if (!std::filesystem::exists(folder, ignored))
    return "cannot write " + file + ": there is no folder " + folder + "; make it first";
  if (std::filesystem::is_directory(path, ignored)) return "cannot write " + file + ": a folder";
  const bool there = std::filesystem::exists(path, ignored);
  if (access(there ? file.c_str() : folder.c_str(), W_OK) != 0)
    return "cannot write " + file + ": " + std::strerror(errno);
  return {};
}

void write_text(const std::string& file, const std::string& text) {
  std::FILE* out = std::fopen(file.c_str(), "wb");
  if (out == nullptr) throw Failed("cannot write " + file + ": " + std::strerror(errno));
  const bool written = std::fwrite(text.data(), 1, text.size(), out) == text.size();
  const bool closed = std::fclose(out) == 0;
  if (!written || !closed)
    throw Failed("cannot write all of " + file + ": " + std::strerror(errno));
}

}  // namespace tandem::cli
