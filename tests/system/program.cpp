#include "tests/system/program.h"

#include <algorithm>
#include <arpa/inet.h>
#include <chrono>
#include <csignal>
#include <fcntl.h>
#include <filesystem>
#include <fstream>
#include <netinet/in.h>
#include <poll.h>
#include <stdexcept>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>
#include <utility>

namespace tandem::test {
namespace {

[[nodiscard]] double now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace

Program::Program(std::vector<std::string> arguments, long file_limit) {
  // Not insert(): with some lengths of the path g++ 12 warns of an overflow that is none.
  arguments.emplace_back(TANDEM_PROGRAM);
  std::rotate(arguments.begin(), arguments.end() - 1, arguments.end());
  std::vector<char*> argv;
  for (std::string& a : arguments) argv.push_back(a.data());
  argv.push_back(nullptr);
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) throw std::runtime_error("pipe");
  pid_ = fork();
  if (pid_ == 0) {
    if (file_limit > 0) {
      const rlimit limit{static_cast<rlim_t>(file_limit), static_cast<rlim_t>(file_limit)};
      setrlimit(RLIMIT_FSIZE, &limit);
    }
    dup2(ends[1], STDOUT_FILENO);
    dup2(ends[1], STDERR_FILENO);
    execv(argv[0], argv.data());
    _exit(127);
  }
  close(ends[1]);
  pipe_ = ends[0];
}

Program::Program(Program&& other) noexcept
    : pid_(std::exchange(other.pid_, -1)),
      pipe_(std::exchange(other.pipe_, -1)),
      output_(std::move(other.output_)) {}

Program::~Program() {
  if (pid_ > 0) {
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
  }
  if (pipe_ >= 0) close(pipe_);
}

void Program::signal(int number) { kill(pid_, number); }

void Program::read_some(int timeout_ms) {
  pollfd end{.fd = pipe_, .events = POLLIN, .revents = 0};
  if (poll(&end, 1, timeout_ms) <= 0) return;
  char buffer[4096];
  const ssize_t got = read(pipe_, buffer, sizeof(buffer));
  if (got > 0)
    output_.append(buffer, static_cast<std::size_t>(got));
  else
    std::this_thread::sleep_for(std::chrono::milliseconds(timeout_ms));
}

int Program::wait(double seconds) {
  const double deadline = now() + seconds;
  int status = 0;
  while (waitpid(pid_, &status, WNOHANG) == 0) {
    if (now() > deadline) {
      kill(pid_, SIGKILL);
      waitpid(pid_, &status, 0);
      pid_ = -1;
      return -1;
    }
    read_some(20);
  }
  pid_ = -1;
  for (std::size_t size = output_.size() + 1; size != output_.size();) {
    size = output_.size();
    read_some(0);
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

bool Program::says(const std::string& text, double seconds) {
  const double deadline = now() + seconds;
  while (output_.find(text) == std::string::npos) {
    if (now() > deadline) return false;
    read_some(20);
  }
  return true;
}

std::string scratch(const std::string& name) {
  struct Folder {
    std::filesystem::path path =
        std::filesystem::temp_directory_path() / ("tandem-system-test-" + std::to_string(getpid()));
    Folder() { std::filesystem::create_directories(path); }
    ~Folder() {
      std::error_code ignored;
      std::filesystem::remove_all(path, ignored);
    }
  };
  static const Folder folder;
  return (folder.path / name).string();
}

std::string free_address() {
  const int s = socket(AF_INET, SOCK_DGRAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof(address);
  auto* const raw = reinterpret_cast<sockaddr*>(&address);
  if (bind(s, raw, size) != 0 || getsockname(s, raw, &size) != 0)
    throw std::runtime_error("no free port");
  close(s);
  return "127.0.0.1:" + std::to_string(ntohs(address.sin_port));
}

nlohmann::json json_in(const std::string& file) {
  std::ifstream in(file);
  return nlohmann::json::parse(in);
}

void sleep_seconds(double seconds) {
  std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
}

std::vector<std::string> node(std::vector<std::string> arguments) {
  for (const char* a : {"--no-memory-lock", "--status-every", "1000"}) arguments.emplace_back(a);
  return arguments;
}

}  // namespace tandem::test
