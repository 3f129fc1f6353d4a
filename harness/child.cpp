#include "harness/child.h"

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <poll.h>
#include <sched.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>
#include <utility>

#include "harness/harness_error.h"

namespace tandem::harness {
namespace {

using SteadyClock = std::chrono::steady_clock;

// tc and ip are there, and not in the PATH of every shell.
constexpr const char* kSystemFolders = "/usr/local/sbin:/usr/sbin:/sbin:/usr/bin:/bin";

[[nodiscard]] std::string folders() {
  const char* path = std::getenv("PATH");
  return (path != nullptr ? std::string(path) + ":" : std::string()) + kSystemFolders;
}

[[nodiscard]] std::string in_words(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : " ") + word;
  return text;
}

[[nodiscard]] int milliseconds_until(SteadyClock::time_point end) {
  const auto left = std::chrono::ceil<std::chrono::milliseconds>(end - SteadyClock::now()).count();
  return static_cast<int>(std::clamp<long long>(left, 0, 1000));
}

struct Ends {
  int read = -1, write = -1;
};

Ends make_pipe() {
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0)
    throw HarnessError(std::string("cannot make a pipe: ") + std::strerror(errno));
  return {ends[0], ends[1]};
}

/// In the child, between fork and exec.
[[noreturn]] void become(std::vector<char*>& argv, const std::vector<std::string>& environment,
                         pid_t parent, int network, int input, int output, Main main) {
  setpgid(0, 0);
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  if (getppid() != parent) _exit(1);
  if (network >= 0 && setns(network, CLONE_NEWNET) != 0) {
    dprintf(output, "cannot enter the network namespace: %s\n", std::strerror(errno));
    _exit(126);
  }
  dup2(input, STDIN_FILENO);
  dup2(output, STDOUT_FILENO);
  dup2(output, STDERR_FILENO);
  for (const std::string& entry : environment) putenv(const_cast<char*>(entry.c_str()));
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
  for (const int s : {SIGPIPE, SIGINT, SIGTERM}) std::signal(s, SIG_DFL);
  if (main != nullptr) {
    const int status = main(static_cast<int>(argv.size()) - 1, argv.data());
    std::fflush(nullptr);
    _exit(status);  // what our parent has to tidy up is not ours
  }
  execv(argv[0], argv.data());
  dprintf(STDERR_FILENO, "cannot run %s: %s\n", argv[0], std::strerror(errno));
  _exit(127);
}

}  // namespace

std::string find_program(const std::string& name) {
  if (name.find('/') != std::string::npos) return name;
  const std::string all = folders();
  for (std::size_t begin = 0; begin <= all.size();) {
    const std::size_t end = std::min(all.find(':', begin), all.size());
    const std::string path = all.substr(begin, end - begin) + "/" + name;
    if (access(path.c_str(), X_OK) == 0) return path;
    begin = end + 1;
  }
  return {};
}

Child::Child(std::vector<std::string> words, const ChildOptions& options) {
  const std::string program = find_program(words.at(0));
  if (program.empty())
    throw HarnessError("there is no program \"" + words[0] + "\" on this machine");
  int network = -1;
  if (!options.network.empty()) {
    const std::string file = "/run/netns/" + options.network;
    network = open(file.c_str(), O_RDONLY | O_CLOEXEC);
    if (network < 0)
      throw HarnessError("network namespace " + options.network + ": " + std::strerror(errno));
  }
  words[0] = program;
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);

  const Ends out = make_pipe();
  const Ends in =
      options.takes_input ? make_pipe() : Ends{open("/dev/null", O_RDONLY | O_CLOEXEC), -1};
  const pid_t parent = getpid();
  if (options.main != nullptr) std::fflush(nullptr);  // or both would write what waits
  pid_ = fork();
  if (pid_ == 0)
    become(argv, options.environment, parent, network, in.read, out.write, options.main);
  const int error = errno;
  close(out.write);
  close(in.read);
  if (network >= 0) close(network);
  output_ = out.read;
  input_ = in.write;
  if (pid_ < 0) {
    close(output_);
    if (input_ >= 0) close(input_);
    throw HarnessError("cannot start " + words[0] + ": " + std::strerror(error));
  }
  setpgid(pid_, pid_);  // whoever is first
}

Child::Child(Child&& other) noexcept { *this = std::move(other); }

Child& Child::operator=(Child&& other) noexcept {
  std::swap(pid_, other.pid_);
  std::swap(output_, other.output_);
  std::swap(input_, other.input_);
  std::swap(said_, other.said_);
  std::swap(status_, other.status_);
  return *this;
}

Child::~Child() {
  if (pid_ > 0 && !status_) {
    kill(-pid_, SIGKILL);
    reap(true);
  }
  if (output_ >= 0) close(output_);
  if (input_ >= 0) close(input_);
}

void Child::signal(int number) {
  if (running()) kill(-pid_, number);
}

bool Child::write(const std::string& text) {
  if (input_ < 0) return false;
  // A program that has gone must not take us with it. For good: others write in other threads.
  static const auto before = std::signal(SIGPIPE, SIG_IGN);
  static_cast<void>(before);
  std::size_t done = 0;
  while (done < text.size()) {
    const ssize_t n = ::write(input_, text.data() + done, text.size() - done);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) break;
    done += static_cast<std::size_t>(n);
  }
  return done == text.size();
}

void Child::end_input() {
  if (input_ >= 0) close(input_);
  input_ = -1;
}

void Child::reap(bool wait) {
  int status = 0;
  const pid_t got = waitpid(pid_, &status, wait ? 0 : WNOHANG);
  if (got == pid_) status_ = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  if (got < 0 && errno == ECHILD) status_ = 1;
}

bool Child::listen(int milliseconds) {
  if (!running()) return false;
  if (output_ >= 0) {
    pollfd end{.fd = output_, .events = POLLIN, .revents = 0};
    if (poll(&end, 1, milliseconds) <= 0) return true;
    char buffer[4096];
    const ssize_t n = read(output_, buffer, sizeof(buffer));
    if (n > 0) said_.append(buffer, static_cast<std::size_t>(n));
    if (n > 0 || (n < 0 && (errno == EINTR || errno == EAGAIN))) return true;
    close(output_);
    output_ = -1;
  }
  reap(false);
  if (!status_ && milliseconds > 0) poll(nullptr, 0, 1);  // it closed its output before its end
  return running();
}

std::optional<int> Child::wait(double seconds) {
  const auto end = SteadyClock::now() + std::chrono::duration_cast<SteadyClock::duration>(
                                            std::chrono::duration<double>(seconds));
  while (running() && SteadyClock::now() < end) listen(milliseconds_until(end));
  return status_;
}

Ended run_program(const std::vector<std::string>& words, const std::string& network,
                  const std::string& input) {
  constexpr double kLongest = 30.0;
  Child child(words, {.network = network, .environment = {}, .takes_input = !input.empty()});
  if (!input.empty()) {
    child.write(input);
    child.end_input();
  }
  if (!child.wait(kLongest)) {
    child.signal(SIGKILL);
    (void)child.wait(5.0);
  }
  return {child.status().value_or(128 + SIGKILL), child.said()};
}

void must_run(const std::vector<std::string>& words, const std::string& network,
              const std::string& input) {
  const Ended ended = run_program(words, network, input);
  if (ended.status != 0)
    throw HarnessError("`" + in_words(words) + "`" +
                       (network.empty() ? "" : " in network namespace " + network) +
                       " ended with " + std::to_string(ended.status) + ": " + ended.said);
}

}  // namespace tandem::harness
