#include "harness/caretaker.h"

#include <atomic>
#include <csignal>
#include <fcntl.h>
#include <filesystem>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>
#include <vector>

#include "harness/namespaces.h"

namespace tandem::harness {
namespace {

std::atomic<bool> interruption{false};
extern "C" void note_interruption(int) { interruption.store(true); }

/// The caretaker's life: one duty a line, done when the pipe ends.
void take_care(int pipe) {
  std::string told;
  char buffer[1024];
  for (ssize_t n; (n = read(pipe, buffer, sizeof(buffer))) != 0;)
    if (n > 0) told.append(buffer, static_cast<std::size_t>(n));
  std::vector<std::string> duties;
  for (std::size_t end; (end = told.find('\n')) != std::string::npos; told.erase(0, end + 1)) {
    const std::string duty = told.substr(0, end);
    if (duty == "forget")
      duties.clear();
    else if (duty[0] == '-')
      std::erase(duties, duty.substr(1));
    else
      duties.push_back(duty);
  }
  // Nobody shall write into a folder that is being removed.
  for (const std::string& duty : duties)
    if (duty[0] == 'g') kill(-std::stoi(duty.substr(2)), SIGKILL);
  for (const std::string& duty : duties) {
    const std::string what = duty.substr(2);
    if (duty[0] == 'n') remove_namespaces({what});
    std::error_code ignored;
    if (duty[0] == 'f') std::filesystem::remove_all(what, ignored);
  }
}

}  // namespace

Caretaker& Caretaker::instance() {
  static Caretaker caretaker;
  return caretaker;
}

bool Caretaker::interrupted() { return interruption.load(); }

void Caretaker::listen() {
  struct sigaction action {};
  action.sa_handler = note_interruption;
  sigemptyset(&action.sa_mask);
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  // A program that has gone must not take us with it when we write to it.
  action.sa_handler = SIG_IGN;
  sigaction(SIGPIPE, &action, nullptr);
}

Caretaker::Caretaker() {
  listen();
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) return;
  pid_ = fork();
  if (pid_ == 0) {
    close(ends[1]);
    // Neither Ctrl-C nor the end of the terminal is for us, and who reads our parent's output must
    // not wait for us.
    setsid();
    for (const int s : {SIGINT, SIGTERM, SIGHUP}) std::signal(s, SIG_IGN);
    const int nowhere = open("/dev/null", O_RDWR);
    for (const int fd : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) dup2(nowhere, fd);
    prctl(PR_SET_NAME, "tandem-caretaker");
    take_care(ends[0]);
    _exit(0);
  }
  close(ends[0]);
  pipe_ = ends[1];
}

Caretaker::~Caretaker() {
  if (pipe_ >= 0) close(pipe_);
  if (pid_ > 0) waitpid(pid_, nullptr, 0);
}

void Caretaker::tell(const std::string& line) {
  if (pipe_ >= 0 && write(pipe_, (line + "\n").c_str(), line.size() + 1) < 0)
    close(pipe_), pipe_ = -1;
}

void Caretaker::kill_group_at_end(pid_t leader) { tell("g " + std::to_string(leader)); }
void Caretaker::remove_folder_at_end(const std::string& folder) { tell("f " + folder); }
void Caretaker::remove_namespace_at_end(const std::string& name) { tell("n " + name); }
void Caretaker::namespace_is_removed(const std::string& name) { tell("-n " + name); }
void Caretaker::group_has_ended(pid_t leader) { tell("-g " + std::to_string(leader)); }
void Caretaker::folder_is_removed(const std::string& folder) { tell("-f " + folder); }
void Caretaker::forget() { tell("forget"); }

}  // namespace tandem::harness
