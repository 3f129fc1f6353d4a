#include "bench/cyclictest.h"

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <fstream>
#include <spawn.h>
#include <sstream>
#include <sys/wait.h>
#include <unistd.h>
#include <vector>

#include <nlohmann/json.hpp>

extern char** environ;

namespace tandem::bench {
namespace {

/// An empty file that is gone when this is.
class TemporaryFile {
 public:
  TemporaryFile() : path_("/tmp/tandem-cyclictest-XXXXXX") {
    const int descriptor = mkstemp(path_.data());
    if (descriptor >= 0) close(descriptor);
  }
  ~TemporaryFile() { unlink(path_.c_str()); }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  [[nodiscard]] const std::string& path() const { return path_; }
  [[nodiscard]] std::string text() const {
    std::ostringstream all;
    all << std::ifstream(path_).rdbuf();
    return all.str();
  }

 private:
  std::string path_;
};

/// Runs a program with its output thrown away and its complaints in `complaints`. Returns its exit
/// status, or the negative error of starting it.
int run(const std::vector<std::string>& words, const std::string& complaints) {
  std::vector<char*> argv;
  for (const std::string& word : words) argv.push_back(const_cast<char*>(word.c_str()));
  argv.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, complaints.c_str(), O_WRONLY, 0);
  pid_t child = 0;
  const int error = posix_spawnp(&child, argv[0], &actions, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0) return -error;
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

core::WakeupStatistics lateness_in(const nlohmann::json& report) {
  const auto& thread = report.at("thread").at("0");
  core::WakeupStatistics lateness;
  std::int64_t in_histogram = 0;
  for (const auto& [late_ns, count] : thread.at("histogram").items()) {
    for (int i = 0; i < count.get<int>(); ++i) lateness.record(std::stoll(late_ns));
    in_histogram += count.get<int>();
  }
  // Beyond the histogram's millisecond only the greatest is known: count the others as that.
  for (std::int64_t i = in_histogram; i < thread.at("cycles").get<std::int64_t>(); ++i) {
    lateness.record(thread.at("max").get<std::int64_t>());
  }
  return lateness;
}

}  // namespace

CyclictestRun run_cyclictest(int priority, long interval_us, long wakeups) {
  const TemporaryFile report, complaints;
  const std::vector<std::string> words{"cyclictest",
                                       "--quiet",
                                       "--mlockall",
                                       "--nsecs",
                                       "--histogram=1000000",
                                       "--priority=" + std::to_string(priority),
                                       "--interval=" + std::to_string(interval_us),
                                       "--loops=" + std::to_string(wakeups),
                                       "--json=" + report.path()};
  CyclictestRun result;
  for (const std::string& word : words) result.command += (&word == &words[0] ? "" : " ") + word;
  result.command.resize(result.command.rfind(" --json"));

  const int status = run(words, complaints.path());
  if (status == -ENOENT || status == 127) {
    result.why_not = "cyclictest is not installed (Debian package rt-tests)";
  } else if (status < 0) {
    result.why_not = std::string("cyclictest could not be started: ") + std::strerror(-status);
  } else if (status != 0) {
    std::istringstream lines(complaints.text());
    std::string line, last;
    while (std::getline(lines, line)) {
      if (!line.empty()) last = line;
    }
    result.why_not = "cyclictest ended with status " + std::to_string(status) + ": " + last;
  } else {
    try {
      result.lateness = lateness_in(nlohmann::json::parse(report.text()));
    } catch (const std::exception& problem) {
      result.why_not = std::string("cyclictest's report could not be read: ") + problem.what();
    }
  }
  return result;
}

}  // namespace tandem::bench
