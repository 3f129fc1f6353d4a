#include "cli/script_path.h"

#include <filesystem>
#include <spawn.h>
#include <sys/wait.h>

extern char** environ;

namespace tandem::cli {

namespace {

std::string find_script(const std::string& script) {
  namespace fs = std::filesystem;
  std::error_code ignored;
  const fs::path program = fs::read_symlink("/proc/self/exe", ignored);
  for (const fs::path& folder :
       {fs::path(TANDEM_SOURCE_DIR) / "scripts",
        program.parent_path().parent_path() / "share" / "tandem" / "scripts"})
    if (fs::exists(folder / script, ignored)) return (folder / script).string();
  return script;
}

}  // namespace

int run_script(const std::string& script, const std::vector<std::string>& arguments) {
  // Debian's own interpreter first: it is the one that sees Debian's packages.
  const std::string python =
      std::filesystem::exists("/usr/bin/python3") ? "/usr/bin/python3" : "python3";
  std::vector<std::string> words{python, find_script(script)};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  pid_t child = 0;
  if (posix_spawnp(&child, argv[0], nullptr, nullptr, argv.data(), environ) != 0) return -1;
  int status = 0;
  if (waitpid(child, &status, 0) != child || !WIFEXITED(status)) return -1;
  return WEXITSTATUS(status);
}

}  // namespace tandem::cli
