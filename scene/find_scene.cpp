#include "scene/find_scene.h"

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>
#include <system_error>

#include "scene/nearest_name.h"
#include "scene/scene_error.h"

namespace tandem::scene {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxSceneBytes = 1 << 20;
constexpr const char* kExtension = ".scene";

[[noreturn]] void fail(const std::string& where, const std::string& text) {
  throw SceneError({{{}, text, where}});
}

}  // namespace

std::vector<std::string> scene_folders() {
  std::vector<std::string> folders;
  if (const char* list = std::getenv("TANDEM_SCENES")) {
    std::istringstream parts(list);
    for (std::string part; std::getline(parts, part, ':');)
      if (!part.empty()) folders.push_back(part);
  }
  folders.emplace_back(TANDEM_SOURCE_SCENES);
  folders.emplace_back(TANDEM_INSTALLED_SCENES);
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  if (!error)
    folders.push_back(
        (program.parent_path().parent_path() / "share" / "tandem" / "scenes").string());
  return folders;
}

std::vector<std::string> scene_names() {
  std::set<std::string> names;
  for (const std::string& folder : scene_folders()) {
    std::error_code error;
    for (fs::directory_iterator i(folder, error), end; !error && i != end; i.increment(error))
      if (i->path().extension() == kExtension) names.insert(i->path().stem().string());
  }
  return {names.begin(), names.end()};
}

std::string find_scene(const std::string& name_or_file) {
  if (name_or_file.empty()) fail("--scene", "no scene given" + suggestion("", scene_names()));
  if (name_or_file.find_first_of("/.") != std::string::npos) return name_or_file;
  std::error_code error;
  for (const std::string& folder : scene_folders()) {
    const fs::path file = fs::path(folder) / (name_or_file + kExtension);
    if (fs::is_regular_file(file, error)) return file.string();
  }
  if (fs::exists(name_or_file, error)) return name_or_file;
  std::string looked;
  for (const std::string& folder : scene_folders()) looked += (looked.empty() ? "" : ", ") + folder;
  fail("scene '" + name_or_file + "'",
       "there is no scene of this name" + suggestion(name_or_file, scene_names()) + " (looked in " +
           looked + "); a file is given with its folder: ./" + name_or_file);
}

std::string read_scene_file(const std::string& file) {
  std::error_code error;
  if (fs::is_directory(file, error))
    fail(file, "is a directory; give a scene file (" + std::string(kExtension) + ") in it");
  errno = 0;
  std::ifstream in(file, std::ios::binary);
  if (!in)
    fail(file, std::string("cannot be read: ") + std::strerror(errno) +
                   "; give a file that can, or the name of a shipped scene");
  std::string text(kMaxSceneBytes + 1, '\0');
  in.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (in.bad()) fail(file, "cannot be read to its end");
  text.resize(static_cast<std::size_t>(in.gcount()));
  if (text.size() > kMaxSceneBytes) fail(file, "is larger than 1 MiB; a scene is a few kB of text");
  return text;
}

}  // namespace tandem::scene
