#include "bench/cyclictest.h"

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <fstream>
#include <sstream>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>
#include <vector>

#include <nlohmann/json.hpp>

namespace tandem::bench {
namespace {

constexpr std::int64_t kHistogram = 1'000'000;  // cells, the most that cyclictest takes

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
/// status, 127 when there is no such program, or the negative error of starting it.
int run(const std::vector<std::string>& words, const std::string& complaints,
        const std::stop_token& stop) {
  std::vector<char*> argv;
  for (const std::string& word : words) argv.push_back(const_cast<char*>(word.c_str()));
  argv.push_back(nullptr);
  const pid_t parent = getpid();
  const pid_t child = fork();
  if (child < 0) return -errno;
  if (child == 0) {
    prctl(PR_SET_PDEATHSIG, SIGTERM);  // nobody is left who would wait for it
    if (getppid() != parent) _exit(1);
    dup2(open("/dev/null", O_WRONLY), STDOUT_FILENO);
    dup2(open(complaints.c_str(), O_WRONLY), STDERR_FILENO);
    execvp(argv[0], argv.data());
    _exit(127);
  }
  {
    const std::stop_callback end(stop, [child] { kill(child, SIGTERM); });
    siginfo_t ended;  // left unreaped: until the callback is gone its number must stay its own
    while (waitid(P_PID, static_cast<id_t>(child), &ended, WEXITED | WNOWAIT) < 0 && errno == EINTR)
      ;
  }
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR)
    ;
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

void add_wakeups(CyclictestRun& run, std::int64_t late_ns, std::int64_t count,
                 std::int64_t period_ns) {
  for (std::int64_t i = 0; i < count; ++i) run.lateness->record(late_ns);
  if (late_ns < period_ns) return;
  run.late_wakeups += count;
  run.periods_missed += count * (late_ns / period_ns);
}

void read_report(const nlohmann::json& report, const CyclictestOptions& options,
                 CyclictestRun& run) {
  const std::int64_t unit_ns = options.nanoseconds ? 1 : 1000;
  const std::int64_t period_ns = 1000 * options.interval_us;
  run.lateness.emplace();
  for (const auto& [number, thread] : report.at("thread").items()) {
    std::int64_t in_histogram = 0;
    for (const auto& [late, count] : thread.at("histogram").items()) {
      add_wakeups(run, unit_ns * std::stoll(late), count.get<std::int64_t>(), period_ns);
      in_histogram += count.get<std::int64_t>();
    }
    // Beyond the histogram only the greatest is known. The others count as just beyond it, or what
    // our loops are compared with would look worse than it was.
    std::int64_t beyond = thread.at("cycles").get<std::int64_t>() - in_histogram;
    if (beyond <= 0) continue;
    add_wakeups(run, unit_ns * thread.at("max").get<std::int64_t>(), 1, period_ns);
    add_wakeups(run, unit_ns * kHistogram, beyond - 1, period_ns);
  }
}

}  // namespace

CyclictestRun run_cyclictest(const CyclictestOptions& options, const std::stop_token& stop) {
  const TemporaryFile report, complaints;
  std::vector<std::string> words{"cyclictest", "--quiet", "--mlockall"};
  if (options.nanoseconds) words.push_back("--nsecs");
  words.insert(
      words.end(),
      {"--histogram=" + std::to_string(kHistogram), "--threads=" + std::to_string(options.threads),
       "--distance=0", "--priority=" + std::to_string(options.priority),
       "--interval=" + std::to_string(options.interval_us),
       "--loops=" + std::to_string(options.wakeups), "--json=" + report.path()});
  CyclictestRun result;
  for (const std::string& word : words) result.command += (&word == &words[0] ? "" : " ") + word;
  result.command.resize(result.command.rfind(" --json"));

  const int status = run(words, complaints.path(), stop);
  if (status == 127) {
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
      read_report(nlohmann::json::parse(report.text()), options, result);
    } catch (const std::exception& problem) {
      result.lateness.reset();
      result.why_not = std::string("cyclictest's report could not be read: ") + problem.what();
    }
  }
  return result;
}

}  // namespace tandem::bench
