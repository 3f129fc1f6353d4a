#include "cli/demo_nodes.h"

#include <arpa/inet.h>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <fstream>
#include <netinet/in.h>
#include <optional>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fmt/format.h>

#include "cli/commands.h"
#include "cli/demo_viewer.h"
#include "cli/options.h"
#include "harness/node_plan.h"
#include "scene/scene_text.h"

namespace tandem::cli {
namespace {

/// Ports nobody uses at the moment; kept until destruction so that all are different.
class FreePorts {
 public:
  ~FreePorts() {
    for (const int s : sockets_) close(s);
  }
  [[nodiscard]] std::string next() {
    const int s = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof(address);
    sockaddr* const raw = reinterpret_cast<sockaddr*>(&address);
    if (s < 0 || bind(s, raw, size) != 0 || getsockname(s, raw, &size) != 0)
      throw Failed(std::string("no free UDP port on 127.0.0.1: ") + std::strerror(errno));
    sockets_.push_back(s);
    return fmt::format("127.0.0.1:{}", ntohs(address.sin_port));
  }

 private:
  std::vector<int> sockets_;
};

struct Child {
  DemoNode node;
  std::string address;
  std::string report_file;
  std::vector<std::string> words;  ///< command line
  pid_t pid = -1;
  int stderr_pipe = -1;
  std::string unfinished;  ///< line being read
  std::string status;      ///< newest status line
  std::string said;        ///< everything else on stderr
  int exit_status = -1;
};

std::atomic<int> end_signal{0};
extern "C" void pass_on(int signal) { end_signal.store(signal); }

/// SIGINT and SIGTERM are passed on to the nodes while it lives.
class PassSignals {
 public:
  PassSignals() {
    end_signal = 0;
    struct sigaction action {};
    action.sa_handler = pass_on;
    sigemptyset(&action.sa_mask);
    sigaction(SIGINT, &action, &before_[0]);
    sigaction(SIGTERM, &action, &before_[1]);
  }
  ~PassSignals() {
    sigaction(SIGINT, &before_[0], nullptr);
    sigaction(SIGTERM, &before_[1], nullptr);
  }
  PassSignals(const PassSignals&) = delete;
  PassSignals& operator=(const PassSignals&) = delete;

 private:
  struct sigaction before_[2];
};

std::vector<Child> plan(const DemoRun& run) {
  FreePorts ports;
  std::vector<std::string> addresses;
  for (int i = harness::node_count(run.scene); i > 0; --i) addresses.push_back(ports.next());
  harness::NodePlan all;
  all.scene_file = run.scene_file;
  all.base = run.folder + "/" + run.prefix;
  all.seconds = run.seconds;
  all.address_of = [&](int i) { return addresses[static_cast<std::size_t>(i)]; };
  all.more = run.node_arguments;
  all.more.insert(all.more.end(),
                  {"--status-every", "0.5", "--start-ns", std::to_string(run.start_ns)});
  std::vector<Child> children;
  for (harness::PlannedNode& node : harness::plan_nodes(run.scene, all)) {
    Child& child = children.emplace_back();
    child.address = addresses[children.size() - 1];
    child.node = {node.name, node.user, node.recording, {}};
    child.report_file = node.report_file;
    child.words = {"/proc/self/exe"};
    child.words.insert(child.words.end(), node.words.begin(), node.words.end());
  }
  return children;
}

void start(Child& child) {
  std::vector<char*> argv;
  for (std::string& word : child.words) argv.push_back(word.data());
  argv.push_back(nullptr);
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) throw Failed(std::string("pipe: ") + std::strerror(errno));
  const pid_t parent = getpid();
  child.pid = fork();
  if (child.pid < 0) throw Failed(std::string("fork: ") + std::strerror(errno));
  if (child.pid == 0) {
    // In a group of its own: Ctrl-C would reach it from the terminal and again from us, and a node
    // takes the second signal as "at once, never mind the recording".
    setpgid(0, 0);
    prctl(PR_SET_PDEATHSIG, SIGTERM);
    if (getppid() != parent) _exit(1);
    const int nowhere = open("/dev/null", O_RDWR);
    dup2(nowhere, STDIN_FILENO);
    dup2(nowhere, STDOUT_FILENO);
    dup2(ends[1], STDERR_FILENO);
    execv(argv[0], argv.data());
    _exit(127);
  }
  close(ends[1]);
  child.stderr_pipe = ends[0];
}

/// Takes what a node has said; false when it has closed its end. What the first node was not
/// granted is passed on to whoever looks on.
bool listen_to(Child& child, bool first) {
  char buffer[4096];
  const ssize_t got = read(child.stderr_pipe, buffer, sizeof(buffer));
  if (got < 0) return errno == EINTR || errno == EAGAIN;
  if (got == 0) return false;
  child.unfinished.append(buffer, static_cast<std::size_t>(got));
  for (std::size_t end; (end = child.unfinished.find('\n')) != std::string::npos;) {
    const std::string line = child.unfinished.substr(0, end);
    child.unfinished.erase(0, end + 1);
    constexpr std::string_view kStatus = "status: ";
    if (line.starts_with(kStatus))
      child.status = line.substr(kStatus.size());
    else
      child.said += line + "\n";
    // Every node asks for the same; the first one's answer is enough.
    if (first && line.find("not granted") != std::string::npos)
      std::fprintf(stderr, "%s\n", line.c_str());
  }
  return true;
}

/// One line a node: redrawn in place on a terminal, else every five seconds.
class Display {
 public:
  void show(const std::vector<Child>& children) {
    const auto now = std::chrono::steady_clock::now();
    if (now < next_) return;
    const bool terminal = isatty(STDOUT_FILENO) == 1 && isatty(STDERR_FILENO) == 1;
    next_ = now + std::chrono::milliseconds(terminal ? 250 : 5000);
    if (terminal && drawn_) std::fprintf(stderr, "\033[%zuA", children.size());
    for (const Child& child : children)
      if (terminal)
        std::fprintf(stderr, "\r\033[K%.*s\n", 230, child.status.c_str());
      else if (!child.status.empty())
        std::fprintf(stderr, "%s\n", child.status.c_str());
    std::fflush(stderr);
    drawn_ = terminal;
  }

 private:
  std::chrono::steady_clock::time_point next_{};
  bool drawn_ = false;
};

void watch(std::vector<Child>& children) {
  Display display;
  bool passed = false;
  std::size_t open = children.size();
  while (open > 0) {
    std::vector<pollfd> ends;
    for (const Child& child : children)
      ends.push_back({.fd = child.stderr_pipe, .events = POLLIN, .revents = 0});
    poll(ends.data(), ends.size(), 100);
    for (std::size_t i = 0; i < children.size(); ++i) {
      if (children[i].stderr_pipe < 0 || ends[i].revents == 0 || listen_to(children[i], i == 0))
        continue;
      close(children[i].stderr_pipe);
      children[i].stderr_pipe = -1;
      --open;
      int status = 0;
      waitpid(children[i].pid, &status, 0);
      children[i].exit_status = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
      // One that fails ends the run: the others would go on with nobody to meet.
      if (children[i].exit_status != 0) end_signal = SIGTERM;
    }
    if (end_signal != 0 && !passed) {
      for (const Child& child : children)
        if (child.exit_status < 0) kill(child.pid, SIGTERM);
      passed = true;
    }
    display.show(children);
  }
}

}  // namespace

std::vector<DemoNode> run_nodes(const DemoRun& run) {
  write_text(run.scene_file, scene::to_text(run.scene));
  std::vector<Child> children = plan(run);
  const PassSignals signals;
  for (Child& child : children) start(child);
  std::optional<DemoViewer> viewer;
  if (!run.view_picture.empty()) {
    // A quarter on, in the middle of the first carry; the nodes start two seconds from now.
    constexpr double kUntilStart = 2.0;
    viewer.emplace(children.front().address, run.view_picture, kUntilStart + 0.25 * run.seconds);
  }
  watch(children);

  std::vector<DemoNode> nodes;
  for (Child& child : children) {
    if (child.exit_status != 0)
      throw Failed(
          fmt::format("{} ended with {}:\n{}", child.node.name, child.exit_status, child.said));
    std::ifstream file(child.report_file);
    child.node.report = nlohmann::ordered_json::parse(file);
    child.node.report["said"] = child.said;
    nodes.push_back(child.node);
  }
  if (end_signal != 0)
    throw Failed("stopped before its end; what was recorded until then is in " + run.folder + "/");
  return nodes;
}

}  // namespace tandem::cli
